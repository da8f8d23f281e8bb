// Reads the peak of each heat map.
//
// Sun et al., "Deep High-Resolution Representation Learning for Human Pose Estimation", 2019: the
// peak moves by a quarter of a cell towards the higher of its two neighbours along each axis.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/heat_map_head.hpp"

#include <cmath>

#include "core/heads/head_options.hpp"
#include "core/heads/output_shapes.hpp"
#include "core/heads/points_head.hpp"

namespace weir::heads {
namespace {

using detection::Candidates;
using detection::PictureSize;

struct Layout {
  size_t points, width, height;
  size_t next_point, next_cell;  // elements from one to the next
};

constexpr size_t kLeastSide = 8, kMostPoints = 512;

// Whether the cells of such maps are squares of the input.
bool is_plausible(const Layout& layout, PictureSize input) {
  if (layout.width < kLeastSide || layout.height < kLeastSide || layout.points > kMostPoints)
    return false;
  if (input.width == 0 || input.height == 0)
    return layout.points > 1 && layout.points < layout.width && layout.points < layout.height;
  return input.width % layout.width == 0 &&
         input.width / layout.width * layout.height == input.height;
}

// Planar maps if both orders are plausible.
std::optional<Layout> layout_of(const ModelFacts& model) {
  if (model.outputs.size() != 1) return std::nullopt;
  const Shape& shape = model.outputs[0].shape;
  if (shape.min_rank() > 3 || shape.rank() < 3) return std::nullopt;
  const size_t a = shape[0], b = shape[1], c = shape[2];
  const Layout planar{.points = c, .width = a, .height = b, .next_point = a * b, .next_cell = 1};
  const Layout packed{.points = a, .width = b, .height = c, .next_point = 1, .next_cell = a};
  if (is_plausible(planar, model.input)) return planar;
  if (is_plausible(packed, model.input)) return packed;
  return std::nullopt;
}

class HeatMaps final : public PointsHead {
 public:
  HeatMaps(const Layout& layout, float threshold)
      : PointsHead(layout.points), layout_(layout), threshold_(threshold) {}

  Candidates find(OutputValues& outputs, PictureSize input) override {
    need_input_size(input);
    const auto maps = outputs.read(0);
    const float scale_x = static_cast<float>(input.width) / static_cast<float>(layout_.width);
    const float scale_y = static_cast<float>(input.height) / static_cast<float>(layout_.height);
    begin();
    points_.clear();
    float sum = 0;
    for (size_t i = 0; i < layout_.points; ++i) {
      const float* map = maps.data() + i * layout_.next_point;
      const size_t peak = peak_of(map);
      const size_t column = peak % layout_.width, row = peak / layout_.width;
      float x = static_cast<float>(column), y = static_cast<float>(row);
      if (column > 1 && column + 1 < layout_.width && row > 1 && row + 1 < layout_.height) {
        x += 0.25f * step(map, peak, 1);
        y += 0.25f * step(map, peak, layout_.width);
      }
      points_.push_back(key_point(x * scale_x, y * scale_y, map[peak * layout_.next_cell]));
      sum += points_.back().score;
    }
    const float score = sum / static_cast<float>(layout_.points);
    if (score >= threshold_ && score > 0) add(points_, threshold_, score, 0);
    return take();
  }

 private:
  // The first cell with the highest value; not-a-number never wins.
  size_t peak_of(const float* map) const noexcept {
    size_t best = 0;
    float most = -INFINITY;
    for (size_t cell = 0; cell < layout_.width * layout_.height; ++cell) {
      const float value = map[cell * layout_.next_cell];
      if (value > most) most = value, best = cell;
    }
    return best;
  }
  // 1, 0 or -1: which of the cells `next` before and after the peak is higher.
  float step(const float* map, size_t peak, size_t next) const noexcept {
    const float after = map[(peak + next) * layout_.next_cell];
    const float before = map[(peak - next) * layout_.next_cell];
    return static_cast<float>(after > before) - static_cast<float>(after < before);
  }

  Layout layout_;
  float threshold_;
  std::vector<results::KeyPoint> points_;
};

Fit fit(const ModelFacts& model) {
  return layout_of(model) ? Fit::Possible : Fit::No;
}

std::unique_ptr<Head> open(const ModelFacts& model, const HeadOptions& options) {
  const auto layout = layout_of(model);
  if (!layout) throw wrong_outputs(model, kHeatMaps);
  return std::make_unique<HeatMaps>(*layout, options.threshold);
}

}  // namespace

const Family kHeatMaps{.name = "heat-maps",
                       .aliases = "hrnet,simple-baselines",
                       .tasks = kPose,
                       .outputs =
                           "1 tensor W:H:POINTS or POINTS:W:H, W and H a whole fraction of "
                           "the input's",
                       .custom = "",
                       .threshold = 0.2f,
                       .fit = fit,
                       .open = open};

}  // namespace weir::heads
