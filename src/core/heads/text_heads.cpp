// Reads boxes of text from probability maps, and characters from their probabilities.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/families.hpp"

#include <algorithm>
#include <cmath>

#include "core/detection/best_class.hpp"
#include "core/detection/text_regions.hpp"
#include "core/heads/head_options.hpp"
#include "core/heads/output_shapes.hpp"
#include "core/heads/readings.hpp"
#include "core/tensor/geometry.hpp"
#include "core/text/text.hpp"

namespace weir::heads {
namespace {

using detection::Candidate;
using detection::Candidates;

struct MapSize {
  size_t width = 0, height = 0;
};

// The size of the only output if it is one map of the input's proportions. Text networks accept
// multiples of 32 pixels.
std::optional<MapSize> find_map_size(const ModelSignature& model) {
  if (model.outputs.size() != 1 || model.outputs[0].shape.min_rank() > 2) return std::nullopt;
  const size_t width = model.outputs[0].shape[0], height = model.outputs[0].shape[1];
  if (width < 2 || height < 2) return std::nullopt;
  const Size input = model.input;
  const bool fits = input.width > 0 && input.height > 0
                        ? input.width % width == 0 && input.width / width * height == input.height
                        : width % 32 == 0 && height % 32 == 0;
  return fits ? std::optional(MapSize{width, height}) : std::nullopt;
}

// A setting of the head: a number from 0 to `max`.
float read_setting(const HeadOptions& options, const std::string& key, float otherwise, float max,
                   const char* fix) {
  const auto found = options.custom.find(key);
  if (found == options.custom.end()) return otherwise;
  const auto value = parse_double(found->second);
  if (value && *value >= 0 && *value <= double{max}) return static_cast<float>(*value);
  throw Failure({.code = Code::OPTION_VALUE,
                 .what = "the value of " + key + " cannot be used",
                 .offered = "custom=" + key + ":" + found->second,
                 .needed = "a number from 0 to " + std::to_string(static_cast<int>(max)),
                 .fix = fix});
}

class Db final : public Head {
 public:
  Db(MapSize map, const detection::TextRegionOptions& options) : map_(map), options_(options) {}

  results::Features features() const override { return {}; }
  bool has_rotation() const noexcept override { return true; }

  Candidates find(OutputValues& outputs, Size input) override {
    const float scale =
        input.width > 0 ? static_cast<float>(input.width) / static_cast<float>(map_.width) : 1.0f;
    Candidates found;
    for (const auto& region : find_text_regions(outputs.read(0), map_.width, map_.height, options_))
      found.push_back({.x = (region.x - region.width / 2) * scale,
                       .y = (region.y - region.height / 2) * scale,
                       .width = region.width * scale,
                       .height = region.height * scale,
                       .score = region.score,
                       .class_index = 0,
                       .row = static_cast<uint32_t>(found.size()),
                       .angle = region.angle});
    std::erase_if(found, [](const Candidate& candidate) { return !(candidate.score > 0); });
    return found;
  }

 private:
  MapSize map_;
  detection::TextRegionOptions options_;
};

Match fit_db(const ModelSignature& model) {
  if (!find_map_size(model) || !(stated_tasks(model) & kText)) return Match::No;
  return any_name_has(model, "sigmoid") ? Match::Certain : Match::Possible;
}

std::unique_ptr<Head> open_db(const ModelSignature& model, const HeadOptions& options) {
  const auto map = find_map_size(model);
  if (!map) throw wrong_outputs(model, kDb);
  constexpr float kMaxGrowth = 10;
  const detection::TextRegionOptions usual;
  return std::make_unique<Db>(
      *map, detection::TextRegionOptions{
                .min_pixel = read_setting(options, "pixel-threshold", usual.min_pixel, 1,
                                          "custom=pixel-threshold:0.3"),
                .min_score = options.threshold,
                .unclip = read_setting(options, "unclip", usual.unclip, kMaxGrowth,
                                       "custom=unclip:1.5")});
}

// Graves et al., "Connectionist Temporal Classification", 2006: the best class of each step,
// without repetitions and without class 0, the blank.

struct StepsLayout {
  size_t classes = 0, steps = 0;
};

// CLASSES:STEPS, or CLASSES:1:STEPS where a batch is the middle dimension.
std::optional<StepsLayout> find_steps(const ModelSignature& model) {
  const bool is_map = model.input.width > 0 && find_map_size(model);
  if (model.outputs.size() != 1 || is_map) return std::nullopt;
  const Shape& shape = model.outputs[0].shape;
  const size_t classes = shape[0];
  const bool batch_is_inside = shape[1] == 1 && shape.min_rank() == 3;
  const size_t steps = batch_is_inside ? shape[2] : shape[1];
  const bool fits = classes > 1 && steps > 0 && (batch_is_inside || shape.min_rank() <= 2);
  return fits ? std::optional(StepsLayout{classes, steps}) : std::nullopt;
}

class Ctc final : public Head {
 public:
  Ctc(StepsLayout layout, std::vector<std::string> characters, float threshold)
      : layout_(layout), characters_(std::move(characters)), threshold_(threshold) {}

  results::Features features() const override { return {.has_boxes = false, .has_texts = true}; }

  Candidates find(OutputValues& outputs, Size) override {
    const auto all = outputs.read(0);
    text_.clear();
    float sum = 0;
    size_t kept = 0, previous = 0;
    for (size_t step = 0; step < layout_.steps; ++step) {
      const auto values = all.subspan(step * layout_.classes, layout_.classes);
      const float max = detection::best_score(values);
      const size_t best = max > -INFINITY ? static_cast<size_t>(detection::class_with(values, max))
                                          : 0;  // nothing but NaN
      if (best != 0 && best != previous) {
        text_ += characters_[best - 1];
        sum += probability(values, max);
        ++kept;
      }
      previous = best;
    }
    if (kept == 0) return {};
    const float score = sum / static_cast<float>(kept);
    if (!(score >= threshold_) || score == 0) return {};
    return {{.score = score, .class_index = 0}};
  }

  void complete(OutputValues&, std::span<const Candidate> kept, Size,
                results::FrameResults* results) override {
    if (!kept.empty()) results->texts.push_back(text_);
  }

 private:
  // Returns the probability of the class with the greatest value; values outside 0 to 1 are logits.
  static float probability(std::span<const float> values, float max) {
    const bool are_logits =
        max > 1 || std::any_of(values.begin(), values.end(), [](float value) { return value < 0; });
    if (!are_logits) return max;
    float sum = 0;
    for (const float value : values)
      if (value == value) sum += std::exp(value - max);
    return to_probability(1 / sum);
  }

  StepsLayout layout_;
  std::vector<std::string> characters_;  // of class 1 and those after it
  float threshold_;
  std::string text_;
};

// Whether a dictionary of this length fits: PP-OCR adds the blank before it and a space after it.
bool has_characters(const StepsLayout& layout, size_t characters) {
  return layout.classes == characters + 1 || layout.classes == characters + 2;
}

Match fit_ctc(const ModelSignature& model) {
  const auto layout = find_steps(model);
  if (!layout) return Match::No;
  const bool is_named = any_name_has(model, "softmax");
  return is_named || (model.labels > 0 && has_characters(*layout, model.labels)) ? Match::Certain
                                                                                 : Match::Possible;
}

std::unique_ptr<Head> open_ctc(const ModelSignature& model, const HeadOptions& options) {
  const auto layout = find_steps(model);
  if (!layout) throw wrong_outputs(model, kCtc);
  std::vector<std::string> characters = options.labels;
  if (!has_characters(*layout, characters.size()))
    throw Failure({.code = Code::LABELS_INVALID,
                   .what = characters.empty() ? "text recognition needs the model's dictionary"
                                              : "the dictionary does not fit the model",
                   .offered = std::to_string(characters.size()) + " characters",
                   .needed = std::to_string(layout->classes - 2) + " or " +
                             std::to_string(layout->classes - 1) + " characters for " +
                             std::to_string(layout->classes) + " classes, one on each line",
                   .fix = "tensor_decoder labels=/path/to/dictionary.txt"});
  if (characters.size() + 2 == layout->classes) characters.emplace_back(" ");
  return std::make_unique<Ctc>(*layout, std::move(characters), options.threshold);
}

}  // namespace

const Family kCtc{.name = "ctc",
                  .aliases = "pp-ocr-recognition,crnn",
                  .tasks = kText,
                  .outputs = "1 tensor CLASSES:STEPS or CLASSES:1:STEPS, with labels=FILE",
                  .custom = "",
                  .threshold = 0.5f,
                  .fit = fit_ctc,
                  .open = open_ctc};

const Family kDb{.name = "db",
                 .aliases = "pp-ocr-detection",
                 .tasks = kDetection | kText,
                 .outputs = "1 tensor W:H of the input's proportions",
                 .custom = "pixel-threshold,unclip",
                 .threshold = 0.6f,
                 .fit = fit_db,
                 .open = open_db};

}  // namespace weir::heads
