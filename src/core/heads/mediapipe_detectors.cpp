// Reads boxes and key points of MediaPipe's detectors.
//
// Anchors, scaling and rotation follow the graphs that MediaPipe publishes (face_detection,
// palm_detection, pose_detection): each anchor is a cell's centre with the size of the picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/families.hpp"

#include <algorithm>
#include <cmath>

#include "core/detection/sigmoid.hpp"
#include "core/heads/head_options.hpp"
#include "core/heads/output_shapes.hpp"
#include "core/heads/points_head.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::heads {
namespace {

using detection::Candidate;
using detection::Candidates;

constexpr size_t kMediapipeBox = 4;

struct AnchorGrid {
  uint32_t stride;   // pixels of a cell
  uint32_t anchors;  // of each cell
};

// A published model: its input and grids.
struct Variant {
  uint32_t input;  // pixels, square
  std::vector<AnchorGrid> grids;

  size_t anchors() const noexcept {
    size_t count = 0;
    for (const auto& [stride, anchors] : grids) {
      const size_t cells = input / stride;
      count += cells * cells * anchors;
    }
    return count;
  }
};

// What the box of an object is.
enum class Region {
  Upright,          // the network's box
  RotatedBox,       // turned so that key point 0 is below key point 2
  AroundFirstPoint  // a square around key point 0; key point 1 is on its circle, above
};

struct Detector {
  const Family* family;
  size_t points;
  Region region;
  std::vector<Variant> variants;
};

const Detector& blazeface() {
  // Short range, back camera, full range.
  static const Detector detector{
      &kBlazeface,
      6,
      Region::Upright,
      {{128, {{8, 2}, {16, 6}}}, {256, {{16, 2}, {32, 6}}}, {192, {{4, 1}}}}};
  return detector;
}
const Detector& palm() {
  static const Detector detector{&kPalmDetection,
                                 7,
                                 Region::RotatedBox,
                                 {{192, {{8, 2}, {16, 6}}}, {256, {{8, 2}, {16, 2}, {32, 6}}}}};
  return detector;
}
const Detector& blazepose_detector() {
  static const Detector detector{&kBlazeposeDetection,
                                 4,
                                 Region::AroundFirstPoint,
                                 {{224, {{8, 2}, {16, 2}, {32, 6}}}, {128, {{8, 2}, {16, 6}}}}};
  return detector;
}

struct DetectorLayout {
  size_t boxes, scores;  // outputs
  const Variant* variant;
};

// Returns the variant with as many anchors whose input is the model's, or else the first with as
// many.
const Variant* find_variant(const Detector& detector, size_t anchors, Size input) {
  const Variant* found = nullptr;
  for (const Variant& variant : detector.variants) {
    if (variant.anchors() != anchors) continue;
    if (!found || input == Size{variant.input, variant.input}) found = &variant;
  }
  return found;
}

std::optional<DetectorLayout> find_layout(const Detector& detector, const ModelSignature& model) {
  if (model.outputs.size() != 2) return std::nullopt;
  for (const size_t boxes : {0u, 1u}) {
    const size_t count = matrix_rows(model.outputs[boxes], kMediapipeBox + 2 * detector.points);
    if (count == 0 || matrix_rows(model.outputs[1 - boxes], 1) != count) continue;
    if (const Variant* variant = find_variant(detector, count, model.input))
      return DetectorLayout{boxes, 1 - boxes, variant};
  }
  return std::nullopt;
}

// The anchors' centres as parts of the picture, in the order of the outputs.
std::vector<results::KeyPoint> make_anchors(const Variant& variant) {
  std::vector<results::KeyPoint> anchors;
  for (const auto& [stride, per_cell] : variant.grids) {
    const uint32_t cells = variant.input / stride;
    for (uint32_t i = 0; i < cells * cells * per_cell; ++i) {
      const uint32_t cell = i / per_cell, column = cell % cells, row = cell / cells;
      anchors.push_back({(static_cast<float>(column) + 0.5f) / static_cast<float>(cells),
                         (static_cast<float>(row) + 0.5f) / static_cast<float>(cells), 1});
    }
  }
  return anchors;
}

// The clockwise rotation that turns "up" to the direction from one point to the other.
float compute_rotation(const results::KeyPoint& from, const results::KeyPoint& to) noexcept {
  if (from.x == to.x && from.y == to.y) return 0;
  return std::atan2(to.x - from.x, from.y - to.y);
}

class AnchorHead final : public Head {
 public:
  AnchorHead(const Detector& detector, const DetectorLayout& layout, float threshold)
      : detector_(detector),
        layout_(layout),
        threshold_(threshold),
        anchors_(make_anchors(*layout.variant)) {}

  results::Features features() const override { return {.points_per_object = detector_.points}; }
  Suppression suppression() const noexcept override { return Suppression::AnyClass; }
  bool has_rotation() const noexcept override { return detector_.region != Region::Upright; }

  Candidates find(OutputValues& outputs, Size input) override {
    input = known(input);
    const auto scores = outputs.read(layout_.scores);
    Candidates found;
    for (size_t i = 0; i < anchors_.size(); ++i) {
      const float score = detection::sigmoid(scores[i]);
      if (!(score >= threshold_) || score == 0) continue;
      const float* values = get_values(outputs, i);
      const auto centre = point_at(i, values, input);
      const float width = values[2] * scale(input.width), height = values[3] * scale(input.height);
      const Candidate candidate{.x = centre.x - width / 2,
                                .y = centre.y - height / 2,
                                .width = width,
                                .height = height,
                                .score = score,
                                .class_index = 0,
                                .row = static_cast<uint32_t>(i)};
      if (candidate.is_finite()) found.push_back(candidate);
    }
    // Probabilities of good candidates are all 1; the logits say which is the best.
    std::stable_sort(found.begin(), found.end(), [&](const Candidate& a, const Candidate& b) {
      return scores[a.row] > scores[b.row];
    });
    return found;
  }

  void complete(OutputValues& outputs, std::span<const Candidate> kept, Size input,
                results::FrameResults* results) override {
    input = known(input);
    for (size_t i = 0; i < kept.size(); ++i) {
      const float* values = get_values(outputs, kept[i].row);
      const size_t first = results->points.size();
      for (size_t point = 0; point < detector_.points; ++point) {
        auto at = point_at(kept[i].row, values + kMediapipeBox + 2 * point, input);
        results->points.push_back(key_point(at.x, at.y, kept[i].score));
      }
      turn(results->points.data() + first, &results->objects[i]);
    }
  }

 private:
  Size known(Size input) const noexcept {
    const uint32_t side = layout_.variant->input;
    return input.width > 0 && input.height > 0 ? input : Size{side, side};
  }
  // The network's values are pixels of the published input.
  float scale(uint32_t pixels) const noexcept {
    return static_cast<float>(pixels) / static_cast<float>(layout_.variant->input);
  }
  const float* get_values(OutputValues& outputs, size_t anchor) const {
    return outputs.read(layout_.boxes).data() + (kMediapipeBox + 2 * detector_.points) * anchor;
  }
  results::KeyPoint point_at(size_t anchor, const float* values, Size input) const noexcept {
    return {anchors_[anchor].x * static_cast<float>(input.width) + values[0] * scale(input.width),
            anchors_[anchor].y * static_cast<float>(input.height) + values[1] * scale(input.height),
            1};
  }
  void turn(const results::KeyPoint* points, results::Object* object) const noexcept {
    if (detector_.region == Region::RotatedBox)
      object->rotation = compute_rotation(points[0], points[2]);
    if (detector_.region != Region::AroundFirstPoint) return;
    const float reach = std::hypot(points[1].x - points[0].x, points[1].y - points[0].y);
    object->rotation = compute_rotation(points[0], points[1]);
    object->box = {points[0].x - reach, points[0].y - reach, points[0].x + reach,
                   points[0].y + reach};
  }

  const Detector& detector_;
  DetectorLayout layout_;
  float threshold_;
  std::vector<results::KeyPoint> anchors_;
};

// MediaPipe's names of both outputs.
bool has_published_names(const ModelSignature& model) {
  return any_name_has(model, "regressors") && any_name_has(model, "classificators");
}

template <const Detector& (*kDetector)()>
Match fit(const ModelSignature& model) {
  if (!find_layout(kDetector(), model)) return Match::No;
  return has_published_names(model) ? Match::Certain : Match::Possible;
}

template <const Detector& (*kDetector)()>
std::unique_ptr<Head> open(const ModelSignature& model, const HeadOptions& options) {
  const auto layout = find_layout(kDetector(), model);
  if (!layout) throw wrong_outputs(model, *kDetector().family);
  return std::make_unique<AnchorHead>(kDetector(), *layout, options.threshold);
}

}  // namespace

const Family kBlazeface{.name = "blazeface",
                        .aliases = "mediapipe-face-detection",
                        .tasks = kDetection | kPose,
                        .outputs = "2 tensors 16:N and 1:N, N = 896 or 2304",
                        .custom = "",
                        .threshold = 0.5f,
                        .fit = fit<blazeface>,
                        .open = open<blazeface>};

const Family kPalmDetection{.name = "palm-detection",
                            .aliases = "mediapipe-palm-detection",
                            .tasks = kDetection | kPose,
                            .outputs = "2 tensors 18:N and 1:N, N = 2016 or 2944",
                            .custom = "",
                            .threshold = 0.5f,
                            .fit = fit<palm>,
                            .open = open<palm>};

const Family kBlazeposeDetection{.name = "blazepose-detection",
                                 .aliases = "mediapipe-pose-detection",
                                 .tasks = kDetection | kPose,
                                 .outputs = "2 tensors 12:N and 1:N, N = 2254 or 896",
                                 .custom = "",
                                 .threshold = 0.5f,
                                 .fit = fit<blazepose_detector>,
                                 .open = open<blazepose_detector>};

}  // namespace weir::heads
