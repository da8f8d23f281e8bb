// Bytes that Weir's elements of the pipeline copied, by their ledgers.
#pragma once
#include "weir/pipeline.hpp"

namespace mtcnn {

uint64_t bytes_copied(const weir::Pipeline& pipeline);

}  // namespace mtcnn
