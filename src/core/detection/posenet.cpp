// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/posenet.hpp"

#include <algorithm>
#include <cmath>

#include "core/detection/sigmoid.hpp"

namespace weir::detection {
namespace {

using Point = PoseNetPerson::Point;

// Published values.
constexpr float kMinPeak = 0.5f;      // of a key point that a person starts from
constexpr float kSamePoint = 20;      // pixels: closer key points are the same
constexpr int kRefinements = 2;       // steps by offsets after each vector
constexpr size_t kMaxPersons = 1000;  // bounds the time for maps without meaning

struct Edge {
  size_t parent, child;
};
// Nose, eyes, ears, shoulders, elbows, wrists, hips, knees, ankles; left before right.
constexpr std::array<Edge, kPoseNetEdges> kEdges{{{0, 1},
                                                  {1, 3},
                                                  {0, 2},
                                                  {2, 4},
                                                  {0, 5},
                                                  {5, 7},
                                                  {7, 9},
                                                  {5, 11},
                                                  {11, 13},
                                                  {13, 15},
                                                  {0, 6},
                                                  {6, 8},
                                                  {8, 10},
                                                  {6, 12},
                                                  {12, 14},
                                                  {14, 16}}};

struct Peak {
  float logit;
  size_t cell, point;
};

float probability(float logit) noexcept {
  const float value = sigmoid(logit);
  return value > 0 ? value : 0;
}

// The nearest cell of a position in pixels; NaN is in the first.
size_t cell_along(float position, float stride, size_t cells) noexcept {
  const float cell = position / stride + 0.5f;
  return cell > 0 ? std::min(static_cast<size_t>(std::min(cell, 1e6f)), cells - 1) : 0;
}

size_t cell_at(const PoseNetMaps& maps, const Point& point) noexcept {
  return cell_along(point.y, maps.stride_y, maps.height) * maps.width +
         cell_along(point.x, maps.stride_x, maps.width);
}

// The position and score of key point `index` by the values of `cell`.
Point read_point(const PoseNetMaps& maps, size_t cell, size_t index) noexcept {
  const float* offsets = maps.offsets.data() + cell * 2 * kPoseNetPoints;
  const size_t column = cell % maps.width, row = cell / maps.width;
  return {static_cast<float>(column) * maps.stride_x + offsets[kPoseNetPoints + index],
          static_cast<float>(row) * maps.stride_y + offsets[index],
          probability(maps.heat[cell * kPoseNetPoints + index])};
}

Point follow(const PoseNetMaps& maps, const PoseNetVectors& vectors, size_t edge, const Point& from,
             size_t target) noexcept {
  const float* vector = vectors.values.data() + cell_at(maps, from) * vectors.per_cell;
  Point to{from.x + vector[vectors.x + edge], from.y + vector[vectors.y + edge], 0};
  for (int i = 0; i < kRefinements; ++i) to = read_point(maps, cell_at(maps, to), target);
  return to;
}

// No cell around it has a higher value.
bool is_peak(const PoseNetMaps& maps, size_t cell, size_t point) noexcept {
  const size_t x = cell % maps.width, y = cell / maps.width;
  const float value = maps.heat[cell * kPoseNetPoints + point];
  for (size_t row = y > 0 ? y - 1 : 0; row <= std::min(y + 1, maps.height - 1); ++row)
    for (size_t column = x > 0 ? x - 1 : 0; column <= std::min(x + 1, maps.width - 1); ++column)
      if (maps.heat[(row * maps.width + column) * kPoseNetPoints + point] > value) return false;
  return true;
}

std::vector<Peak> find_peaks(const PoseNetMaps& maps) {
  const float min = std::log(kMinPeak / (1 - kMinPeak));
  std::vector<Peak> peaks;
  for (size_t cell = 0; cell < maps.width * maps.height; ++cell)
    for (size_t point = 0; point < kPoseNetPoints; ++point) {
      const float logit = maps.heat[cell * kPoseNetPoints + point];
      if (logit >= min && is_peak(maps, cell, point)) peaks.push_back({logit, cell, point});
    }
  std::stable_sort(peaks.begin(), peaks.end(),
                   [](const Peak& a, const Peak& b) { return a.logit > b.logit; });
  return peaks;
}

bool is_taken(const std::vector<PoseNetPerson>& people, size_t index, const Point& point) noexcept {
  return std::any_of(people.begin(), people.end(), [&](const PoseNetPerson& person) {
    const float x = person.points[index].x - point.x, y = person.points[index].y - point.y;
    return x * x + y * y <= kSamePoint * kSamePoint;
  });
}

// All key points from one of them: first along the edges that lead to it, then away from it.
PoseNetPerson person_from(const PoseNetMaps& maps, size_t index, const Point& point) noexcept {
  PoseNetPerson person;
  std::array<bool, kPoseNetPoints> known{};
  person.points[index] = point, known[index] = true;
  for (size_t edge = kPoseNetEdges; edge-- > 0;) {
    const auto& [parent, child] = kEdges[edge];
    if (!known[child] || known[parent]) continue;
    person.points[parent] = follow(maps, maps.backward, edge, person.points[child], parent);
    known[parent] = true;
  }
  for (size_t edge = 0; edge < kPoseNetEdges; ++edge) {
    const auto& [parent, child] = kEdges[edge];
    if (!known[parent] || known[child]) continue;
    person.points[child] = follow(maps, maps.forward, edge, person.points[parent], child);
    known[child] = true;
  }
  return person;
}

}  // namespace

PoseNetPerson best_person(const PoseNetMaps& maps) {
  PoseNetPerson person;
  for (size_t point = 0; point < kPoseNetPoints; ++point) {
    size_t best = 0;
    for (size_t cell = 1; cell < maps.width * maps.height; ++cell) {
      const float value = maps.heat[cell * kPoseNetPoints + point];
      const float max = maps.heat[best * kPoseNetPoints + point];
      if (value > max || (std::isnan(max) && !std::isnan(value))) best = cell;
    }
    person.points[point] = read_point(maps, best, point);
    person.score += person.points[point].score / static_cast<float>(kPoseNetPoints);
  }
  return person;
}

std::vector<PoseNetPerson> find_people(const PoseNetMaps& maps, float min) {
  std::vector<PoseNetPerson> people;
  for (const Peak& peak : find_peaks(maps)) {
    if (people.size() == kMaxPersons) break;
    const Point first = read_point(maps, peak.cell, peak.point);
    if (!std::isfinite(first.x) || !std::isfinite(first.y)) continue;
    if (is_taken(people, peak.point, first)) continue;
    PoseNetPerson person = person_from(maps, peak.point, first);
    for (size_t i = 0; i < kPoseNetPoints; ++i)
      if (!is_taken(people, i, person.points[i]))
        person.score += person.points[i].score / static_cast<float>(kPoseNetPoints);
    people.push_back(person);
  }
  std::erase_if(people, [&](const PoseNetPerson& person) { return !(person.score >= min); });
  return people;
}

}  // namespace weir::detection
