// BlockPool: blocks of memory that buffers share, reused when the last of them is released.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

namespace weir {

class BlockPool : public std::enable_shared_from_this<BlockPool> {
 public:
  // Size of each block in bytes; blocks are aligned to 64 bytes.
  static std::shared_ptr<BlockPool> make(size_t bytes, size_t retain = 2);
  ~BlockPool();
  BlockPool(const BlockPool&) = delete;
  BlockPool& operator=(const BlockPool&) = delete;

  // The bytes are uninitialised. Throws bad_alloc.
  std::shared_ptr<std::byte> take();
  size_t bytes() const noexcept { return bytes_; }

 private:
  BlockPool(size_t bytes, size_t retain);
  void give_back(std::byte* block) noexcept;

  const size_t bytes_, retain_;
  std::mutex mutex_;  // guards free_
  std::vector<std::byte*> free_;
};

// Read-only memory for a part of a block; it keeps the block alive.
GstMemory* part_of_block(std::shared_ptr<std::byte> block, size_t offset, size_t bytes);

}  // namespace weir
