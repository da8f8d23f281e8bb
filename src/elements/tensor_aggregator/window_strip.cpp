// WindowStrip: a full block is replaced by one that starts with the frames of the next window.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_aggregator/window_strip.hpp"

#include <algorithm>
#include <cstring>

namespace weir {
namespace {

// A longer strip copies fewer frames twice, but a window that is kept holds the whole block.
constexpr uint64_t kMostWindows = 8, kLeastWindows = 2;
constexpr size_t kWantedBytes = size_t{64} << 20;

}  // namespace

WindowStrip::WindowStrip(size_t frame_bytes, uint64_t frames)
    : frame_bytes_(frame_bytes), frames_(frames) {
  const size_t window = std::max<size_t>(frame_bytes * static_cast<size_t>(frames), 1);
  capacity_ = frames * std::clamp<uint64_t>(kWantedBytes / window, kLeastWindows, kMostWindows);
  pool_ = BlockPool::make(frame_bytes * static_cast<size_t>(capacity_));
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
