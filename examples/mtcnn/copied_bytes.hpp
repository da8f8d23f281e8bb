// Sums the bytes that Weir's elements of a pipeline have copied, according to their ledgers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "weir/pipeline.hpp"

namespace mtcnn {

uint64_t bytes_copied(const weir::Pipeline& pipeline);

}  // namespace mtcnn
