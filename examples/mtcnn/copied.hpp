// Bytes that Weir's elements of the pipeline copied, by their ledgers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/pipeline.hpp"

namespace mtcnn {

uint64_t bytes_copied(const weir::Pipeline& pipeline);

}  // namespace mtcnn
