// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/results/merge_parts.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

#include "core/results/object_selection.hpp"

namespace weir::results {
namespace {

constexpr size_t kMaxCompared = 8192;  // the best objects of a frame

// The elements that belong to the objects `kept`, in their order; `length` for each object.
template <class T>
void keep(std::span<const uint32_t> kept, size_t length, std::vector<T>* table) {
  if (table->empty()) return;
  std::vector<T> out;
  out.reserve(kept.size() * length);
  for (const uint32_t index : kept)
    std::move(table->begin() + static_cast<std::ptrdiff_t>(index * length),
              table->begin() + static_cast<std::ptrdiff_t>((index + 1) * length),
              std::back_inserter(out));
  *table = std::move(out);
}

void keep_objects(std::span<const uint32_t> kept, FrameResults* results) {
  keep(kept, 1, &results->objects);
  keep(kept, results->points_per_object, &results->points);
  keep(kept, size_t{results->mask_width} * results->mask_height, &results->masks);
  keep(kept, results->n_classes, &results->class_scores);
  keep(kept, 1, &results->texts);
}

// Whether the box reaches an edge of its part, within a small fraction of its side.
bool is_cut(const Box& box, const Box& part) noexcept {
  constexpr float kFraction = 0.01f;
  const float x = part.width() * kFraction, y = part.height() * kFraction;
  return box.x1 <= part.x1 + x || box.y1 <= part.y1 + y || box.x2 >= part.x2 - x ||
         box.y2 >= part.y2 - y;
}

// With its centre at x, y, as rotated_overlap() has it.
detection::Candidate to_candidate(const Object& object) noexcept {
  const Box& box = object.box;
  return {.x = (box.x1 + box.x2) / 2,
          .y = (box.y1 + box.y2) / 2,
          .width = box.width(),
          .height = box.height(),
          .angle = object.rotation};
}

void extend(Box* box, const Box& other) noexcept {
  *box = {std::min(box->x1, other.x1), std::min(box->y1, other.y1), std::max(box->x2, other.x2),
          std::max(box->y2, other.y2)};
}

class Merging {
 public:
  Merging(const PictureParts& parts, float max_overlap, FrameResults* results)
      : parts_(parts), max_overlap_(max_overlap), results_(results) {
    for (size_t i = 0; i < results->objects.size(); ++i)
      is_cut_.push_back(is_cut(results->objects[i].box, parts.boxes[parts.part_of[i]]));
  }

  // The objects that stay. Complete ones first, so that pieces are added to them.
  std::vector<uint32_t> run() {
    std::vector<uint32_t> order = by_score();
    order.resize(std::min(order.size(), kMaxCompared));
    std::stable_partition(order.begin(), order.end(), [&](uint32_t i) { return !is_cut_[i]; });
    std::vector<uint32_t> kept;
    for (const uint32_t index : order) {
      const auto twin = std::find_if(kept.begin(), kept.end(),
                                     [&](uint32_t other) { return are_same(other, index); });
      if (twin == kept.end())
        kept.push_back(index);
      else
        merge(index, *twin);
    }
    std::stable_sort(kept.begin(), kept.end(), [&](uint32_t a, uint32_t b) {
      return results_->objects[a].score > results_->objects[b].score;
    });
    return kept;
  }

 private:
  std::vector<uint32_t> by_score() const {
    std::vector<uint32_t> order(results_->objects.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
      return results_->objects[a].score > results_->objects[b].score;
    });
    return order;
  }

  bool are_same(uint32_t a, uint32_t b) const {
    const Object &first = results_->objects[a], &second = results_->objects[b];
    if (parts_.part_of[a] == parts_.part_of[b] || first.class_index != second.class_index)
      return false;
    if (first.rotation != 0 || second.rotation != 0)
      return rotated_overlap(to_candidate(first), to_candidate(second)) > max_overlap_;
    const Overlap share = is_cut_[a] || is_cut_[b] ? Overlap::OfSmaller : Overlap::OfUnion;
    return overlap(first.box, second.box, share) > max_overlap_;
  }

  void merge(uint32_t from, uint32_t to) {
    Object& object = results_->objects[to];
    object.score = std::max(object.score, results_->objects[from].score);
    const bool is_upright = object.rotation == 0 && results_->objects[from].rotation == 0;
    if (is_cut_[to] && is_upright && results_->masks.empty())
      extend(&object.box, results_->objects[from].box);
  }

  PictureParts parts_;
  float max_overlap_;
  FrameResults* results_;
  std::vector<bool> is_cut_;
};

}  // namespace

void merge_parts(const PictureParts& parts, float max_overlap, size_t max_objects,
                 FrameResults* results) {
  auto kept = Merging(parts, max_overlap, results).run();
  kept.resize(std::min(kept.size(), max_objects));
  keep_objects(kept, results);
}

}  // namespace weir::results
