// Finds the head of a model's outputs, reads each frame with it and writes the results.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/answer_decoder.hpp"

#include <algorithm>
#include <filesystem>

#include "core/decoders/answer_settings.hpp"
#include "core/decoders/model_facts.hpp"
#include "core/heads/families.hpp"
#include "core/results/answer_writer.hpp"
#include "core/results/append.hpp"
#include "core/results/select.hpp"
#include "core/results/to_picture.hpp"
#include "weir/decoder.hpp"
#include "weir/source_map.hpp"

namespace weir::decoders {
namespace {

using results::Answer;
using results::Features;

results::Rivals rivals_of(heads::Suppression suppression) {
  switch (suppression) {
    case heads::Suppression::None:
      return results::Rivals::None;
    case heads::Suppression::ByClass:
      return results::Rivals::SameClass;
    case heads::Suppression::AnyClass:
      return results::Rivals::AnyClass;
    case heads::Suppression::Rotated:
      return results::Rivals::SameClassRotated;
  }
  return results::Rivals::SameClass;
}

// A mode whose heads have one of the bits `tasks` (heads::Task).
class AnswerDecoder {
 public:
  AnswerDecoder(const Options& options, uint32_t tasks)
      : tasks_(tasks), settings_(read_answer_settings(options)) {
    if (!settings_.head.empty()) named_ = &heads::family_named(settings_.head, tasks_);
  }

  void set_model(const weir_stream_model* model) noexcept { model_.set(model); }
  void set_stream(const DecoderStream&) noexcept {}
  std::span<const char* const> labels() noexcept { return label_texts_; }
  size_t classes() noexcept { return head_ ? head_->classes() : 0; }

  void configure(std::span<const weir_tensor_info> inputs, DecoderOutput& output) {
    open_first(model_.facts(inputs, settings_.input, settings_.labels.size()));
    classes_ = settings_.class_indices(class_labels());
    label_texts_.clear();
    const bool has_classes = !features_.has_texts && !features_.has_depth;
    if (has_classes)
      for (const std::string& label : class_labels()) label_texts_.push_back(label.c_str());
    output.set_caps(
        results::caps_of(features_, settings_.name.empty() ? model_.name() : settings_.name));
  }

  bool decode(const weir_frame& frame, DecoderOutput& output) {
    FrameRegions regions(frame);
    answer_.clear();
    for (uint32_t i = 0; i < regions.count(); ++i) {
      read(regions.tensors(i), regions.map(i));
      if (regions.are_regions())
        for (auto& object : part_.objects) object.parent = regions.row(i);
      results::append(&part_, features_, &answer_);
    }
    results::write(answer_, features_, [&](size_t bytes) { return output.reserve(bytes); });
    return true;
  }

 private:
  // The outputs of one picture, or of a batch of them.
  void open_first(const heads::ModelFacts& facts) {
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
  void open_head(heads::ModelFacts facts) {
    const heads::Family& family = named_ ? *named_ : heads::recognise(facts, tasks_);
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
    detection::PictureSize input = facts_.input;
    if (map) input = {map->width, map->height};
    const auto kept =
        results::select(head_->find(values_, input), {.rivals = rivals_of(head_->suppression()),
                                                      .most_overlap = settings_.iou,
                                                      .most_objects = settings_.max_results,
                                                      .classes = classes_});
    const bool is_rotated = head_->suppression() == heads::Suppression::Rotated;
    part_.clear();
    for (const auto& candidate : kept)
      part_.objects.push_back(results::object_of(candidate, is_rotated));
    part_.points_per_object = features_.points_per_object;
    head_->complete(values_, kept, input, &part_);
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
                   .offered = results::columns_of(features_),
                   .needed = results::columns_of(before),
                   .fix = "one tensor_decoder for each model"});
  }

  const uint32_t tasks_;
  AnswerSettings settings_;
  const heads::Family* named_ = nullptr;  // null: recognised
  StreamModel model_;
  heads::ModelFacts facts_;  // that head_ was opened for
  std::unique_ptr<heads::Head> head_;
  Features features_;
  std::vector<int32_t> classes_;
  std::vector<const char*> label_texts_;
  heads::OutputValues values_;
  Answer part_, answer_;  // kept for their memory
};

template <uint32_t kTasks>
class ModeDecoder final : public AnswerDecoder {
 public:
  explicit ModeDecoder(const Options& options) : AnswerDecoder(options, kTasks) {}
};

template <uint32_t kTasks>
const weir_decoder_type* table_of(const char* mode) {
  static const std::string options = answer_options_json(kTasks);
  static const weir_decoder_type table =
      decoder_table<ModeDecoder<kTasks>>(mode, "", options.c_str());
  return &table;
}

}  // namespace

std::span<const weir_decoder_type* const> answer_decoders() {
  static const weir_decoder_type* const tables[] = {
      table_of<heads::kDetection>("detection"),
      table_of<heads::kClassification>("classification"),
      table_of<heads::kSegmentation>("segmentation"),
      table_of<heads::kPose>("pose"),
      table_of<heads::kDepth>("depth"),
      table_of<heads::kText>("text")};
  return tables;
}

}  // namespace weir::decoders
