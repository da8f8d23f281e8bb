// SharedArena: allocates frames in memory that worker processes read in place.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "core/isolate/shared_block.hpp"

namespace weir::isolate {

// Thread-safe. Keeps a bounded number of released blocks for frames of the same size.
class SharedArena : public std::enable_shared_from_this<SharedArena> {
 public:
  static constexpr size_t kMaxBlocks = 128;  // each holds a file descriptor
  static constexpr size_t kRetained = 16;

  // `padding`: readable bytes after each frame.
  static std::shared_ptr<SharedArena> make(size_t padding);

  // Memory for one frame, page-aligned; null if unavailable. It returns to the arena automatically
  // and keeps it alive.
  std::shared_ptr<SharedBlock> allocate(size_t bytes);

  struct Place {
    std::shared_ptr<SharedBlock> block;
    size_t offset, capacity;  // capacity: readable bytes from there on
  };
  // Locates these bytes; nullopt if they are not in this arena.
  std::optional<Place> find(const void* data, size_t bytes) const;

 private:
  explicit SharedArena(size_t padding) : padding_(padding) {}
  void give_back(const SharedBlock* block) noexcept;

  const size_t padding_;
  mutable std::mutex mutex_;                                         // guards the rest
  std::map<const std::byte*, std::shared_ptr<SharedBlock>> blocks_;  // by first byte; all
  std::vector<const SharedBlock*> free_;                             // subset of blocks_
};

}  // namespace weir::isolate
