// Classes of pictures: accuracy and confusion matrix.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cmath>
#include <span>

#include "core/evaluate/classification.hpp"
#include "evaluate/evaluator.hpp"
#include "evaluate/found_results.hpp"
#include "weir/join.hpp"

namespace weir::app {
namespace {

class ClassEvaluator final : public Evaluator {
 public:
  ClassEvaluator(const LabelledFolder& folder, const std::vector<std::string>& model_labels)
      : folder_(folder), labels_(folder.categories, folder.truth, model_labels) {}

  Status add(size_t, const LabelledPicture& picture, const Json& frame) override {
    has_labels_ |= frame.contains("labels");
    const auto found = found_classes(frame, &labels_);
    evaluate::ClassifiedPicture classified{picture.class_index, {}};
    for (const FoundClass& one : found) classified.ranked.push_back(one.category);
    if (found.empty() || found[0].category != picture.class_index) show(picture, found);
    pictures_.push_back(std::move(classified));
    return ok();
  }

  Result<Evaluation> finish() override {
    if (!has_labels_)
      return Error{
          .code = Code::SPEC_MISMATCH,
          .what = "the results contain no class for a picture",
          .offered = "results without the list \"labels\"",
          .needed = "a class for each picture, because the folder has a subfolder for each class",
          .fix = "a classifier, or --mode classification"};
    if (auto status = labels_.check(); !status) return status.error();
    const size_t classes = folder_.categories.size();
    Evaluation out{.metric = "accuracy",
                   .scores = evaluate::accuracy(pictures_, classes, {}),
                   .headline = 3,
                   .part_name = "class",
                   .part_score = "top-1",
                   .confusion = evaluate::confusion_matrix(pictures_, classes),
                   .worst = worst_.take(),
                   .units = pictures_.size(),
                   .unit_name = "pictures"};
    for (size_t c = 0; c < classes; ++c) {
      uint64_t all = 0;
      for (const uint64_t count : out.confusion[c]) all += count;
      out.parts.push_back(
          {folder_.categories[c],
           evaluate::ratio(static_cast<double>(out.confusion[c][c]), static_cast<double>(all))});
    }
    out.measure = [pictures = std::move(pictures_), classes](evaluate::Times times) {
      std::vector<double> values;
      for (const auto& score : evaluate::accuracy(pictures, classes, times))
        values.push_back(score.value);
      return values;
    };
    return out;
  }

  // Labels that are no class of the folder are wrong, but usual: networks know many classes.
  std::vector<Error> warnings() const override {
    std::vector<Error> out;
    for (auto& warning : {labels_.warning_about_names(), labels_.warning_about_pixels()})
      if (warning) out.push_back(*warning);
    return out;
  }

 private:
  // The surer of the wrong class, the worse.
  void show(const LabelledPicture& picture, const std::vector<FoundClass>& found) {
    Example example{.path = picture.path, .errors = found.empty() ? 1 : found[0].score};
    constexpr size_t kShown = 3;
    const auto shown = std::span(found).first(std::min(found.size(), kShown));
    const auto text = join(shown, ", ", [](const FoundClass& one) {
      return one.label + " " + std::to_string(std::lround(one.score * 100)) + " %";
    });
    example.caption =
        folder_.categories[picture.class_index] + ", found: " + (found.empty() ? "nothing" : text);
    worst_.add(std::move(example));
  }

  const LabelledFolder& folder_;
  LabelMatcher labels_;
  std::vector<evaluate::ClassifiedPicture> pictures_;
  bool has_labels_ = false;
  WorstExamples worst_;
};

}  // namespace

std::unique_ptr<Evaluator> make_class_evaluator(const LabelledFolder& folder,
                                                const std::vector<std::string>& model_labels) {
  return std::make_unique<ClassEvaluator>(folder, model_labels);
}

}  // namespace weir::app
