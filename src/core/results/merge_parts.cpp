// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/results/merge_parts.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "core/results/object_selection.hpp"

namespace weir::results {
namespace {

constexpr size_t kMaxCompared = 8192;  // the best objects that may be in several parts

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

// Whether the box reaches an edge of its part, within a small fraction of its side. Nothing is cut
// at the edges of the picture.
bool is_cut(const Box& box, const Box& part, Size picture) noexcept {
  constexpr float kFraction = 0.01f;
  const float x = part.width() * kFraction, y = part.height() * kFraction;
  const bool is_known = picture.width > 0;
  const float right = is_known ? static_cast<float>(picture.width) : INFINITY;
  const float bottom = is_known ? static_cast<float>(picture.height) : INFINITY;
  return (part.x1 > x && box.x1 <= part.x1 + x) || (part.y1 > y && box.y1 <= part.y1 + y) ||
         (part.x2 < right - x && box.x2 >= part.x2 - x) ||
         (part.y2 < bottom - y && box.y2 >= part.y2 - y);
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

// The box and what it covers in any rotation.
Box get_reach(const Object& object) noexcept {
  if (object.rotation == 0) return object.box;
  const Box& box = object.box;
  const float x = (box.x1 + box.x2) / 2, y = (box.y1 + box.y2) / 2;
  const float reach = std::hypot(box.width(), box.height()) / 2;
  return {x - reach, y - reach, x + reach, y + reach};
}

class Merging {
 public:
  Merging(const PictureParts& parts, float max_overlap, FrameResults* results)
      : parts_(parts),
        max_overlap_(max_overlap),
        results_(results),
        is_kept_(results->objects.size()),
        kept_(parts.boxes.size()) {
    reaches_.assign(parts.boxes.begin(), parts.boxes.end());
    for (size_t i = 0; i < results->objects.size(); ++i) {
      const uint32_t part = parts.part_of[i];
      is_cut_.push_back(is_cut(results->objects[i].box, parts.boxes[part], parts.picture));
      extend(&reaches_[part], get_reach(results->objects[i]));
    }
    for (uint32_t part = 0; part < reaches_.size(); ++part)
      neighbours_.push_back(parts_at(reaches_[part], part));
  }

  // The objects that stay. Complete ones first, so that pieces are added to them. Those that no
  // other part can have are compared with none.
  std::vector<uint32_t> run() {
    std::vector<uint32_t> order(results_->objects.size());
    std::iota(order.begin(), order.end(), 0u);
    sort_by_score(&order);
    const auto shared = std::stable_partition(order.begin(), order.end(),
                                              [&](uint32_t i) { return may_be_shared(i); });
    const size_t compared = std::min(static_cast<size_t>(shared - order.begin()), kMaxCompared);
    const auto end = order.begin() + static_cast<std::ptrdiff_t>(compared);
    std::stable_partition(order.begin(), end, [&](uint32_t i) { return !is_cut_[i]; });
    rank_.resize(order.size());
    for (uint32_t rank = 0; rank < order.size(); ++rank) rank_[order[rank]] = rank;
    std::for_each(order.begin(), end, [&](uint32_t index) { add(index); });
    const auto kept = std::remove_if(order.begin(), end, [&](uint32_t i) { return !is_kept_[i]; });
    order.erase(kept, end);
    sort_by_score(&order);
    return order;
  }

 private:
  void sort_by_score(std::vector<uint32_t>* order) const {
    std::stable_sort(order->begin(), order->end(), [&](uint32_t a, uint32_t b) {
      return results_->objects[a].score > results_->objects[b].score;
    });
  }

  // The other parts that the box meets, with their objects.
  std::vector<uint32_t> parts_at(const Box& reach, uint32_t own) const {
    std::vector<uint32_t> out;
    for (uint32_t part = 0; part < reaches_.size(); ++part)
      if (part != own && common_part(reach, reaches_[part]).area() > 0) out.push_back(part);
    return out;
  }
  bool may_be_shared(uint32_t index) const {
    const Box reach = get_reach(results_->objects[index]);
    const auto& near = neighbours_[parts_.part_of[index]];
    return std::any_of(near.begin(), near.end(), [&](uint32_t part) {
      return common_part(reach, reaches_[part]).area() > 0;
    });
  }

  // Keeps the object, or merges it. One that grew may be the same as another one now, and is found
  // from the parts of both.
  void add(uint32_t index) {
    std::vector<uint32_t> own{parts_.part_of[index]};
    auto near = neighbours_[own[0]];
    for (auto same = find_same(index, near); same; same = find_same(index, near)) {
      if (!merge(index, *same)) return;
      index = *same;
      is_kept_[index] = false;
      own.push_back(parts_.part_of[index]);
      near.insert(near.end(), neighbours_[own.back()].begin(), neighbours_[own.back()].end());
    }
    is_kept_[index] = true;
    for (const uint32_t part : own) kept_[part].push_back(index);
  }

  // The first of the kept objects in these parts that is the same.
  std::optional<uint32_t> find_same(uint32_t index, const std::vector<uint32_t>& near) const {
    std::optional<uint32_t> out;
    for (const uint32_t part : near)
      for (const uint32_t other : kept_[part])
        if (is_kept_[other] && (!out || rank_[other] < rank_[*out]) && are_same(other, index))
          out = other;
    return out;
  }

  bool are_same(uint32_t a, uint32_t b) const {
    const Object &first = results_->objects[a], &second = results_->objects[b];
    if (parts_.part_of[a] == parts_.part_of[b] || first.class_index != second.class_index)
      return false;
    if (first.rotation != 0 || second.rotation != 0)
      return rotated_overlap(to_candidate(first), to_candidate(second)) > max_overlap_;
    const uint32_t smaller = first.box.area() < second.box.area() ? a : b;
    const Overlap share = is_cut_[smaller] ? Overlap::OfSmaller : Overlap::OfUnion;
    return overlap(first.box, second.box, share) > max_overlap_;
  }

  // Whether `to` grew.
  bool merge(uint32_t from, uint32_t to) {
    Object& object = results_->objects[to];
    object.score = std::max(object.score, results_->objects[from].score);
    const bool is_upright = object.rotation == 0 && results_->objects[from].rotation == 0;
    const Box before = object.box;
    if (is_cut_[to] && is_upright && results_->masks.empty())
      extend(&object.box, results_->objects[from].box);
    return object.box.area() > before.area();
  }

  PictureParts parts_;
  float max_overlap_;
  FrameResults* results_;
  std::vector<bool> is_cut_;
  std::vector<uint32_t> rank_;                     // of each object; the first one stays
  std::vector<Box> reaches_;                       // around each part and its objects
  std::vector<std::vector<uint32_t>> neighbours_;  // of each part
  std::vector<bool> is_kept_;                      // each object
  std::vector<std::vector<uint32_t>> kept_;        // objects of each part; some are not any more
};

using Interval = std::pair<float, float>;

// Whether intervals cover 0 to `length`, within a pixel. Sorts them.
bool do_cover(float length, std::vector<Interval>* intervals) {
  std::sort(intervals->begin(), intervals->end());
  float end = 0;
  for (const auto& [from, to] : *intervals) {
    if (from > end + 1) return false;
    end = std::max(end, to);
  }
  return end >= length - 1;
}

}  // namespace

bool are_tiles(std::span<const Box> parts, Size picture) {
  if (parts.size() < 2 || picture.width == 0 || picture.height == 0) return false;
  std::map<std::pair<long, long>, std::vector<Interval>> rows;
  std::vector<Interval> heights;
  for (const Box& part : parts) {
    rows[{std::lround(part.y1), std::lround(part.y2)}].emplace_back(part.x1, part.x2);
    heights.emplace_back(part.y1, part.y2);
  }
  return do_cover(static_cast<float>(picture.height), &heights) &&
         std::all_of(rows.begin(), rows.end(), [&](auto& row) {
           return do_cover(static_cast<float>(picture.width), &row.second);
         });
}

void merge_parts(const PictureParts& parts, float max_overlap, size_t max_objects,
                 FrameResults* results) {
  auto kept = Merging(parts, max_overlap, results).run();
  kept.resize(std::min(kept.size(), max_objects));
  keep_objects(kept, results);
}

}  // namespace weir::results
