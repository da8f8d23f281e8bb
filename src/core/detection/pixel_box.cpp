// Converts candidates to whole pixels.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/pixel_box.hpp"

#include <algorithm>

namespace weir::detection {
namespace {

int32_t truncated(float value) noexcept {
  constexpr float kFar = 0x1p30f;  // a sum of two of them fits into 32 bits
  return static_cast<int32_t>(std::clamp(value, -kFar, kFar - 64));
}

}  // namespace

PixelBox to_pixels(const Candidate& candidate, Limits limits, PictureSize picture) noexcept {
  PixelBox box{truncated(candidate.x),
               truncated(candidate.y),
               truncated(candidate.width),
               truncated(candidate.height),
               candidate.class_index,
               candidate.score,
               candidate.angle};
  if (limits == Limits::None) return box;
  box.x = std::max(box.x, 0);
  box.y = std::max(box.y, 0);
  if (limits == Limits::Corner) return box;
  box.width = std::min(box.width, static_cast<int32_t>(picture.width));
  box.height = std::min(box.height, static_cast<int32_t>(picture.height));
  return box;
}

PixelBoxes to_pixels(std::span<const Candidate> candidates, Limits limits, PictureSize picture) {
  PixelBoxes boxes;
  boxes.reserve(candidates.size());
  for (const Candidate& candidate : candidates)
    boxes.push_back(to_pixels(candidate, limits, picture));
  return boxes;
}

}  // namespace weir::detection
