// A block is a std::shared_ptr whose deleter returns it to the pool.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_aggregator/shared_blocks.hpp"

#include <new>

namespace weir {
namespace {

constexpr std::align_val_t kAlignment{64};

}  // namespace

BlockPool::BlockPool(size_t bytes, size_t retain) : bytes_(bytes), retain_(retain) {
  free_.reserve(retain);
}

std::shared_ptr<BlockPool> BlockPool::make(size_t bytes, size_t retain) {
  return std::shared_ptr<BlockPool>(new BlockPool(bytes, retain));
}

BlockPool::~BlockPool() {
  for (std::byte* block : free_) ::operator delete(block, kAlignment);
}

std::shared_ptr<std::byte> BlockPool::take() {
  std::byte* block = nullptr;
  {
    std::lock_guard lock(mutex_);
    if (!free_.empty()) {
      block = free_.back();
      free_.pop_back();
    }
  }
  if (!block) block = static_cast<std::byte*>(::operator new(bytes_, kAlignment));
  // The deleter keeps the pool alive.
  return {block, [pool = shared_from_this()](std::byte* b) { pool->give_back(b); }};
}

void BlockPool::give_back(std::byte* block) noexcept {
  {
    std::lock_guard lock(mutex_);
    if (free_.size() < retain_) {
      free_.push_back(block);
      return;
    }
  }
  ::operator delete(block, kAlignment);
}

GstMemory* part_of_block(std::shared_ptr<std::byte> block, size_t offset, size_t bytes) {
  std::byte* at = block.get() + offset;
  using Holder = std::shared_ptr<std::byte>;
  auto holder = std::make_unique<Holder>(std::move(block));
  // maxsize ends with the part: the rest of the block is still being written.
  return gst_memory_new_wrapped(GST_MEMORY_FLAG_READONLY, at, bytes, 0, bytes, holder.release(),
                                [](gpointer data) { delete static_cast<Holder*>(data); });
}

}  // namespace weir
