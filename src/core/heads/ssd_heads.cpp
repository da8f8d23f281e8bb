// Reads SSD models.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/families.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/detection/anchors.hpp"
#include "core/heads/coordinates.hpp"
#include "core/heads/output_shapes.hpp"
#include "core/tensor/geometry.hpp"
#include "core/text/text_file.hpp"

namespace weir::heads {
namespace {

using detection::Candidates;

constexpr size_t kSsdBox = 4;

// ---- Raw ----

struct RawOutputs {
  size_t boxes = 0, scores = 0;  // outputs
  size_t anchors = 0, classes = 0;
};

// Dimensions of 1 are left out: boxes may be 4:1:N.
std::vector<uint32_t> get_extents(const Shape& shape) {
  std::vector<uint32_t> out;
  for (size_t i = 0; i < shape.rank(); ++i)
    if (shape[i] > 1) out.push_back(shape[i]);
  return out;
}

std::optional<RawOutputs> find_raw(const ModelSignature& model) {
  if (model.outputs.size() != 2) return std::nullopt;
  for (const size_t boxes : {0u, 1u}) {
    const auto box = get_extents(model.outputs[boxes].shape);
    const auto score = get_extents(model.outputs[1 - boxes].shape);
    if (box.size() != 2 || score.size() != 2 || box[0] != kSsdBox || box[1] != score[1]) continue;
    return RawOutputs{.boxes = boxes, .scores = 1 - boxes, .anchors = box[1], .classes = score[0]};
  }
  return std::nullopt;
}

// SSD MobileNet of 300 x 300 pixels is the only common one whose input size is not stated.
Size get_input_size(const ModelSignature& model) {
  return model.input.width > 0 ? model.input : Size{300, 300};
}

class Ssd final : public Head {
 public:
  Ssd(const RawOutputs& raw, Size input, detection::BoxPriors priors,
      const detection::SsdScales& scales, ScoreKind kind, bool has_background_label,
      float threshold)
      : raw_(raw),
        input_(input),
        priors_(std::move(priors)),
        scales_(scales),
        kind_(kind),
        has_background_label_(has_background_label),
        threshold_(threshold) {}

  results::Features features() const override { return {}; }
  // The background is not an object.
  size_t classes() const noexcept override { return raw_.classes - 1; }
  Suppression suppression() const noexcept override { return Suppression::ByClass; }

  Candidates find(OutputValues& outputs, Size input) override {
    const auto boxes = outputs.read(raw_.boxes);
    auto scores = outputs.read(raw_.scores);
    if (boxes.size() != raw_.anchors * kSsdBox || scores.size() != raw_.anchors * raw_.classes)
      throw Failure(
          {.code = Code::SPEC_MISMATCH,
           .what = "the frame has a different number of anchors than the head was opened for",
           .offered = std::to_string(boxes.size() / kSsdBox),
           .needed = std::to_string(raw_.anchors)});
    if (kind_ == ScoreKind::Automatic && are_logits(scores)) kind_ = ScoreKind::Logits;
    if (kind_ != ScoreKind::Logits) scores = to_logits(scores);
    // The least score above 0, because logits have no score 0.
    const float threshold = std::max(threshold_, 1e-6f);
    Candidates found =
        detection::decode({.boxes = boxes, .scores = scores, .classes = raw_.classes}, priors_,
                          scales_, threshold, input.width > 0 ? input : input_);
    std::erase_if(found, [](const auto& candidate) { return !std::isfinite(candidate.score); });
    if (!has_background_label_)
      for (auto& candidate : found) --candidate.class_index;
    return found;
  }

 private:
  std::span<const float> to_logits(std::span<const float> probabilities) {
    logits_.resize(probabilities.size());
    std::transform(probabilities.begin(), probabilities.end(), logits_.begin(),
                   [](float p) { return std::log(p / (1 - std::min(p, 1 - 1e-7f))); });
    return logits_;
  }

  RawOutputs raw_;
  Size input_;
  detection::BoxPriors priors_;
  detection::SsdScales scales_;
  ScoreKind kind_;  // logits, once one was seen
  bool has_background_label_;
  float threshold_;
  std::vector<float> logits_;
};

Match fit_ssd(const ModelSignature& model) {
  const auto raw = find_raw(model);
  if (!raw || raw->classes < 2) return Match::No;
  return detection::ssd_anchor_count(get_input_size(model)) == raw->anchors ? Match::Certain
                                                                            : Match::No;
}

detection::BoxPriors make_priors(const ModelSignature& model, const HeadOptions& options,
                                 const RawOutputs& raw) {
  const auto file = options.custom.find("priors");
  if (file == options.custom.end()) {
    const size_t usual = detection::ssd_anchor_count(get_input_size(model));
    if (usual == raw.anchors) return detection::make_ssd_anchors(get_input_size(model));
    throw Failure({.code = Code::SPEC_MISMATCH,
                   .what = "the anchors are not those of SSD MobileNet for this input size",
                   .offered = std::to_string(raw.anchors) + " anchors",
                   .needed = std::to_string(usual) + ", or a file of prior boxes",
                   .fix = "custom=priors:/path/to/box_priors.txt"});
  }
  auto priors = detection::parse_box_priors(read_text_file("custom=priors", file->second));
  if (!priors) {
    Error error = priors.error();
    error.offered = "custom=priors:" + file->second;
    throw Failure(std::move(error));
  }
  if (priors->size() >= raw.anchors) return *std::move(priors);
  throw Failure({.code = Code::SPEC_MISMATCH,
                 .what = "the file has fewer prior boxes than the model has anchors",
                 .offered = std::to_string(priors->size()) + " in " + file->second,
                 .needed = std::to_string(raw.anchors)});
}

detection::SsdScales parse_scales(const HeadOptions& options) {
  const auto numbers = numbers_setting(options, "scales", "10/10/5/5");
  if (numbers.empty()) return {};
  const bool are_good = numbers.size() == 4 && std::all_of(numbers.begin(), numbers.end(),
                                                           [](float scale) { return scale > 0; });
  if (!are_good)
    throw wrong_setting(options, "scales", "four numbers above 0: y/x/height/width", "10/10/5/5");
  return {numbers[0], numbers[1], numbers[2], numbers[3]};
}

std::unique_ptr<Head> open_ssd(const ModelSignature& model, const HeadOptions& options) {
  const auto raw = find_raw(model);
  if (!raw || raw->classes < 2) throw wrong_outputs(model, kSsd);
  const bool has_background_label = model.labels + 1 != raw->classes;
  return std::make_unique<Ssd>(*raw, get_input_size(model), make_priors(model, options, *raw),
                               parse_scales(options), score_kind(options), has_background_label,
                               options.threshold);
}

// ---- Post-processed ----

// Outputs; classes and scores have the same shape.
struct Postprocessed {
  size_t boxes = 0, count = 0, classes = 0, scores = 0;
  bool is_certain = false;  // which are classes and which scores, by the names
};

// The output that has boxes, where only one has.
std::optional<size_t> find_boxes(const ModelSignature& model) {
  std::optional<size_t> boxes;
  for (size_t i = 0; i < model.outputs.size(); ++i) {
    const Shape& shape = model.outputs[i].shape;
    if (shape[0] != kSsdBox || shape.min_rank() != 2) continue;
    if (boxes) return std::nullopt;
    boxes = i;
  }
  return boxes;
}

// Finds the outputs by their shapes alone. The layer's own order is boxes, classes, scores, count.
std::optional<Postprocessed> find_by_shapes(const ModelSignature& model) {
  constexpr size_t kOutputs = 4;
  if (model.outputs.size() != kOutputs) return std::nullopt;
  const auto boxes = find_boxes(model);
  if (!boxes) return std::nullopt;
  const uint32_t rows = model.outputs[*boxes].shape[1];
  std::vector<size_t> lists, counts;
  for (size_t i = 0; i < kOutputs; ++i) {
    const Shape& shape = model.outputs[i].shape;
    if (i == *boxes || shape.min_rank() != 1) continue;
    if (shape[0] == rows) lists.push_back(i);
    if (shape[0] == 1) counts.push_back(i);
  }
  if (lists.size() != 2 || counts.size() != 1) return std::nullopt;
  return Postprocessed{
      .boxes = *boxes, .count = counts[0], .classes = lists[0], .scores = lists[1]};
}

std::optional<Postprocessed> find_postprocessed(const ModelSignature& model) {
  auto out = find_by_shapes(model);
  if (!out) return std::nullopt;
  const std::array lists{out->classes, out->scores};
  for (const size_t i : lists) {
    if (has_name_with(model.outputs[i], "score")) out->scores = i, out->is_certain = true;
    if (has_name_with(model.outputs[i], "class")) out->classes = i, out->is_certain = true;
  }
  if (has_name_with(model.outputs[out->boxes], "postprocess")) out->is_certain = true;
  if (out->classes == out->scores) out->classes = lists[0] == out->scores ? lists[1] : lists[0];
  return out;
}

class SsdPostprocess final : public Head {
 public:
  SsdPostprocess(const Postprocessed& outputs, Size input, Unit unit, float first_class,
                 float threshold)
      : outputs_(outputs),
        input_(input),
        first_class_(first_class),
        boxes_(unit, threshold, true) {}

  results::Features features() const override { return {}; }

  Candidates find(OutputValues& outputs, Size input) override {
    const auto boxes = outputs.read(outputs_.boxes);
    auto classes = outputs.read(outputs_.classes), scores = outputs.read(outputs_.scores);
    const float stated = outputs.read(outputs_.count)[0];
    const auto rows =
        static_cast<float>(std::min({scores.size(), classes.size(), boxes.size() / kSsdBox}));
    const auto count = static_cast<size_t>(stated > 0 ? std::min(stated, rows) : 0);
    if (!outputs_.is_certain && are_classes(scores.first(count)) &&
        !are_classes(classes.first(count)))
      std::swap(classes, scores);
    boxes_.begin();
    for (size_t i = 0; i < count; ++i) {
      const auto box = boxes.subspan(i * kSsdBox, kSsdBox);  // top, left, bottom, right
      const std::array corners{box[1], box[0], box[3], box[2]};
      boxes_.add(corners, scores[i], classes[i] - first_class_, i);
    }
    auto found = boxes_.take(input.width > 0 ? input : input_);
    warn_once(boxes_.contradiction());
    return found;
  }

 private:
  // Scores are whole numbers only by chance; those of a frame are, if all are 0 or 1.
  static bool are_classes(std::span<const float> numbers) {
    return std::all_of(numbers.begin(), numbers.end(),
                       [](float number) { return number >= 0 && number == std::floor(number); });
  }

  Postprocessed outputs_;
  Size input_;
  float first_class_;
  CornerBoxes boxes_;
};

Match fit_ssd_postprocess(const ModelSignature& model) {
  const auto outputs = find_postprocessed(model);
  return !outputs ? Match::No : outputs->is_certain ? Match::Certain : Match::Possible;
}

std::unique_ptr<Head> open_ssd_postprocess(const ModelSignature& model,
                                           const HeadOptions& options) {
  const auto outputs = find_postprocessed(model);
  if (!outputs) throw wrong_outputs(model, kSsdPostprocess);
  // TensorFlow's own detectors count classes from 1.
  const bool from_one = has_name_with(model.outputs[outputs->classes], "detection_classes");
  const auto first = number_setting(options, "first-class", -1000, 1000);
  return std::make_unique<SsdPostprocess>(*outputs, model.input, unit_setting(options),
                                          static_cast<float>(first.value_or(from_one ? 1 : 0)),
                                          options.threshold);
}

}  // namespace

const Family kSsd{.name = "ssd",
                  .aliases = "ssd-mobilenet",
                  .tasks = kDetection,
                  .outputs =
                      "boxes 4:N and scores CLASSES+1:N in any order, the first of the "
                      "background",
                  .custom = "priors,scales,scores",
                  .threshold = 0.5f,
                  .fit = fit_ssd,
                  .open = open_ssd};

const Family kSsdPostprocess{.name = "ssd-postprocess",
                             .aliases = "efficientdet",
                             .tasks = kDetection,
                             .outputs = "boxes 4:N, classes N, scores N, count 1 in any order",
                             .custom = "unit,first-class",
                             .threshold = 0.5f,
                             .fit = fit_ssd_postprocess,
                             .open = open_ssd_postprocess};

}  // namespace weir::heads
