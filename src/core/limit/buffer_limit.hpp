// BufferLimit: how large an output buffer of an element may be; the property max-buffer-size.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>
#include <cstdint>

#include "core/tensor/frame_spec.hpp"
#include "weir/result.hpp"

namespace weir {

// A few bytes of input can ask for an output of any size: a sparse tensor of zeros, regions, a
// model of open shapes. An element checks what it is about to allocate. Thread-safe.
class BufferLimit {
 public:
  static constexpr uint64_t kDefaultBytes = uint64_t{1} << 30;

  // `element` is the name of the factory and outlives this object.
  explicit BufferLimit(const char* element) noexcept : element_(element) {}

  uint64_t bytes() const noexcept { return bytes_; }  // 0: no limit
  void set_bytes(uint64_t bytes) noexcept { bytes_ = bytes; }

  // LIMIT_EXCEEDED when an output buffer of `bytes` is larger than the limit.
  Status check(uint64_t bytes) const;
  // The same for a buffer of the tensors of `spec`; OK for a spec whose sizes are not known.
  Status check(const FrameSpec& spec) const;
  // The same for a frame that comes in, before anything is allocated for it.
  Status check_input(const FrameSpec& spec) const;

 private:
  Error exceeded(const char* what, uint64_t bytes) const;
  bool allows(uint64_t bytes) const noexcept { return bytes_ == 0 || bytes <= bytes_; }

  const char* element_;
  std::atomic<uint64_t> bytes_{kDefaultBytes};
};

}  // namespace weir
