// Reads classifiers, and turns logits into probabilities.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/families.hpp"

#include <algorithm>
#include <cmath>

#include "core/heads/coordinates.hpp"
#include "core/heads/output_shapes.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::heads {
namespace {

using detection::Candidates;

// What an 8-bit output of an unknown quantisation is divided by: 1 is its greatest value.
struct Steps {
  float first = 0, count = 1;
};
Steps get_steps(const OutputSignature& output) {
  if (output.is_quantised) return {};
  if (output.type == ElementType::UInt8) return {0, 255};
  if (output.type == ElementType::Int8) return {-128, 255};
  return {};
}

class Classifier final : public Head {
 public:
  Classifier(const OutputSignature& output, ScoreKind kind, float threshold)
      : classes_(element_count(output)),
        steps_(get_steps(output)),
        kind_(kind),
        threshold_(threshold) {}

  size_t classes() const noexcept override { return classes_; }

  // A frame is one picture, or one region: rows have no box.
  results::Features features() const override {
    return {.has_boxes = false, .has_class_scores = true};
  }

  Candidates find(OutputValues& outputs, Size) override {
    const auto numbers = outputs.read(0);
    scores_.assign(numbers.begin(), numbers.end());
    if (steps_.count != 1)
      for (float& score : scores_) score = (score - steps_.first) / steps_.count;
    if (kind_ == ScoreKind::Automatic && are_logits(scores_)) kind_ = ScoreKind::Logits;
    if (kind_ == ScoreKind::Logits) apply_softmax();
    Candidates found;
    for (size_t i = 0; i < scores_.size(); ++i)
      if (reaches(scores_[i], threshold_))
        found.push_back({.score = scores_[i],
                         .class_index = static_cast<int32_t>(i),
                         .row = static_cast<uint32_t>(i)});
    return found;
  }

  void complete(OutputValues&, std::span<const detection::Candidate> kept, Size,
                results::FrameResults* results) override {
    results->n_classes = scores_.size();
    for (size_t i = 0; i < kept.size(); ++i)
      results->class_scores.insert(results->class_scores.end(), scores_.begin(), scores_.end());
  }

 private:
  // Logits that are not numbers count as those of impossible classes.
  void apply_softmax() {
    float max = -INFINITY;
    for (const float score : scores_)
      if (std::isfinite(score)) max = std::max(max, score);
    double sum = 0;
    for (float& score : scores_) {
      score = std::isfinite(score) ? std::exp(score - max) : 0.0f;
      sum += score;
    }
    if (sum > 0)
      for (float& score : scores_) score = static_cast<float>(score / sum);
  }

  size_t classes_;  // 0 = not known
  Steps steps_;
  ScoreKind kind_;  // logits, once one was seen
  float threshold_;
  std::vector<float> scores_;
};

// One output of at least two numbers in one dimension.
bool is_list(const ModelSignature& model) {
  if (model.outputs.size() != 1) return false;
  const Shape& shape = model.outputs[0].shape;
  size_t extents = 0;
  for (size_t i = 0; i < shape.rank(); ++i) extents += shape[i] > 1;
  return extents == 1;
}

}  // namespace

const Family kClassifier{
    .name = "classifier",
    .aliases = "yolov8-cls,yolov11-cls,yolo11-cls,yolov5-cls",
    .tasks = kClassification,
    .outputs = "1 tensor CLASSES, logits or probabilities",
    .custom = "scores",
    .threshold = 0.1f,
    .fit = [](const ModelSignature& model) { return is_list(model) ? Match::Possible : Match::No; },
    .open = [](const ModelSignature& model, const HeadOptions& options) -> std::unique_ptr<Head> {
      if (!is_list(model)) throw wrong_outputs(model, kClassifier);
      return std::make_unique<Classifier>(model.outputs[0], score_kind(options), options.threshold);
    }};

}  // namespace weir::heads
