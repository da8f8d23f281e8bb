// Appends bytes to a message.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/message.hpp"

namespace weir::isolate {

void MessageWriter::append(const void* from, size_t size) {
  const size_t at = bytes_.size();
  bytes_.resize(at + size);
  if (size > 0) std::memcpy(bytes_.data() + at, from, size);
}

}  // namespace weir::isolate
