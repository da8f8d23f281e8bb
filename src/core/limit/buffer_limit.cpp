// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/limit/buffer_limit.hpp"

#include <algorithm>
#include <string>

namespace weir {
namespace {

// 0 if a size is unknown; the maximum value if it cannot be represented.
uint64_t count_bytes(const FrameSpec& spec) {
  const bool known = std::ranges::all_of(spec.tensors, &TensorSpec::valid);
  return known ? spec.bytes().value_or(UINT64_MAX) : 0;
}

}  // namespace

Error BufferLimit::exceeded(const char* what, uint64_t bytes) const {
  return Error{.code = Code::LIMIT_EXCEEDED,
               .what = std::string(what) + " of " + element_ + " is larger than max-buffer-size",
               .offered = std::to_string(bytes) + " bytes",
               .needed = "at most " + std::to_string(bytes_) + " bytes",
               .difference = {},
               .fix = std::string(element_) + " max-buffer-size=" + std::to_string(bytes)};
}

Status BufferLimit::check(uint64_t bytes) const {
  return allows(bytes) ? ok() : Status(exceeded("an output buffer", bytes));
}

Status BufferLimit::check(const FrameSpec& spec) const {
  return check(count_bytes(spec));
}

Status BufferLimit::check_input(const FrameSpec& spec) const {
  const uint64_t bytes = count_bytes(spec);
  return allows(bytes) ? ok() : Status(exceeded("an input frame", bytes));
}

}  // namespace weir
