// Appends objects and their tables.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/results/append.hpp"

#include <algorithm>
#include <utility>

#include "weir/module.hpp"

namespace weir::results {
namespace {

template <class T>
void move_to(std::vector<T>* from, std::vector<T>* to) {
  if (to->empty())
    std::swap(*from, *to);
  else
    to->insert(to->end(), std::make_move_iterator(from->begin()),
               std::make_move_iterator(from->end()));
}

// Nearest neighbour, by the centres of pixels.
std::vector<uint8_t> resampled(const std::vector<uint8_t>& masks, uint32_t width, uint32_t height,
                               uint32_t to_width, uint32_t to_height) {
  const size_t from_size = size_t{width} * height, count = masks.size() / from_size;
  std::vector<uint8_t> out;
  out.reserve(count * to_width * to_height);
  for (size_t i = 0; i < count; ++i)
    for (uint32_t y = 0; y < to_height; ++y)
      for (uint32_t x = 0; x < to_width; ++x) {
        const size_t from_x = (2 * size_t{x} + 1) * width / (2 * size_t{to_width});
        const size_t from_y = (2 * size_t{y} + 1) * height / (2 * size_t{to_height});
        out.push_back(masks[i * from_size + from_y * width + from_x]);
      }
  return out;
}

void append_masks(Answer* part, Answer* all) {
  if (part->masks.empty()) return;
  const uint32_t width = std::max(part->mask_width, all->masks.empty() ? 0 : all->mask_width);
  const uint32_t height = std::max(part->mask_height, all->masks.empty() ? 0 : all->mask_height);
  for (Answer* answer : {part, all}) {
    const bool fits = answer->mask_width == width && answer->mask_height == height;
    if (!fits && !answer->masks.empty())
      answer->masks =
          resampled(answer->masks, answer->mask_width, answer->mask_height, width, height);
    answer->mask_width = width, answer->mask_height = height;
  }
  move_to(&part->masks, &all->masks);
}

}  // namespace

void append(Answer* part, const Features& features, Answer* all) {
  const bool has_map = !all->class_map.empty() || !all->depth.empty();
  if ((features.has_class_map || features.has_depth) && has_map)
    throw Failure({.code = Code::SPEC_MISMATCH,
                   .what = "a frame has one map, not one for each region",
                   .offered = "a batch of regions",
                   .needed = "one picture in each frame",
                   .fix = "tensor_preprocess max-regions=1"});
  append_masks(part, all);
  all->points_per_object = features.points_per_object;
  all->n_classes = part->n_classes;
  move_to(&part->objects, &all->objects);
  move_to(&part->points, &all->points);
  move_to(&part->class_scores, &all->class_scores);
  move_to(&part->texts, &all->texts);
  if (features.has_class_map || features.has_depth)
    all->map_width = part->map_width, all->map_height = part->map_height;
  move_to(&part->class_map, &all->class_map);
  move_to(&part->depth, &all->depth);
}

}  // namespace weir::results
