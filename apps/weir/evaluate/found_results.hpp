// Results of a pipeline (docs/results.md, JSON) as objects of the truth's categories.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/evaluate/objects.hpp"
#include "core/evaluate/tracking.hpp"
#include "report.hpp"
#include "weir/result.hpp"

namespace weir::app {

// Finds the category of a label: by name, where case and the difference between blanks and
// underscores do not count. A class without a name is the category of its number.
class LabelMatcher {
 public:
  // `truth`: the path that names the categories, for messages. `model_labels`: the names of the
  // model's classes, if they are known.
  LabelMatcher(std::vector<std::string> categories, std::string truth,
               const std::vector<std::string>& model_labels);

  std::optional<size_t> find_category(const Json& object);

  // LABELS_INVALID when there were labels, and neither one of them nor one of the model is a
  // category.
  Status check() const;
  // What was assumed of classes without names, and which labels are no categories.
  std::optional<Error> warning_about_names() const;
  std::optional<Error> warning_about_labels() const;
  // That no result is a category though the model has some of them.
  std::optional<Error> warning_about_pixels() const;
  const std::vector<std::string>& categories() const noexcept { return categories_; }

 private:
  std::vector<std::string> list_unknown() const;

  std::vector<std::string> categories_;
  std::string truth_;
  std::map<std::string, size_t> by_name_;
  std::map<std::string, size_t> unknown_;                  // how often
  std::optional<std::pair<std::string, size_t>> unnamed_;  // the first class without a name
  bool is_any_known_ = false;                              // of the results
  bool has_model_category_ = false;  // the labels of the model have a category
};

std::optional<evaluate::Rectangle> parse_box(const Json& object);
// Detections of known categories.
std::vector<evaluate::FoundObject> found_objects(const Json& frame, LabelMatcher* labels);
// Detections with a track; if `labels` is not empty, only those of these labels.
std::vector<evaluate::TrackedBox> found_tracks(const Json& frame,
                                               const std::vector<std::string>& labels);

struct FoundClass {
  size_t category = 0;  // evaluate::kNoClass for a label that is no category
  std::string label;
  double score = 0;
};
std::vector<FoundClass> found_classes(const Json& frame, LabelMatcher* labels);

// Lower case, underscores as blanks.
std::string plain_name(const std::string& name);

}  // namespace weir::app
