// Reads depths of pixels.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/depth_heads.hpp"

#include <algorithm>
#include <cmath>

#include "core/heads/head_options.hpp"
#include "core/heads/output_shapes.hpp"

namespace weir::heads {
namespace {

using detection::PictureSize;

// Dimensions of 1 are left out: W:H, 1:W:H and W:H:1 are the same.
std::optional<PictureSize> find_map(const ModelFacts& model) {
  if (model.outputs.size() != 1) return std::nullopt;
  const Shape& shape = model.outputs[0].shape;
  std::vector<uint32_t> extents;
  for (size_t i = 0; i < shape.rank(); ++i)
    if (shape[i] > 1) extents.push_back(shape[i]);
  if (extents.size() != 2) return std::nullopt;
  return PictureSize{extents[0], extents[1]};
}

class DepthMap final : public Head {
 public:
  explicit DepthMap(PictureSize map) : map_(map) {}
  results::Features features() const override { return {.has_depth = true}; }
  detection::Candidates find(OutputValues&, PictureSize) override { return {}; }
  void complete(OutputValues& outputs, std::span<const detection::Candidate>, PictureSize,
                results::Answer* answer) override {
    const auto numbers = outputs.read(0);
    if (numbers.size() != size_t{map_.width} * map_.height)
      throw Failure(
          {.code = Code::SPEC_MISMATCH,
           .what = "the frame has a different number of pixels than the head was opened for",
           .offered = std::to_string(numbers.size()),
           .needed = std::to_string(size_t{map_.width} * map_.height)});
    answer->map_width = map_.width;
    answer->map_height = map_.height;
    answer->depth.assign(numbers.begin(), numbers.end());
    std::replace_if(
        answer->depth.begin(), answer->depth.end(),
        [](float depth) { return !std::isfinite(depth); }, 0.0f);
  }

 private:
  PictureSize map_;
};

}  // namespace

const Family kDepthMap{
    .name = "depth",
    .aliases = "midas,depth-anything",
    .tasks = kDepth,
    .outputs = "1 tensor W:H, 1:W:H or W:H:1",
    .custom = "",
    .threshold = 0,
    .fit =
        [](const ModelFacts& model) {
          if (!find_map(model)) return Fit::No;
          const bool is_named = any_name_has(model, "depth") && !any_name_has(model, "depthwise");
          return is_named ? Fit::Certain : Fit::Possible;
        },
    .open = [](const ModelFacts& model, const HeadOptions&) -> std::unique_ptr<Head> {
      const auto map = find_map(model);
      if (!map) throw wrong_outputs(model, kDepthMap);
      return std::make_unique<DepthMap>(*map);
    }};

}  // namespace weir::heads
