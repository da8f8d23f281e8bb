// WindowStrip: the consecutive frames of one tensor, so that overlapping windows are parts of the
// same memory and each byte is copied once.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace weir {

// StripPool: blocks of memory that buffers share, reused when the last of them is released.

class StripPool : public std::enable_shared_from_this<StripPool> {
 public:
  // Size of each block in bytes; blocks are aligned to 64 bytes.
  static std::shared_ptr<StripPool> make(size_t bytes, size_t retain = 2);
  ~StripPool();
  StripPool(const StripPool&) = delete;
  StripPool& operator=(const StripPool&) = delete;

  // The bytes are uninitialised. Throws bad_alloc.
  std::shared_ptr<std::byte> take();
  size_t bytes() const noexcept { return bytes_; }

 private:
  StripPool(size_t bytes, size_t retain);
  void give_back(std::byte* block) noexcept;

  const size_t bytes_, retain_;
  std::mutex mutex_;  // guards free_
  std::vector<std::byte*> free_;
};

// Read-only memory for a part of a block; it keeps the block alive.
GstMemory* part_of_block(std::shared_ptr<std::byte> block, size_t offset, size_t bytes);

// WindowStrip: the consecutive frames of one tensor, so that overlapping windows are parts of the
// same memory and each byte is copied once.

class WindowStrip {
 public:
  WindowStrip() = default;
  // `frame_bytes` per frame, `frames` per window.
  WindowStrip(size_t frame_bytes, uint64_t frames);

  // Returns the window that begins at frame `begin`; windows begin in ascending order. `frame`
  // reads frames that the strip does not have, and their bytes are added to `copied`.
  using ReadFrame = std::function<std::span<const std::byte>(uint64_t)>;
  GstMemory* window(uint64_t begin, const ReadFrame& frame, uint64_t* copied);
  void clear() noexcept { block_.reset(); }

 private:
  size_t frame_bytes_ = 0;
  uint64_t frames_ = 0;
  uint64_t capacity_ = 0;  // frames
  std::shared_ptr<StripPool> pool_;
  std::shared_ptr<std::byte> block_;
  uint64_t begin_ = 0, end_ = 0;  // the range of frames in the block
};

}  // namespace weir
