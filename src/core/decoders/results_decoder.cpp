// Finds the head of a model's outputs, reads each frame with it and writes the results.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/decoders.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/decoders/option_text.hpp"
#include "core/decoders/stream_model.hpp"
#include "core/detection/candidate.hpp"
#include "core/heads/families.hpp"
#include "core/results/merge_parts.hpp"
#include "core/results/object_selection.hpp"
#include "core/results/picture_coordinates.hpp"
#include "core/results/results_writer.hpp"
#include "core/tensor/geometry.hpp"
#include "core/text/shell_quote.hpp"
#include "core/text/text.hpp"
#include "core/text/text_file.hpp"
#include "weir/decoder.hpp"
#include "weir/join.hpp"
#include "weir/label_file.hpp"
#include "weir/module.hpp"
#include "weir/source_map.hpp"

namespace weir::decoders {
namespace {

struct ResultsSettings {
  std::optional<float> threshold;  // default: the head's
  float iou = 0.45f;
  size_t max_results = 100;
  std::vector<std::string> labels;
  std::vector<std::string> classes;  // names or numbers, as the user wrote them; empty = all
  std::string head;                  // "" = recognised
  Size input;                        // of the model; 0 x 0 = from the stream
  std::string name;                  // weir-source; "" = the model's file
  std::map<std::string, std::string> custom;  // of the head

  // The class indices of `classes`, which are among `names` or numbers. Throws Failure
  // (OPTION_VALUE) for others.
  std::vector<int32_t> class_indices(const std::vector<std::string>& names) const;
};

constexpr size_t kMaxResults = 65536;

Failure invalid(const std::string& option, std::string_view value, std::string needed,
                std::string fix) {
  return Failure({.code = Code::OPTION_VALUE,
                  .what = "the value of " + option + " cannot be used",
                  .offered = option + "=" + std::string(value),
                  .needed = std::move(needed),
                  .fix = std::move(fix)});
}

// A part of 1: a score or an overlap.
std::optional<float> read_part(const Options& options, const std::string& option, const char* fix) {
  const auto text = options.get(option);
  if (!text || text->empty()) return std::nullopt;
  float value = 0;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
  if (error != std::errc() || end != text->data() + text->size() || !(value >= 0 && value <= 1))
    throw invalid(option, *text, "a number from 0 to 1", fix);
  return value;
}

size_t read_max_results(const Options& options, size_t otherwise) {
  const auto text = options.get("max-results");
  if (!text || text->empty()) return otherwise;
  size_t value = 0;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
  if (error != std::errc() || end != text->data() + text->size() || value == 0 ||
      value > kMaxResults)
    throw invalid("max-results", *text, "a whole number from 1 to 65536", "max-results=100");
  return value;
}

bool is_number(std::string_view text) {
  return !text.empty() &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

void set_text(const std::string& key, const std::string& value, ResultsSettings* out) {
  if (key == "labels")
    out->labels = read_label_file("labels", value);
  else if (key == "classes")
    out->classes = parse_name_list(value);
  else if (key == "head")
    out->head = value;
  else if (key == "name")
    out->name = value;
  else
    out->custom[key] = value;
  // A head reads it when it is chosen: with the caps.
  if (key == "priors") static_cast<void>(read_text_file("custom=priors", value));
}

std::vector<int32_t> ResultsSettings::class_indices(const std::vector<std::string>& names) const {
  std::vector<int32_t> out;
  for (const std::string& name : classes) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) {
      out.push_back(static_cast<int32_t>(found - names.begin()));
    } else if (is_number(name) && name.size() < 8) {
      out.push_back(std::stoi(name));
    } else {
      const std::string close = nearest(name, names);
      throw Failure({.code = Code::OPTION_VALUE,
                     .what = "a class is neither a label nor a number",
                     .offered = "classes=" + name,
                     .needed = names.empty() ? "numbers of classes, or labels=FILE for names"
                                             : "one of the " + std::to_string(names.size()) +
                                                   " labels, or a number",
                     .difference = close.empty() ? "" : "did you mean " + close + "?",
                     .fix = close.empty() ? "" : "classes=" + launch_value(close)});
    }
  }
  return out;
}

// Throws Failure (OPTION_VALUE and those of label files) with the property's name.
ResultsSettings read_results_settings(const Options& options) {
  ResultsSettings out;
  out.threshold = read_part(options, "threshold", "threshold=0.5");
  out.iou = read_part(options, "iou", "iou=0.45").value_or(out.iou);
  out.max_results = read_max_results(options, out.max_results);
  constexpr std::string_view kNumbers[] = {"threshold", "iou", "max-results", "input"};
  for (const weir_option& option : options.all()) {
    if (!option.key || !option.value || !*option.value) continue;
    const std::string_view key = option.key;
    if (std::find(std::begin(kNumbers), std::end(kNumbers), key) == std::end(kNumbers))
      set_text(option.key, option.value, &out);
  }
  if (options.get("input")) {
    const Size size = read_size(options, "input", "the size of the model's input");
    out.input = {size.width, size.height};
  }
  return out;
}

// Throws Failure (OPTION_VALUE) for a setting of another head.
void check_custom(const heads::Family& family, const ResultsSettings& settings) {
  const auto known = parse_name_list(family.custom);
  const auto is_known = [&](const std::string& key) {
    return std::find(known.begin(), known.end(), key) != known.end();
  };
  const std::string head(family.name);
  std::string unknown, fix = "head:" + head;
  for (const auto& [key, value] : settings.custom)
    if (is_known(key))
      fix += "," + key + ":" + value;
    else if (unknown.empty())
      unknown = key + ":" + value;
  if (unknown.empty()) return;
  if (settings.input.width > 0)
    fix += ",input:" + std::to_string(settings.input.width) + ":" +
           std::to_string(settings.input.height);
  if (!settings.name.empty()) fix += ",name:" + settings.name;
  throw Failure({.code = Code::OPTION_VALUE,
                 .what = "the head " + head + " does not read this setting",
                 .offered = "custom=" + unknown,
                 .needed = known.empty() ? "head, input or name: " + head + " has no settings"
                                         : "one of: head, input, name, " + join(known, ", "),
                 .fix = "custom=" + launch_value(fix)});
}

// Declares these options for a mode whose heads have one of `tasks` (heads::Task).
std::string results_options_json(uint32_t tasks) {
  std::string out =
      R"([{"name":"threshold","type":"number","default":"","help":"Minimum score, 0 to 1"},)"
      R"({"name":"iou","type":"number","default":"0.45","help":"Overlap beyond which the weaker of two boxes is removed"},)"
      R"({"name":"labels","type":"file","default":"","help":"Label file: one label per line"},)"
      R"({"name":"max-results","type":"integer","default":"100","help":"Maximum number of objects of a frame"},)"
      R"({"name":"classes","type":"text","default":"","help":"Classes to keep: labels or numbers, separated by commas"},)"
      R"({"name":"head","type":"text","default":"","help":"Family of the model's outputs"},)"
      R"({"name":"input","type":"text","default":"","help":"Size of the model's input, W:H"},)"
      R"({"name":"name","type":"text","default":"","help":"Name of the source of the results"})";
  std::vector<std::string> known;
  for (const heads::Family* family : heads::all_families()) {
    if (!(family->tasks & tasks)) continue;
    for (const std::string& name : parse_name_list(family->custom)) {
      if (std::find(known.begin(), known.end(), name) != known.end()) continue;
      known.push_back(name);
      out += R"(,{"name":")" + name + R"(","type":"text","default":"","help":"Of the head )" +
             std::string(family->name) + R"("})";
    }
  }
  return out + "]";
}

using results::Features;
using results::FrameResults;

results::SuppressionScope to_rivals(heads::Suppression suppression) {
  switch (suppression) {
    case heads::Suppression::None:
      return results::SuppressionScope::None;
    case heads::Suppression::ByClass:
      return results::SuppressionScope::SameClass;
    case heads::Suppression::AnyClass:
      return results::SuppressionScope::AnyClass;
    case heads::Suppression::Rotated:
      return results::SuppressionScope::SameClassRotated;
  }
  return results::SuppressionScope::SameClass;
}

// A mode whose heads have one of the bits `tasks` (heads::Task).
class ResultsDecoder {
 public:
  ResultsDecoder(const Options& options, uint32_t tasks)
      : tasks_(tasks), settings_(read_results_settings(options)) {
    if (settings_.head.empty()) return;
    named_ = &heads::family_named(settings_.head, tasks_);
    check_custom(*named_, settings_);
  }

  void set_model(const weir_stream_model* model) noexcept { model_.set(model); }
  void set_stream(const DecoderStream&) noexcept {}
  std::span<const char* const> labels() noexcept { return label_texts_; }
  size_t classes() noexcept { return head_ ? head_->classes() : 0; }
  std::optional<Error> next_warning() { return std::exchange(warning_, std::nullopt); }

  void configure(std::span<const weir_tensor_info> inputs, DecoderOutput& output) {
    open_first(model_.facts(inputs, settings_.input, settings_.labels.size()));
    classes_ = settings_.class_indices(class_labels());
    label_texts_.clear();
    const bool has_classes = !features_.has_texts && !features_.has_depth;
    if (has_classes)
      for (const std::string& label : class_labels()) label_texts_.push_back(label.c_str());
    output.set_caps(
        results::make_caps(features_, settings_.name.empty() ? model_.name() : settings_.name));
  }

  bool decode(const weir_frame& frame, DecoderOutput& output) {
    FrameRegions regions(frame);
    results_.clear();
    const bool are_tiles = find_tiles(regions);
    tile_of_.clear();
    for (uint32_t i = 0; i < regions.count(); ++i) {
      const auto map = regions.map(i);
      read(regions.tensors(i), map);
      if (are_tiles)
        tile_of_.resize(tile_of_.size() + part_.objects.size(), i);
      else if (regions.are_regions())
        for (auto& object : part_.objects) object.parent = regions.row(i);
      results::append(&part_, features_, &results_);
    }
    if (are_tiles)
      results::merge_parts({.boxes = tiles_, .part_of = tile_of_, .picture = picture_},
                           settings_.iou, settings_.max_results, &results_);
    results::write(results_, features_, [&](size_t bytes) { return output.reserve(bytes); });
    return true;
  }

 private:
  // Whether the regions are tiles of the picture in which detectors look for objects. Those that
  // were cut out for rows of results belong to these rows.
  bool find_tiles(const FrameRegions& regions) {
    tiles_.clear();
    const bool finds_objects =
        (tasks_ & heads::kDetection) != 0 || head_->suppression() != heads::Suppression::None;
    if (!regions.are_regions() || !features_.has_boxes || !finds_objects) return false;
    for (uint32_t i = 0; i < regions.count(); ++i) {
      const auto map = regions.map(i);
      if (!map || map->row > 0) return false;
      const auto width = static_cast<float>(map->width), height = static_cast<float>(map->height);
      tiles_.push_back(results::upright_box(*map, {0, 0, width, height}));
      picture_ = {map->source_width, map->source_height};
    }
    return results::are_tiles(tiles_, picture_);
  }

  // The outputs of one picture, or of a batch of them.
  void open_first(const heads::ModelSignature& facts) {
    try {
      open_head(facts);
    } catch (const Failure& first) {
      const auto single = without_batch(facts);
      if (!single) throw;
      try {
        open_head(*single);
      } catch (const Failure&) {
        throw first;
      }
    }
  }
  void open_head(heads::ModelSignature facts) {
    const heads::Family& family = named_ ? *named_ : heads::recognise(facts, tasks_);
    if (!named_) check_custom(family, settings_);
    head_ = heads::open_head(family, facts,
                             {.threshold = settings_.threshold.value_or(family.threshold),
                              .custom = settings_.custom,
                              .labels = class_labels()});
    features_ = head_->features();
    facts_ = std::move(facts);
  }
  // The labels of the model count where the user gives none.
  const std::vector<std::string>& class_labels() const noexcept {
    return settings_.labels.empty() ? model_.labels() : settings_.labels;
  }

  // Reads one picture's outputs into part_, in pixels of the source picture.
  void read(std::span<const weir_tensor> tensors, const std::optional<SourceMap>& map) {
    follow_shapes(tensors);
    const auto described = model_.with_quantisation(tensors);
    values_.begin(described);
    Size input = facts_.input;
    if (map) input = {map->width, map->height};
    const auto kept =
        results::select(head_->find(values_, input), {.rivals = to_rivals(head_->suppression()),
                                                      .max_overlap = settings_.iou,
                                                      .max_objects = settings_.max_results,
                                                      .classes = classes_});
    const bool is_rotated = head_->suppression() == heads::Suppression::Rotated;
    part_.clear();
    for (const auto& candidate : kept)
      part_.objects.push_back(results::make_object(candidate, is_rotated));
    part_.points_per_object = features_.points_per_object;
    head_->complete(values_, kept, input, &part_);
    if (auto warning = head_->next_warning(); warning && !std::exchange(has_warned_, true))
      warning_ = std::move(warning);
    if (!map) return;
    if (features_.has_boxes) results::move_to_picture(*map, head_->has_rotation(), &part_);
  }

  // Opens the head again when the shapes of a flexible stream change.
  void follow_shapes(std::span<const weir_tensor> tensors) {
    if (has_shapes(facts_, tensors)) return;
    const Features before = features_;
    open_head(model_.facts(tensors, settings_.input, settings_.labels.size()));
    if (features_ == before) return;
    throw Failure({.code = Code::SPEC_MISMATCH,
                   .what = "the kind of results changed within the stream",
                   .offered = results::make_columns(features_),
                   .needed = results::make_columns(before),
                   .fix = "one tensor_decoder for each model"});
  }

  const uint32_t tasks_;
  ResultsSettings settings_;
  const heads::Family* named_ = nullptr;  // null: recognised
  StreamModel model_;
  heads::ModelSignature facts_;  // that head_ was opened for
  std::unique_ptr<heads::Head> head_;
  Features features_;
  std::vector<int32_t> classes_;
  std::vector<const char*> label_texts_;
  std::optional<Error> warning_;  // of the last frame
  bool has_warned_ = false;
  heads::OutputValues values_;
  FrameResults part_, results_;    // kept for their memory
  std::vector<Box> tiles_;         // likewise
  std::vector<uint32_t> tile_of_;  // likewise: of each object
  Size picture_;                   // that the tiles are parts of; 0 x 0 = not known
};

template <uint32_t kTasks>
class ModeDecoder final : public ResultsDecoder {
 public:
  explicit ModeDecoder(const Options& options) : ResultsDecoder(options, kTasks) {}
};

template <uint32_t kTasks>
const weir_decoder_type* get_table(const char* mode) {
  static const std::string options = results_options_json(kTasks);
  static const weir_decoder_type table =
      decoder_table<ModeDecoder<kTasks>>(mode, "", options.c_str());
  return &table;
}

}  // namespace

std::span<const weir_decoder_type* const> results_decoders() {
  static const weir_decoder_type* const tables[] = {
      get_table<heads::kDetection>("detection"),
      get_table<heads::kClassification>("classification"),
      get_table<heads::kSegmentation>("segmentation"),
      get_table<heads::kPose>("pose"),
      get_table<heads::kDepth>("depth"),
      get_table<heads::kText>("text")};
  return tables;
}

}  // namespace weir::decoders
