// BlockPool: reusable memory blocks of one size. Never waits; retains a bounded number.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <memory>
#include <mutex>
#include <new>
#include <vector>

namespace weir::infer {

class BlockPool {
 public:
  // `alignment`: a power of two; `retain`: the number of free blocks to keep.
  BlockPool(size_t bytes, size_t alignment, size_t retain) : state_(std::make_shared<State>()) {
    state_->bytes = bytes;
    state_->alignment = std::align_val_t{alignment};
    state_->retain = retain;
    state_->free_blocks.reserve(retain);
  }
  // Returns a block with indeterminate content. It returns to the pool when its last owner releases
  // it, on any thread, also after the pool is gone. Null when out of memory.
  std::shared_ptr<std::byte> take() {
    std::byte* block = nullptr;
    {
      std::lock_guard lock(state_->mutex);
      if (!state_->free_blocks.empty()) {
        block = state_->free_blocks.back().release();
        state_->free_blocks.pop_back();
      }
    }
    if (!block)
      block = static_cast<std::byte*>(
          ::operator new(state_->bytes ? state_->bytes : 1, state_->alignment, std::nothrow));
    if (!block) return {};
    return {block, [state = state_](std::byte* returned) {
              give_back(*state, Block(returned, Free{state->alignment}));
            }};
  }
  size_t bytes() const noexcept { return state_->bytes; }

 private:
  struct Free {
    std::align_val_t alignment;
    void operator()(std::byte* block) const noexcept { ::operator delete(block, alignment); }
  };
  using Block = std::unique_ptr<std::byte, Free>;
  struct State {
    size_t bytes = 0, retain = 0;
    std::align_val_t alignment{1};
    std::mutex mutex;  // guards free_blocks
    std::vector<Block> free_blocks;
  };
  static void give_back(State& state, Block block) noexcept {
    std::lock_guard lock(state.mutex);
    if (state.free_blocks.size() < state.retain) state.free_blocks.push_back(std::move(block));
  }
  std::shared_ptr<State> state_;
};

}  // namespace weir::infer
