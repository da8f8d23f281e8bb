// Boxes and key points: average precision.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/evaluate/average_precision.hpp"
#include "core/evaluate/similarity.hpp"
#include "evaluate/evaluator.hpp"
#include "evaluate/found_results.hpp"

namespace weir::app {
namespace {

using evaluate::FoundObject;
using evaluate::PictureObjects;
using evaluate::TruthObject;

constexpr double kShownScore = 0.3;  // least score of boxes on the page
constexpr double kShownOverlap = 0.5;

std::string percent(double score) {
  return std::to_string(std::lround(score * 100)) + " %";
}

class ObjectEvaluator final : public Evaluator {
 public:
  ObjectEvaluator(const LabelledFolder& folder, const EvaluateOptions& options,
                  const std::vector<std::string>& model_labels)
      : folder_(folder),
        metric_(options.metric),
        labels_(folder.categories, folder.truth, model_labels) {}

  Status add(size_t, const LabelledPicture& picture, const Json& frame) override {
    pictures_.push_back({picture.objects, found_objects(frame, &labels_)});
    paths_.push_back(&picture.path);
    has_boxes_ |= frame.contains("detections");
    for (const FoundObject& object : pictures_.back().found)
      max_points_ = std::max(max_points_, object.points.size());
    return ok();
  }

  Result<Evaluation> finish() override {
    if (!has_boxes_)
      return Error{.code = Code::SPEC_MISMATCH,
                   .what = "the results have no boxes",
                   .offered = "results without the list \"detections\"",
                   .needed = "boxes, because the truth has boxes: " + folder_.truth,
                   .fix = "a detector, or --mode detection"};
    if (auto status = labels_.check(); !status) return status.error();
    if (metric_.empty()) metric_ = folder_.key_points > 0 && max_points_ > 0 ? "oks" : "ap";
    evaluate::PrecisionSettings settings;
    if (metric_ == "oks") {
      if (max_points_ != folder_.key_points) return wrong_points();
      settings.deviations = evaluate::key_point_deviations(folder_.key_points);
      ignore_without_points();
    }
    const size_t categories = folder_.categories.size();
    const auto precision =
        std::make_shared<evaluate::AveragePrecision>(pictures_, categories, settings);
    Evaluation out{.metric = metric_,
                   .scores = precision->scores(),
                   .headline = 3,
                   .part_name = "category",
                   .part_score = "AP",
                   .units = pictures_.size(),
                   .unit_name = "pictures"};
    for (size_t c = 0; c < categories; ++c) {
      out.parts.push_back({folder_.categories[c], precision->of_category(c)});
      out.curves.push_back(precision->curve_of_category(c));
    }
    out.measure = [precision](evaluate::Times times) {
      std::vector<double> values;
      for (const auto& score : precision->headline(times)) values.push_back(score.value);
      return values;
    };
    for (size_t p = 0; p < pictures_.size(); ++p) show(p);
    out.worst = worst_.take();
    return out;
  }

  std::vector<Error> warnings() const override {
    std::vector<Error> out;
    if (auto warning = labels_.warning_about_names()) out.push_back(*std::move(warning));
    if (auto warning = labels_.warning_about_labels()) out.push_back(*std::move(warning));
    constexpr size_t kPerson = 17;
    if (metric_ == "oks" && folder_.key_points != kPerson)
      out.push_back(
          {.code = Code::LABELS_INVALID,
           .what = "COCO defines no deviations for this number of key points: all get the same one",
           .offered = std::to_string(folder_.key_points) + " key points",
           .needed = "the 17 key points that COCO defines for persons"});
    return out;
  }

 private:
  Error wrong_points() const {
    return {.code = Code::SPEC_MISMATCH,
            .what = "the results do not have the key points of the truth",
            .offered = std::to_string(max_points_) + " key points of an object",
            .needed = folder_.truth + ": " + std::to_string(folder_.key_points),
            .fix = "--metric ap compares the boxes"};
  }

  // COCO compares only objects with key points.
  void ignore_without_points() {
    for (PictureObjects& picture : pictures_)
      for (TruthObject& object : picture.truth)
        object.is_ignored |= std::none_of(object.points.begin(), object.points.end(),
                                          [](const auto& point) { return point.is_labelled; });
  }

  double similarity(const TruthObject& truth, const FoundObject& found) const {
    if (truth.category != found.category) return 0;
    if (metric_ == "oks")
      return evaluate::key_point_similarity(truth, found,
                                            evaluate::key_point_deviations(folder_.key_points));
    return truth.is_crowd ? evaluate::part_in_crowd(found.box, truth.box)
                          : evaluate::overlap(truth.box, found.box);
  }

  // The object of the truth that fits best among those that nothing else fits; a crowd fits many.
  std::optional<size_t> best_truth(const PictureObjects& picture, const FoundObject& object,
                                   const std::vector<bool>& is_found) const {
    std::optional<size_t> best;
    double best_similarity = kShownOverlap;
    for (size_t t = 0; t < picture.truth.size(); ++t) {
      if (is_found[t] && !picture.truth[t].is_crowd) continue;
      const double value = similarity(picture.truth[t], object);
      if (value < best_similarity) continue;
      best_similarity = value;
      best = t;
    }
    return best;
  }

  // Boxes with a good score, and whether they fit an object; one each.
  void show(size_t index) {
    const PictureObjects& picture = pictures_[index];
    std::vector<const FoundObject*> found;
    for (const FoundObject& object : picture.found)
      if (object.score >= kShownScore) found.push_back(&object);
    std::stable_sort(found.begin(), found.end(),
                     [](const auto* a, const auto* b) { return a->score > b->score; });
    std::vector<bool> is_found(picture.truth.size(), false);
    Example example{.path = *paths_[index]};
    size_t false_found = 0, missed = 0;
    std::vector<PictureMark> shapes;
    for (const FoundObject* object : found) {
      const auto best = best_truth(picture, *object, is_found);
      const bool is_right = best.has_value();
      if (best) is_found[*best] = true;
      false_found += !is_right;
      shapes.push_back({is_right ? PictureMark::Kind::Right : PictureMark::Kind::False, object->box,
                        object->points,
                        folder_.categories[object->category] + " " + percent(object->score)});
    }
    for (size_t t = 0; t < picture.truth.size(); ++t) {
      const TruthObject& object = picture.truth[t];
      const bool is_missed = !is_found[t] && !object.is_ignored;
      missed += is_missed;
      example.shapes.push_back({is_missed ? PictureMark::Kind::Missed : PictureMark::Kind::Truth,
                                object.box, object.points, folder_.categories[object.category]});
    }
    example.shapes.insert(example.shapes.end(), shapes.begin(), shapes.end());
    example.errors = static_cast<double>(missed + false_found);
    example.caption = std::to_string(missed) + " missed, " + std::to_string(false_found) + " false";
    worst_.add(std::move(example));
  }

  const LabelledFolder& folder_;
  std::string metric_;
  LabelMatcher labels_;
  std::vector<PictureObjects> pictures_;
  std::vector<const std::string*> paths_;
  size_t max_points_ = 0;
  bool has_boxes_ = false;
  WorstExamples worst_;
};

}  // namespace

std::unique_ptr<Evaluator> make_object_evaluator(const LabelledFolder& folder,
                                                 const EvaluateOptions& options,
                                                 const std::vector<std::string>& model_labels) {
  return std::make_unique<ObjectEvaluator>(folder, options, model_labels);
}

}  // namespace weir::app
