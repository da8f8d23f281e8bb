// BufferLimit: the largest output buffer of an element; the property max-buffer-size.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>
#include <cstdint>

#include "core/tensor/frame_spec.hpp"
#include "weir/result.hpp"

namespace weir {

// A few bytes of input can request an output of any size (a sparse tensor of zeros, regions, a
// model with open shapes), so elements check the size before they allocate. Thread-safe.
class BufferLimit {
 public:
  static constexpr uint64_t kDefaultBytes = uint64_t{1} << 30;

  // `element` is the factory name and must outlive this object.
  explicit BufferLimit(const char* element) noexcept : element_(element) {}

  uint64_t bytes() const noexcept { return bytes_; }  // 0: no limit
  void set_bytes(uint64_t bytes) noexcept { bytes_ = bytes; }

  // LIMIT_EXCEEDED if an output buffer of `bytes` exceeds the limit.
  Status check(uint64_t bytes) const;
  // The same for the tensors of `spec`; OK if their sizes are unknown.
  Status check(const FrameSpec& spec) const;
  // The same for an incoming frame, before anything is allocated for it.
  Status check_input(const FrameSpec& spec) const;

 private:
  Error exceeded(const char* what, uint64_t bytes) const;
  bool allows(uint64_t bytes) const noexcept { return bytes_ == 0 || bytes <= bytes_; }

  const char* element_;
  std::atomic<uint64_t> bytes_{kDefaultBytes};
};

}  // namespace weir
