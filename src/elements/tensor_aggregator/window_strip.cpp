// WindowStrip: a full block is replaced by one that starts with the frames of the next window.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_aggregator/window_strip.hpp"

#include <algorithm>
#include <cstring>
#include <new>

namespace weir {
namespace {

constexpr std::align_val_t kAlignment{64};

// A longer strip copies fewer frames twice, but a window that is kept holds the whole block.
constexpr uint64_t kMaxWindows = 8, kMinWindows = 2;
constexpr size_t kWantedBytes = size_t{64} << 20;

}  // namespace

StripPool::StripPool(size_t bytes, size_t retain) : bytes_(bytes), retain_(retain) {
  free_.reserve(retain);
}

std::shared_ptr<StripPool> StripPool::make(size_t bytes, size_t retain) {
  return std::shared_ptr<StripPool>(new StripPool(bytes, retain));
}

StripPool::~StripPool() {
  for (std::byte* block : free_) ::operator delete(block, kAlignment);
}

std::shared_ptr<std::byte> StripPool::take() {
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

void StripPool::give_back(std::byte* block) noexcept {
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

WindowStrip::WindowStrip(size_t frame_bytes, uint64_t frames)
    : frame_bytes_(frame_bytes), frames_(frames) {
  const size_t window = std::max<size_t>(frame_bytes * static_cast<size_t>(frames), 1);
  capacity_ = frames * std::clamp<uint64_t>(kWantedBytes / window, kMinWindows, kMaxWindows);
  pool_ = StripPool::make(frame_bytes * static_cast<size_t>(capacity_));
}

GstMemory* WindowStrip::window(uint64_t begin, const ReadFrame& frame, uint64_t* copied) {
  if (!block_ || begin < begin_ || begin > end_ || begin + frames_ - begin_ > capacity_) {
    block_.reset();
    block_ = pool_->take();
    begin_ = end_ = begin;
  }
  for (; end_ < begin + frames_; ++end_) {
    const auto bytes = frame(end_);
    std::memcpy(block_.get() + static_cast<size_t>(end_ - begin_) * frame_bytes_, bytes.data(),
                bytes.size());
    *copied += bytes.size();
  }
  return part_of_block(block_, static_cast<size_t>(begin - begin_) * frame_bytes_,
                       static_cast<size_t>(frames_) * frame_bytes_);
}

}  // namespace weir
