// Reads the points and the presence of MediaPipe's landmark networks.
//
// Follows the published graphs (hand_landmark, face_landmark, pose_landmark): points are pixels of
// the input; the presence of faces and the visibility of points are logits, the rest probabilities.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/families.hpp"

#include <algorithm>

#include "core/detection/sigmoid.hpp"
#include "core/heads/head_options.hpp"
#include "core/heads/output_shapes.hpp"
#include "core/heads/points_head.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::heads {
namespace {

using detection::Candidates;

// One form of the tensor of points.
struct PointTensor {
  size_t points;    // in the tensor
  size_t reported;  // the first ones; the others are auxiliary
  size_t values;    // of each point: x, y, z and, of 4 or more, the visibility
};

struct Network {
  const Family* family;
  std::vector<PointTensor> forms;
  bool presence_is_logit;
  bool has_side;  // a second number is the probability of a right hand
};

const Network& blazepose() {
  static const Network network{
      &kBlazepose, {{39, 33, 5}, {33, 33, 5}, {39, 33, 4}, {33, 33, 4}}, false, false};
  return network;
}
const Network& face() {
  static const Network network{&kFaceLandmarks, {{468, 468, 3}, {478, 478, 3}}, true, false};
  return network;
}
const Network& hand() {
  static const Network network{&kHandLandmarks, {{21, 21, 3}}, false, true};
  return network;
}

struct LandmarkLayout {
  PointTensor form;
  size_t points, presence;  // outputs
  std::optional<size_t> side;
};

// The outputs in the published order. Converters number them (Identity, Identity_1, ...) and may
// store them in another order.
std::vector<size_t> published_order(const ModelSignature& model) {
  std::vector<size_t> order(model.outputs.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto& outputs = model.outputs;
  if (std::all_of(outputs.begin(), outputs.end(), [](const OutputSignature& output) {
        return output.name.starts_with("Identity");
      }))
    std::stable_sort(order.begin(), order.end(),
                     [&](size_t a, size_t b) { return outputs[a].name < outputs[b].name; });
  return order;
}

std::optional<LandmarkLayout> find_layout(const Network& network, const ModelSignature& model) {
  const auto order = published_order(model);
  std::vector<size_t> numbers;
  for (const size_t i : order)
    if (element_count(model.outputs[i]) == 1) numbers.push_back(i);
  if (numbers.empty()) return std::nullopt;
  for (const PointTensor& form : network.forms)
    for (const size_t i : order) {
      const OutputSignature& output = model.outputs[i];
      const size_t count = form.points * form.values;
      if (element_count(output) != count || has_name_with(output, "world")) continue;
      const bool has_side = network.has_side && numbers.size() > 1;
      return LandmarkLayout{form, i, numbers[0],
                            has_side ? std::optional(numbers[1]) : std::nullopt};
    }
  return std::nullopt;
}

class LandmarkHead final : public PointsHead {
 public:
  LandmarkHead(const Network& network, const LandmarkLayout& layout, float threshold)
      : PointsHead(layout.form.reported),
        network_(network),
        layout_(layout),
        threshold_(threshold) {}

  Candidates find(OutputValues& outputs, Size) override {
    begin();
    const float presence = outputs.read(layout_.presence)[0];
    const float score =
        to_probability(network_.presence_is_logit ? detection::sigmoid(presence) : presence);
    if (!(score >= threshold_) || score == 0) return {};
    const float* values = outputs.read(layout_.points).data();
    std::vector<results::KeyPoint> points;
    for (size_t i = 0; i < points_per_object(); ++i, values += layout_.form.values)
      points.push_back(key_point(
          values[0], values[1],
          layout_.form.values > 3 ? to_probability(detection::sigmoid(values[3])) : score));
    const bool is_right = layout_.side && outputs.read(*layout_.side)[0] > 0.5f;
    add(points, kMinVisibility, score, is_right ? 1 : 0);
    return take();
  }

 private:
  static constexpr float kMinVisibility = 0.5f;  // of points that the box surrounds

  const Network& network_;
  LandmarkLayout layout_;
  float threshold_;
};

template <const Network& (*kNetwork)()>
Match fit(const ModelSignature& model) {
  return find_layout(kNetwork(), model) ? Match::Possible : Match::No;
}

template <const Network& (*kNetwork)()>
std::unique_ptr<Head> open(const ModelSignature& model, const HeadOptions& options) {
  const auto layout = find_layout(kNetwork(), model);
  if (!layout) throw wrong_outputs(model, *kNetwork().family);
  return std::make_unique<LandmarkHead>(kNetwork(), *layout, options.threshold);
}

}  // namespace

const Family kBlazepose{.name = "blazepose",
                        .aliases = "mediapipe-pose-landmarks",
                        .tasks = kPose,
                        .outputs =
                            "a tensor of 39 or 33 points of 5 or 4 numbers, one number "
                            "(presence)",
                        .custom = "",
                        .threshold = 0.5f,
                        .fit = fit<blazepose>,
                        .open = open<blazepose>};

const Family kFaceLandmarks{.name = "face-landmarks",
                            .aliases = "mediapipe-face-landmarks,face-mesh",
                            .tasks = kPose,
                            .outputs =
                                "a tensor of 468 or 478 points of 3 numbers, one number "
                                "(presence)",
                            .custom = "",
                            .threshold = 0.5f,
                            .fit = fit<face>,
                            .open = open<face>};

const Family kHandLandmarks{.name = "hand-landmarks",
                            .aliases = "mediapipe-hand-landmarks",
                            .tasks = kPose,
                            .outputs =
                                "a tensor of 21 points of 3 numbers, one number (presence), "
                                "then one (right hand)",
                            .custom = "",
                            .threshold = 0.5f,
                            .fit = fit<hand>,
                            .open = open<hand>};

}  // namespace weir::heads
