// Heads of networks that give a class or a depth for each pixel.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/detection/segmentation.hpp"
#include "core/heads/families.hpp"
#include "core/heads/head_options.hpp"
#include "core/heads/output_shapes.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::heads {
namespace {

using detection::Candidate;
using detection::Candidates;

constexpr uint32_t kMaxClasses = 65536;

// Where the scores of a pixel are.
struct Pixels {
  uint32_t width = 0, height = 0, classes = 1;
  bool are_packed = false;  // all scores of a pixel together: C:W:H
};

bool has_aspect(uint32_t width, uint32_t height, Size input) {
  if (width < 2 || height < 2) return false;
  if (input.width == 0) return true;
  // Grids are rounded to whole cells.
  const double wanted = static_cast<double>(input.width) / input.height;
  const double found = static_cast<double>(width) / height;
  return std::abs(found / wanted - 1) <= 1.5 / std::min(width, height);
}

// The dimension of classes is the one that leaves a picture of the input's aspect; the smaller one
// where both do.
std::optional<Pixels> find_pixels(const ModelSignature& model) {
  if (model.outputs.size() != 1) return std::nullopt;
  const Shape& shape = model.outputs[0].shape;
  if (shape.min_rank() < 2 || shape.min_rank() > 3) return std::nullopt;
  const uint32_t third = std::max(shape[2], 1u);
  const Pixels packed{shape[1], third, shape[0], true}, planar{shape[0], shape[1], third, false};
  const bool can_pack =
      packed.classes <= kMaxClasses && has_aspect(packed.width, packed.height, model.input);
  const bool can_plane =
      planar.classes <= kMaxClasses && has_aspect(planar.width, planar.height, model.input);
  if (can_pack && can_plane) return packed.classes < planar.classes ? packed : planar;
  if (can_pack) return packed;
  return can_plane ? std::optional(planar) : std::nullopt;
}

void set_map(const Pixels& pixels, results::FrameResults* results) {
  results->map_width = pixels.width;
  results->map_height = pixels.height;
  results->class_map.resize(size_t{pixels.width} * pixels.height);
}

void check_size(std::span<const float> numbers, const Pixels& pixels) {
  const size_t needed = size_t{pixels.width} * pixels.height * pixels.classes;
  if (numbers.size() == needed) return;
  throw Failure({.code = Code::SPEC_MISMATCH,
                 .what = "the frame has a different number of pixels than the head was opened for",
                 .offered = std::to_string(numbers.size()) + " numbers",
                 .needed = std::to_string(needed)});
}

class MapHead : public Head {
 public:
  explicit MapHead(const Pixels& pixels) : pixels_(pixels) {}
  results::Features features() const override { return {.has_class_map = true}; }
  Candidates find(OutputValues&, Size) override { return {}; }
  void complete(OutputValues& outputs, std::span<const Candidate>, Size,
                results::FrameResults* results) override {
    const auto numbers = read(outputs);
    check_size(numbers, pixels_);
    set_map(pixels_, results);
    fill(numbers, results->class_map);
  }

 protected:
  virtual std::span<const float> read(OutputValues& outputs) const { return outputs.read(0); }
  virtual void fill(std::span<const float> numbers, std::span<uint16_t> map) = 0;
  Pixels pixels_;
};

// Whether all are whole numbers as of classes, with one that is no score. A map of 0 and 1 reads
// the same as scores.
bool are_class_numbers(std::span<const float> numbers) {
  const bool are_whole = std::all_of(numbers.begin(), numbers.end(), [](float number) {
    return number >= 0 && number < kMaxClasses && number == std::floor(number);
  });
  return are_whole &&
         std::any_of(numbers.begin(), numbers.end(), [](float number) { return number > 1; });
}

Error class_numbers_as_scores(std::span<const float> numbers) {
  const auto max = static_cast<uint32_t>(*std::max_element(numbers.begin(), numbers.end()));
  return {.code = Code::SPEC_MISMATCH,
          .what = "the numbers of a map of scores are those of classes",
          .offered = "whole numbers up to " + std::to_string(max),
          .needed = "a score for each pixel",
          .fix = "custom=head:class-map"};
}

class DeepLab final : public MapHead {
 public:
  DeepLab(const Pixels& pixels, ScoreKind kind, float threshold)
      : MapHead(pixels), kind_(kind), threshold_(threshold) {}
  // A map of one score a pixel has two classes; the background needs no name.
  size_t classes() const noexcept override { return pixels_.classes; }

 private:
  void fill(std::span<const float> numbers, std::span<uint16_t> map) override {
    constexpr float kNone = -std::numeric_limits<float>::infinity();
    if (pixels_.classes == 1)
      fill_one(numbers, map);
    else if (pixels_.are_packed)
      detection::classes_from_scores(numbers, pixels_.classes, kNone, map);
    else
      detection::classes_from_planes(numbers, pixels_.classes, map);
  }
  // Class 1 where the probability reaches the threshold; or the classes, if the numbers are no
  // scores.
  void fill_one(std::span<const float> numbers, std::span<uint16_t> map) {
    if (are_class_numbers(numbers)) {
      if (kind_ == ScoreKind::Automatic)
        return static_cast<void>(detection::classes_from_numbers(numbers, kMaxClasses, map));
      warn_once(class_numbers_as_scores(numbers));
    }
    if (kind_ == ScoreKind::Automatic && are_logits(numbers)) kind_ = ScoreKind::Logits;
    const float min = kind_ != ScoreKind::Logits ? threshold_
                      : threshold_ >= 1          ? std::numeric_limits<float>::infinity()
                                                 : std::log(threshold_ / (1 - threshold_));
    for (size_t i = 0; i < map.size(); ++i) map[i] = numbers[i] >= min;
  }

  ScoreKind kind_;  // logits, once one was seen
  float threshold_;
};

class ClassMapHead final : public MapHead {
 public:
  using MapHead::MapHead;

 private:
  std::span<const float> read(OutputValues& outputs) const override { return outputs.read_raw(0); }
  void fill(std::span<const float> numbers, std::span<uint16_t> map) override {
    const auto bad = detection::classes_from_numbers(numbers, kMaxClasses, map);
    if (!bad) return;
    throw Failure({.code = Code::SPEC_MISMATCH,
                   .what = "a pixel has no class",
                   .offered = std::to_string(numbers[*bad]) + " at pixel " +
                              std::to_string(*bad % pixels_.width) + ", " +
                              std::to_string(*bad / pixels_.width),
                   .needed = "a class number from 0 to 65535",
                   .fix = "custom=head:deeplab"});
  }
};

// One number a pixel: classes if it is an integer without a scale, a score otherwise.
bool is_class_map(const OutputSignature& output, const Pixels& pixels) {
  return pixels.classes == 1 && is_integer(output.type) && !output.is_quantised;
}

Match fit_deep_lab(const ModelSignature& model) {
  const auto pixels = find_pixels(model);
  if (!pixels || is_class_map(model.outputs[0], *pixels) || looks_like_picture(model))
    return Match::No;
  const bool are_labelled = pixels->classes > 1 && pixels->classes == model.labels;
  if (!are_labelled) return Match::Possible;
  // Labels may as well be names of key points.
  const Match as_points = kHeatMaps.fit(model);
  const bool may_be_points = as_points == Match::Certain ||
                             (as_points == Match::Possible && is_usual_of_points(pixels->classes));
  return may_be_points ? Match::Possible : Match::Certain;
}

Match fit_class_map(const ModelSignature& model) {
  const auto pixels = find_pixels(model);
  if (!pixels || pixels->classes > 1) return Match::No;
  if (is_class_map(model.outputs[0], *pixels)) return Match::Possible;
  // One score a pixel has two classes; more labels are those of class numbers.
  return model.labels > 2 && !model.outputs[0].is_quantised ? Match::Certain : Match::No;
}

std::unique_ptr<Head> open_deep_lab(const ModelSignature& model, const HeadOptions& options) {
  const auto pixels = find_pixels(model);
  if (!pixels) throw wrong_outputs(model, kDeepLab);
  return std::make_unique<DeepLab>(*pixels, score_kind(options), options.threshold);
}

std::unique_ptr<Head> open_class_map(const ModelSignature& model, const HeadOptions&) {
  const auto pixels = find_pixels(model);
  if (!pixels || pixels->classes != 1) throw wrong_outputs(model, kClassMap);
  return std::make_unique<ClassMapHead>(*pixels);
}

// Dimensions of 1 are left out: W:H, 1:W:H and W:H:1 are the same.
std::optional<Size> find_map(const ModelSignature& model) {
  if (model.outputs.size() != 1) return std::nullopt;
  const Shape& shape = model.outputs[0].shape;
  std::vector<uint32_t> extents;
  for (size_t i = 0; i < shape.rank(); ++i)
    if (shape[i] > 1) extents.push_back(shape[i]);
  if (extents.size() != 2) return std::nullopt;
  return Size{extents[0], extents[1]};
}

class DepthMap final : public Head {
 public:
  explicit DepthMap(Size map) : map_(map) {}
  results::Features features() const override { return {.has_depth = true}; }
  detection::Candidates find(OutputValues&, Size) override { return {}; }
  void complete(OutputValues& outputs, std::span<const detection::Candidate>, Size,
                results::FrameResults* results) override {
    const auto numbers = outputs.read(0);
    if (numbers.size() != size_t{map_.width} * map_.height)
      throw Failure(
          {.code = Code::SPEC_MISMATCH,
           .what = "the frame has a different number of pixels than the head was opened for",
           .offered = std::to_string(numbers.size()),
           .needed = std::to_string(size_t{map_.width} * map_.height)});
    results->map_width = map_.width;
    results->map_height = map_.height;
    results->depth.assign(numbers.begin(), numbers.end());
    std::replace_if(
        results->depth.begin(), results->depth.end(),
        [](float depth) { return !std::isfinite(depth); }, 0.0f);
  }

 private:
  Size map_;
};

}  // namespace

const Family kDeepLab{.name = "deeplab",
                      .aliases = "semantic,selfie-segmentation",
                      .tasks = kSegmentation,
                      .outputs = "1 tensor CLASSES:W:H or W:H:CLASSES of scores",
                      .custom = "scores",
                      .threshold = 0.5f,
                      .fit = fit_deep_lab,
                      .open = open_deep_lab};

const Family kClassMap{.name = "class-map",
                       .aliases = "",
                       .tasks = kSegmentation,
                       .outputs = "1 tensor W:H of class numbers",
                       .custom = "",
                       .threshold = 0.5f,
                       .fit = fit_class_map,
                       .open = open_class_map};

const Family kDepthMap{
    .name = "depth",
    .aliases = "midas,depth-anything",
    .tasks = kDepth,
    .outputs = "1 tensor W:H, 1:W:H or W:H:1",
    .custom = "",
    .threshold = 0,
    .fit =
        [](const ModelSignature& model) {
          if (!find_map(model)) return Match::No;
          const bool is_named = any_name_has(model, "depth") && !any_name_has(model, "depthwise");
          return is_named ? Match::Certain : Match::Possible;
        },
    .open = [](const ModelSignature& model, const HeadOptions&) -> std::unique_ptr<Head> {
      const auto map = find_map(model);
      if (!map) throw wrong_outputs(model, kDepthMap);
      return std::make_unique<DepthMap>(*map);
    }};

}  // namespace weir::heads
