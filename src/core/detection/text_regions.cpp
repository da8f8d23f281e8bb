// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/text_regions.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

namespace weir::detection {
namespace {

constexpr double kMinSide = 3, kMinGrownSide = 5;  // pixels; published with PP-OCR
constexpr double kTall = 1.5;                      // height / width of text from top to bottom

// Pixels of a row from `begin` to before `end`.
struct Run {
  uint32_t y, begin, end;
};

// Sets of runs that touch each other (union-find).
class Areas {
 public:
  void add() { parents_.push_back(static_cast<uint32_t>(parents_.size())); }
  uint32_t root(uint32_t run) noexcept {
    while (parents_[run] != run) run = parents_[run] = parents_[parents_[run]];
    return run;
  }
  // The earlier run becomes the root.
  void join(uint32_t a, uint32_t b) noexcept {
    a = root(a), b = root(b);
    parents_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<uint32_t> parents_;
};

struct Pixel {
  double x, y;
};

std::vector<Run> find_runs(std::span<const float> map, size_t width, size_t height, float min) {
  std::vector<Run> runs;
  for (size_t y = 0; y < height; ++y) {
    const float* row = map.data() + y * width;
    for (size_t x = 0; x < width; ++x) {
      if (!(row[x] > min)) continue;
      const size_t begin = x;
      while (x < width && row[x] > min) ++x;
      runs.push_back(
          {static_cast<uint32_t>(y), static_cast<uint32_t>(begin), static_cast<uint32_t>(x)});
    }
  }
  return runs;
}

// Runs of adjacent rows touch each other, also at corners. Returns the runs sorted by area.
std::vector<std::vector<Run>> find_areas(const std::vector<Run>& runs) {
  Areas areas;
  size_t above = 0;  // the first run of the row above that may touch
  for (uint32_t i = 0; i < runs.size(); ++i) {
    areas.add();
    while (runs[above].y + 1 < runs[i].y ||
           (runs[above].y + 1 == runs[i].y && runs[above].end < runs[i].begin))
      ++above;
    for (size_t k = above; runs[k].y + 1 == runs[i].y && runs[k].begin <= runs[i].end; ++k)
      areas.join(static_cast<uint32_t>(k), i);
  }
  std::vector<std::vector<Run>> out;
  std::vector<uint32_t> places(runs.size());  // in `out`, for roots
  for (uint32_t i = 0; i < runs.size(); ++i) {
    const uint32_t root = areas.root(i);
    if (root == i) {
      places[i] = static_cast<uint32_t>(out.size());
      out.emplace_back();
    }
    out[places[root]].push_back(runs[i]);
  }
  return out;
}

// The convex hull of the pixels' centres (Andrew's monotone chain, 1979).
std::vector<Pixel> find_hull(const std::vector<Run>& area) {
  std::vector<Pixel> ends;  // sorted by y, then x
  for (size_t i = 0; i < area.size();) {
    const Run& first = area[i];
    uint32_t end = first.end;
    for (; i < area.size() && area[i].y == first.y; ++i) end = area[i].end;
    ends.push_back({double(first.begin), double(first.y)});
    if (end > first.begin + 1) ends.push_back({double(end - 1), double(first.y)});
  }
  if (ends.size() < 3) return ends;
  std::vector<Pixel> hull;
  const auto extend = [&](const Pixel& next, size_t fixed) {
    while (hull.size() > fixed + 1) {
      const Pixel &a = hull[hull.size() - 2], &b = hull.back();
      if ((b.y - a.y) * (next.x - a.x) - (b.x - a.x) * (next.y - a.y) > 0) break;
      hull.pop_back();
    }
    hull.push_back(next);
  };
  for (const Pixel& pixel : ends) extend(pixel, 0);
  const size_t fixed = hull.size() - 1;
  for (size_t i = ends.size() - 1; i-- > 0;) extend(ends[i], fixed);
  hull.pop_back();  // the first one again
  return hull;
}

// A box about its centre. `angle` is that of the width.
struct RotatedBox {
  double x = 0, y = 0, width = 0, height = 0, angle = 0;
};

RotatedBox box_along(const std::vector<Pixel>& hull, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double min_u = kInfinity, max_u = -kInfinity, min_v = kInfinity, max_v = -kInfinity;
  for (const auto& [x, y] : hull) {
    const double u = x * c + y * s, v = y * c - x * s;
    min_u = std::min(min_u, u), max_u = std::max(max_u, u);
    min_v = std::min(min_v, v), max_v = std::max(max_v, v);
  }
  const double u = (min_u + max_u) / 2, v = (min_v + max_v) / 2;
  return {u * c - v * s, u * s + v * c, max_u - min_u, max_v - min_v, angle};
}

// The smallest box has a side along an edge of the hull (Freeman and Shapira, 1975).
RotatedBox smallest_box(const std::vector<Pixel>& hull) {
  RotatedBox best = box_along(hull, 0);
  for (size_t i = 0; i < hull.size(); ++i) {
    const Pixel &a = hull[i], &b = hull[(i + 1) % hull.size()];
    const RotatedBox box = box_along(hull, std::atan2(b.y - a.y, b.x - a.x));
    if (box.width * box.height < best.width * best.height - 1e-6) best = box;
  }
  return best;
}

// Turns the box until its width is the direction of reading.
void turn_to_reading(RotatedBox* box) {
  const double quarter = std::numbers::pi / 2;
  const double turns = std::floor(box->angle / quarter + 0.5);
  box->angle -= turns * quarter;  // -45 to 45 degrees
  if (std::fmod(std::abs(turns), 2) == 1) std::swap(box->width, box->height);
  if (box->height < kTall * box->width) return;
  std::swap(box->width, box->height);
  box->angle += quarter;
}

// The mean probability of the pixels whose centres are in the box.
double mean_in(std::span<const float> map, size_t width, size_t height, const RotatedBox& box) {
  const double c = std::cos(box.angle), s = std::sin(box.angle);
  const double reach_x = (std::abs(box.width * c) + std::abs(box.height * s)) / 2;
  const double reach_y = (std::abs(box.width * s) + std::abs(box.height * c)) / 2;
  const auto first = [](double at) { return static_cast<size_t>(std::max(0.0, std::ceil(at))); };
  const auto last = [](double at, size_t cells) {
    return static_cast<size_t>(std::clamp(std::floor(at), 0.0, double(cells - 1)));
  };
  constexpr double kRounding = 1e-6;
  double sum = 0;
  size_t count = 0;
  for (size_t y = first(box.y - reach_y - kRounding);
       y <= last(box.y + reach_y + kRounding, height); ++y)
    for (size_t x = first(box.x - reach_x - kRounding);
         x <= last(box.x + reach_x + kRounding, width); ++x) {
      const double dx = double(x) - box.x, dy = double(y) - box.y;
      if (std::abs(dx * c + dy * s) > box.width / 2 + kRounding ||
          std::abs(dy * c - dx * s) > box.height / 2 + kRounding)
        continue;
      const float value = map[y * width + x];
      sum += value > 0 ? std::min(value, 1.0f) : 0;
      ++count;
    }
  return count > 0 ? sum / double(count) : 0;
}

}  // namespace

std::vector<TextRegion> find_text_regions(std::span<const float> map, size_t width, size_t height,
                                          const TextRegionOptions& options) {
  std::vector<TextRegion> regions;
  for (const auto& area : find_areas(find_runs(map, width, height, options.min_pixel))) {
    RotatedBox box = smallest_box(find_hull(area));
    if (std::min(box.width, box.height) < kMinSide) continue;
    const double score = mean_in(map, width, height, box);
    if (score < double{options.min_score}) continue;
    const double growth =
        box.width * box.height * double{options.unclip} / (2 * (box.width + box.height));
    box.width += 2 * growth, box.height += 2 * growth;
    if (std::min(box.width, box.height) < kMinGrownSide) continue;
    turn_to_reading(&box);
    constexpr double kCentre = 0.5;  // of a pixel
    regions.push_back({static_cast<float>(box.x + kCentre), static_cast<float>(box.y + kCentre),
                       static_cast<float>(box.width), static_cast<float>(box.height),
                       static_cast<float>(box.angle), static_cast<float>(score)});
  }
  return regions;
}

}  // namespace weir::detection
