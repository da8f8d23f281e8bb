// SPDX-License-Identifier: LGPL-2.1-or-later
#include "evaluate/found_results.hpp"

#include <algorithm>

#include "core/evaluate/classification.hpp"
#include "core/text/text.hpp"
#include "weir/join.hpp"

namespace weir::app {
namespace {

const Json& get_list(const Json& frame, const char* name) {
  static const Json kNone = Json::array();
  return frame.contains(name) ? frame[name] : kNone;
}

std::vector<evaluate::LabelledPoint> parse_points(const Json& object) {
  std::vector<evaluate::LabelledPoint> out;
  for (const Json& point : get_list(object, "keypoints"))
    out.push_back(point.is_array() ? evaluate::LabelledPoint{point[0], point[1], true}
                                   : evaluate::LabelledPoint{});
  return out;
}

std::string format_some(const std::vector<std::string>& names) {
  constexpr size_t kShown = 8;
  const std::vector<std::string> shown(
      names.begin(), names.begin() + static_cast<ptrdiff_t>(std::min(names.size(), kShown)));
  return join(shown, ", ") + (names.size() > kShown ? ", ..." : "");
}

}  // namespace

std::string plain_name(const std::string& name) {
  std::string out = lower(strip(name));
  std::replace(out.begin(), out.end(), '_', ' ');
  return out;
}

LabelMatcher::LabelMatcher(std::vector<std::string> categories, std::string truth,
                           const std::vector<std::string>& model_labels)
    : categories_(std::move(categories)), truth_(std::move(truth)) {
  for (size_t i = 0; i < categories_.size(); ++i) by_name_.emplace(plain_name(categories_[i]), i);
  has_model_category_ =
      std::any_of(model_labels.begin(), model_labels.end(),
                  [&](const std::string& label) { return by_name_.contains(plain_name(label)); });
}

std::optional<size_t> LabelMatcher::find_category(const Json& object) {
  const std::string label = object.value("label", "");
  const auto named = by_name_.find(plain_name(label));
  if (named != by_name_.end()) {
    is_any_known_ = true;
    return named->second;
  }
  // A detector of one class may have neither.
  const size_t index = object.value("index", size_t{0});
  const bool has_name = !label.empty() && label != std::to_string(index);
  if (!has_name && index < categories_.size()) {
    is_any_known_ = true;
    if (!unnamed_) unnamed_ = {"class " + std::to_string(index), index};
    return index;
  }
  ++unknown_[has_name ? label : "class " + std::to_string(index)];
  return std::nullopt;
}

std::vector<std::string> LabelMatcher::list_unknown() const {
  std::vector<std::string> names;
  for (const auto& [name, count] : unknown_) names.push_back(name);
  return names;
}

Status LabelMatcher::check() const {
  if (unknown_.empty() || is_any_known_ || has_model_category_) return ok();
  return Error{.code = Code::LABELS_INVALID,
               .what = "none of the labels in the results is a category of the truth",
               .offered = format_some(list_unknown()),
               .needed = truth_ + ": " + format_some(categories_),
               .fix = "--labels FILE, with the truth's names for the classes of the model"};
}

std::optional<Error> LabelMatcher::warning_about_names() const {
  if (!unnamed_) return std::nullopt;
  return Error{
      .code = Code::LABELS_INVALID,
      .what =
          "the classes in the results have no names and are assigned to the categories in order",
      .offered = unnamed_->first,
      .needed = "names; this class is assigned to " + categories_[unnamed_->second],
      .fix = "--labels FILE, with the name of one class on each line"};
}

std::optional<Error> LabelMatcher::warning_about_pixels() const {
  if (unknown_.empty() || is_any_known_) return std::nullopt;
  return Error{.code = Code::LABELS_INVALID,
               .what = "no result is a class of the folder, although the model has such classes",
               .offered = format_some(list_unknown()),
               .needed = truth_ + ": " + format_some(categories_),
               .fix = "the card's color, mean and scale, if they are not those of the training"};
}

std::optional<Error> LabelMatcher::warning_about_labels() const {
  if (unknown_.empty()) return std::nullopt;
  std::vector<std::string> names;
  for (const auto& [name, count] : unknown_)
    names.push_back(name + " (" + std::to_string(count) + ")");
  return Error{.code = Code::LABELS_INVALID,
               .what = "results with labels that are not in the truth are ignored",
               .offered = format_some(names),
               .needed = truth_ + ": " + format_some(categories_),
               .fix = "--labels FILE, if the truth has these classes under other names"};
}

std::optional<evaluate::Rectangle> parse_box(const Json& object) {
  if (!object.contains("box") || object["box"].size() != 4) return std::nullopt;
  const auto& box = object["box"];
  const double left = box[0], top = box[1], right = box[2], bottom = box[3];
  return evaluate::Rectangle{left, top, std::max(0.0, right - left), std::max(0.0, bottom - top)};
}

std::vector<evaluate::FoundObject> found_objects(const Json& frame, LabelMatcher* labels) {
  std::vector<evaluate::FoundObject> out;
  for (const Json& object : get_list(frame, "detections")) {
    const auto box = parse_box(object);
    if (!box) continue;
    const auto category = labels->find_category(object);
    if (category)
      out.push_back({*category, *box, object.value("score", 1.0), parse_points(object)});
  }
  return out;
}

std::vector<evaluate::TrackedBox> found_tracks(const Json& frame,
                                               const std::vector<std::string>& labels) {
  const auto is_wanted = [&](const Json& object) {
    return labels.empty() || std::any_of(labels.begin(), labels.end(), [&](const auto& label) {
             return plain_name(label) == plain_name(object.value("label", ""));
           });
  };
  std::vector<evaluate::TrackedBox> out;
  for (const Json& object : get_list(frame, "detections")) {
    const auto box = parse_box(object);
    const auto track = object.value("track", int64_t{0});
    if (box && track > 0 && is_wanted(object)) out.push_back({track, *box});
  }
  return out;
}

std::vector<FoundClass> found_classes(const Json& frame, LabelMatcher* labels) {
  std::vector<FoundClass> out;
  for (const Json& object : get_list(frame, "labels"))
    out.push_back({labels->find_category(object).value_or(evaluate::kNoClass),
                   object.value("label", ""), object.value("score", 1.0)});
  std::stable_sort(out.begin(), out.end(),
                   [](const auto& a, const auto& b) { return a.score > b.score; });
  return out;
}

}  // namespace weir::app
