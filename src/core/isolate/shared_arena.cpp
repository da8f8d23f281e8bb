// Manages blocks by size and by address.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/shared_arena.hpp"

#include <algorithm>
#include <functional>

namespace weir::isolate {

std::shared_ptr<SharedArena> SharedArena::make(size_t padding) {
  return std::shared_ptr<SharedArena>(new SharedArena(padding));
}

std::shared_ptr<SharedBlock> SharedArena::allocate(size_t bytes) {
  size_t needed = 0;
  if (__builtin_add_overflow(bytes, padding_, &needed)) return nullptr;
  const auto lend = [this](const std::shared_ptr<SharedBlock>& block) {
    return std::shared_ptr<SharedBlock>(
        block.get(), [arena = shared_from_this()](SharedBlock* b) { arena->give_back(b); });
  };
  {
    std::lock_guard lock(mutex_);
    const size_t min = std::max(needed, SharedBlock::kPage);
    const auto fits = [min](const SharedBlock* block) {
      return block->bytes() >= min && block->bytes() / 2 <= min;
    };
    const auto found = std::find_if(free_.begin(), free_.end(), fits);
    if (found != free_.end()) {
      const auto block = blocks_.at((*found)->data());
      free_.erase(found);
      return lend(block);
    }
    if (blocks_.size() >= kMaxBlocks) {
      if (free_.empty()) return nullptr;
      blocks_.erase(free_.front()->data());
      free_.erase(free_.begin());
    }
    free_.reserve(blocks_.size() + 1);  // so that releasing cannot fail
  }
  auto made = SharedBlock::create(needed, Sharing::ReadByWorker);
  if (!made) return nullptr;
  {
    std::lock_guard lock(mutex_);
    blocks_.emplace((*made)->data(), *made);
  }
  return lend(*made);
}

void SharedArena::give_back(const SharedBlock* block) noexcept {
  std::lock_guard lock(mutex_);
  if (free_.size() >= kRetained) {  // the oldest free block has a size that is not used any more
    blocks_.erase(free_.front()->data());
    free_.erase(free_.begin());
  }
  free_.push_back(block);
}

std::optional<SharedArena::Place> SharedArena::find(const void* data, size_t bytes) const {
  const auto* at = static_cast<const std::byte*>(data);
  std::lock_guard lock(mutex_);
  auto after = blocks_.upper_bound(at);
  if (after == blocks_.begin()) return std::nullopt;
  const auto& block = std::prev(after)->second;
  const auto offset = static_cast<size_t>(at - block->data());
  if (offset > block->bytes() || bytes > block->bytes() - offset) return std::nullopt;
  return Place{block, offset, block->bytes() - offset};
}

}  // namespace weir::isolate
