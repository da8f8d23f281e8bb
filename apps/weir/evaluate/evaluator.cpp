// SPDX-License-Identifier: LGPL-2.1-or-later
#include "evaluate/evaluator.hpp"

#include <algorithm>
#include <array>

#include "weir/join.hpp"

namespace weir::app {
namespace {

constexpr size_t kMaxExamples = 12;

// The metrics that a folder has truth for, the default first.
std::vector<std::string> list_metrics(const LabelledFolder& folder) {
  switch (folder.kind) {
    case Labelled::Objects:
      return folder.key_points > 0 ? std::vector<std::string>{"ap", "oks"}
                                   : std::vector<std::string>{"ap"};
    case Labelled::Classes:
      return {"accuracy"};
    case Labelled::Maps:
      return {"iou"};
    case Labelled::Tracks:
      return {"tracking"};
  }
  return {};
}

}  // namespace

bool WorstExamples::would_keep(double errors) const {
  return errors > 0 && (examples_.size() < kMaxExamples || errors > examples_.back().errors);
}

void WorstExamples::add(Example example) {
  if (!would_keep(example.errors)) return;
  const auto place =
      std::upper_bound(examples_.begin(), examples_.end(), example.errors,
                       [](double errors, const Example& other) { return errors > other.errors; });
  examples_.insert(place, std::move(example));
  if (examples_.size() > kMaxExamples) examples_.pop_back();
}

Status Evaluator::accept(const LabelledPicture& picture, const DecodedPicture& decoded) {
  const auto size = [](uint32_t width, uint32_t height) {
    return std::to_string(width) + " x " + std::to_string(height) + " pixels";
  };
  if (picture.width == 0 || picture.height == 0 ||
      (picture.width == decoded.width && picture.height == decoded.height))
    return ok();
  return Error{.code = Code::LABELS_INVALID,
               .what = "the size of a picture differs from its size in the truth",
               .offered = picture.path + ": " + size(decoded.width, decoded.height),
               .needed = size(picture.width, picture.height),
               .fix = "use the original pictures, which were not scaled or rotated"};
}

Result<std::unique_ptr<Evaluator>> make_evaluator(const LabelledFolder& folder,
                                                  const EvaluateOptions& options,
                                                  const std::vector<std::string>& model_labels) {
  const auto metrics = list_metrics(folder);
  if (!options.metric.empty() &&
      std::find(metrics.begin(), metrics.end(), options.metric) == metrics.end())
    return Error{.code = Code::OPTION_VALUE,
                 .what = "the folder has no truth for this metric",
                 .offered = "--metric " + options.metric,
                 .needed = "one of: " + join(metrics, ", "),
                 .fix = "--metric " + metrics[0]};
  switch (folder.kind) {
    case Labelled::Objects:
      return make_object_evaluator(folder, options, model_labels);
    case Labelled::Classes:
      return make_class_evaluator(folder, model_labels);
    case Labelled::Maps:
      return make_map_evaluator(folder);
    case Labelled::Tracks:
      break;
  }
  return make_track_evaluator(folder, options);
}

}  // namespace weir::app
