// Finds PoseNet's tensors and reads persons from them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/posenet_head.hpp"

#include "core/detection/posenet.hpp"
#include "core/heads/head_options.hpp"
#include "core/heads/output_shapes.hpp"
#include "core/heads/points_head.hpp"

namespace weir::heads {
namespace {

using detection::Candidates;
using detection::kPoseNetEdges;
using detection::kPoseNetPoints;
using detection::PictureSize;
using detection::PoseNetMaps;

struct PoseNetLayout {
  size_t width, height;  // cells
  size_t heat, offsets;  // outputs
  // With both vectors in one output, and with one output for each; or neither.
  std::optional<size_t> vectors, forward, backward;
};

// The outputs VALUES:width:height, in their order.
std::vector<size_t> grids_of(const ModelFacts& model, size_t values, size_t width, size_t height) {
  std::vector<size_t> found;
  for (size_t i = 0; i < model.outputs.size(); ++i) {
    const Shape& shape = model.outputs[i].shape;
    if (shape.min_rank() <= 3 &&
        shape == Shape{static_cast<uint32_t>(values), static_cast<uint32_t>(width),
                       static_cast<uint32_t>(height)})
      found.push_back(i);
  }
  return found;
}

// Where output `heat` has the heat maps; nullopt if it cannot have them.
std::optional<PoseNetLayout> layout_around(const ModelFacts& model, size_t heat) {
  const Shape& shape = model.outputs[heat].shape;
  if (shape[0] != kPoseNetPoints || shape[1] < 2 || shape[2] < 2) return std::nullopt;
  const auto grids = [&](size_t values) { return grids_of(model, values, shape[1], shape[2]); };
  const auto offsets = grids(2 * kPoseNetPoints);
  if (offsets.size() != 1 || grids(kPoseNetPoints).size() != 1) return std::nullopt;
  PoseNetLayout layout{.width = shape[1],
                       .height = shape[2],
                       .heat = heat,
                       .offsets = offsets[0],
                       .vectors = {},
                       .forward = {},
                       .backward = {}};
  if (const auto both = grids(4 * kPoseNetEdges); both.size() == 1) layout.vectors = both[0];
  if (const auto one = grids(2 * kPoseNetEdges); one.size() == 2) {
    const bool is_swapped = has_name_with(model.outputs[one[0]], "bwd");
    layout.forward = one[is_swapped ? 1 : 0], layout.backward = one[is_swapped ? 0 : 1];
  }
  return layout;
}

std::optional<PoseNetLayout> posenet_layout(const ModelFacts& model) {
  for (size_t i = 0; i < model.outputs.size(); ++i)
    if (const auto layout = layout_around(model, i)) return layout;
  return std::nullopt;
}

class Posenet final : public PointsHead {
 public:
  Posenet(const PoseNetLayout& layout, float threshold)
      : PointsHead(kPoseNetPoints), layout_(layout), threshold_(threshold) {}

  Candidates find(OutputValues& outputs, PictureSize input) override {
    need_input_size(input);
    const PoseNetMaps maps = maps_of(outputs, input);
    begin();
    if (!maps.forward.values.empty()) {
      for (const auto& person : find_people(maps, threshold_)) add_person(person);
    } else if (const auto person = best_person(maps); person.score >= threshold_) {
      add_person(person);
    }
    return take();
  }

 private:
  PoseNetMaps maps_of(OutputValues& outputs, PictureSize input) const {
    // The first and the last cells are at the first and the last pixels.
    const auto stride = [](uint32_t pixels, size_t cells) {
      return pixels > 1 ? static_cast<float>(pixels - 1) / static_cast<float>(cells - 1) : 1.0f;
    };
    PoseNetMaps maps{.width = layout_.width,
                     .height = layout_.height,
                     .stride_x = stride(input.width, layout_.width),
                     .stride_y = stride(input.height, layout_.height),
                     .heat = outputs.read(layout_.heat),
                     .offsets = outputs.read(layout_.offsets),
                     .forward = {},
                     .backward = {}};
    constexpr size_t kEdges = kPoseNetEdges;
    if (layout_.vectors) {
      const auto values = outputs.read(*layout_.vectors);
      maps.forward = {.values = values, .per_cell = 4 * kEdges, .y = 0, .x = kEdges};
      maps.backward = {.values = values, .per_cell = 4 * kEdges, .y = 2 * kEdges, .x = 3 * kEdges};
    } else if (layout_.forward) {
      maps.forward = {
          .values = outputs.read(*layout_.forward), .per_cell = 2 * kEdges, .y = 0, .x = kEdges};
      maps.backward = {
          .values = outputs.read(*layout_.backward), .per_cell = 2 * kEdges, .y = 0, .x = kEdges};
    }
    return maps;
  }

  void add_person(const detection::PoseNetPerson& person) {
    std::vector<results::KeyPoint> points;
    for (const auto& point : person.points)
      points.push_back(key_point(point.x, point.y, point.score));
    if (person.score > 0) add(points, threshold_, person.score, 0);
  }

  PoseNetLayout layout_;
  float threshold_;
};

Fit fit_posenet(const ModelFacts& model) {
  if (!posenet_layout(model)) return Fit::No;
  return any_name_has(model, "heatmap") && any_name_has(model, "offset") ? Fit::Certain
                                                                         : Fit::Possible;
}

std::unique_ptr<Head> open_posenet(const ModelFacts& model, const HeadOptions& options) {
  const auto layout = posenet_layout(model);
  if (!layout) throw wrong_outputs(model, kPosenet);
  return std::make_unique<Posenet>(*layout, options.threshold);
}

}  // namespace

const Family kPosenet{.name = "posenet",
                      .aliases = "",
                      .tasks = kPose,
                      .outputs =
                          "tensors 17:W:H and 34:W:H; for several persons also 64:W:H, or "
                          "two 32:W:H",
                      .custom = "",
                      .threshold = 0.25f,
                      .fit = fit_posenet,
                      .open = open_posenet};

}  // namespace weir::heads
