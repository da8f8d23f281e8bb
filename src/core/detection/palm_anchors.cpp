// Makes the anchors of MediaPipe's palm detector and decodes its head.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/palm_anchors.hpp"

#include <algorithm>

namespace weir::detection {
namespace {

constexpr uint32_t kGridPixels = 192;

float scale_of(const PalmAnchorOptions& options, size_t layer) {
  const size_t layers = options.strides.size();
  if (layers == 1) return (options.least_scale + options.greatest_scale) / 2;
  return options.least_scale + (options.greatest_scale - options.least_scale) *
                                   static_cast<float>(layer) / static_cast<float>(layers - 1);
}

// One anchor of each scale in each cell of a square grid.
void add_grid(uint32_t stride, const std::vector<float>& scales, const PalmAnchorOptions& options,
              std::vector<Anchor>* anchors) {
  const uint32_t cells = kGridPixels / stride + (kGridPixels % stride != 0 ? 1 : 0);
  const auto across = static_cast<float>(cells);
  for (uint32_t y = 0; y < cells; ++y)
    for (uint32_t x = 0; x < cells; ++x)
      for (const float scale : scales)
        anchors->push_back({.x = (static_cast<float>(x) + options.x_offset) / across,
                            .y = (static_cast<float>(y) + options.y_offset) / across,
                            .width = scale,
                            .height = scale});
}

}  // namespace

std::vector<Anchor> make_palm_anchors(const PalmAnchorOptions& options) {
  std::vector<Anchor> anchors;
  const size_t layers = options.strides.size();
  for (size_t first = 0, end = 0; first < layers; first = end) {
    const uint32_t stride = options.strides[first];
    std::vector<float> scales;
    for (end = first; end < layers && options.strides[end] == stride; ++end)
      for (const size_t layer : {end, end + 1}) scales.push_back(scale_of(options, layer));
    add_grid(stride, scales, options, &anchors);
  }
  return anchors;
}

Candidates decode_palms(std::span<const float> boxes, std::span<const float> scores,
                        std::span<const Anchor> anchors, float threshold, PictureSize picture) {
  constexpr float kMostRaw = 100;
  const auto picture_width = static_cast<float>(picture.width);
  const auto picture_height = static_cast<float>(picture.height);
  Candidates found;
  for (size_t i = 0; i < scores.size(); ++i) {
    const float score = 1 / (1 + std::exp(-std::clamp(scores[i], -kMostRaw, kMostRaw)));
    if (!(score >= threshold)) continue;
    const auto box = boxes.subspan(kPalmRow * i, 4);
    const Anchor& anchor = anchors[i];
    const float centre_y = box[0] / picture_height * anchor.height + anchor.y;
    const float centre_x = box[1] / picture_width * anchor.width + anchor.x;
    const float height = box[2] / picture_height * anchor.height;
    const float width = box[3] / picture_width * anchor.width;
    const Candidate candidate{.x = (centre_x - width / 2) * picture_width,
                              .y = (centre_y - height / 2) * picture_height,
                              .width = width * picture_width,
                              .height = height * picture_height,
                              .score = score,
                              .class_index = 0,
                              .row = static_cast<uint32_t>(i)};
    if (candidate.is_finite()) found.push_back(candidate);
  }
  return found;
}

}  // namespace weir::detection
