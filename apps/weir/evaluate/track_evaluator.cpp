// Tracks of sequences: HOTA, MOTA, IDF1.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cmath>

#include "core/evaluate/mot_truth.hpp"
#include "core/evaluate/similarity.hpp"
#include "core/evaluate/tracking.hpp"
#include "core/text/shell_quote.hpp"
#include "evaluate/evaluator.hpp"
#include "evaluate/found_results.hpp"

namespace weir::app {
namespace {

class TrackEvaluator final : public Evaluator {
 public:
  TrackEvaluator(const LabelledFolder& folder, const EvaluateOptions& options)
      : folder_(folder), labels_(options.classes), frames_(folder.sequences.size()) {}

  Status add(size_t sequence, const LabelledPicture& picture, const Json& frame) override {
    frames_[sequence].push_back(
        evaluate::without_neutral(picture.tracks, found_tracks(frame, labels_)));
    if (frame.contains("detections"))
      for (const Json& object : frame["detections"]) {
        ++boxes_;
        tracks_ += object.contains("track");
        counted_label_ = counted_label_.empty() ? object.value("label", "") : counted_label_;
      }
    counted_ += frames_[sequence].back().found.size();
    return ok();
  }

  Result<Evaluation> finish() override {
    if (boxes_ > 0 && tracks_ == 0)
      return Error{
          .code = Code::SPEC_MISMATCH,
          .what = "the results have no tracks",
          .offered = std::to_string(boxes_) + " boxes without the number of a track",
          .needed = "results with the column track, because the truth is tracks: " + folder_.truth,
          .fix = "an element that follows objects, at the end of the pipeline"};
    if (!labels_.empty() && tracks_ > 0 && counted_ == 0)
      return Error{.code = Code::OPTION_VALUE,
                   .what = "no object has a label of --classes",
                   .offered = "objects with the label " + counted_label_,
                   .needed = "labels of the results",
                   .fix = "--classes " + shell_word(counted_label_)};
    Evaluation out{.metric = "tracking",
                   .headline = 3,
                   .part_name = "sequence",
                   .part_score = "HOTA",
                   .units = frames_.size(),
                   .unit_name = "sequences"};
    std::vector<evaluate::TrackingCounts> counts;
    evaluate::TrackingCounts sum;
    for (size_t s = 0; s < frames_.size(); ++s) {
      counts.push_back(evaluate::count_tracks(frames_[s]));
      sum.add(counts.back(), 1);
      out.parts.push_back(
          {folder_.sequences[s].name, evaluate::tracking_scores(counts.back())[0].value});
      show(s);
    }
    out.scores = evaluate::tracking_scores(sum);
    out.worst = worst_.take();
    if (frames_.size() == 1) cut_into_parts(&counts, &out);
    const auto scores = [counts = std::move(counts)](evaluate::Times times) {
      std::vector<double> values;
      for (const auto& score : evaluate::tracking_headline(counts, times))
        values.push_back(score.value);
      return values;
    };
    out.measure = [scores, shift = find_shift(out, scores({}))](evaluate::Times times) {
      auto values = scores(times);
      for (size_t i = 0; i < values.size(); ++i) values[i] += shift[i];
      return values;
    };
    return out;
  }

 private:
  // The spread of one sequence is that of its parts: a second or longer, 20 at most.
  void cut_into_parts(std::vector<evaluate::TrackingCounts>* counts, Evaluation* out) const {
    constexpr size_t kMaxParts = 20;
    const auto second = static_cast<size_t>(std::ceil(folder_.sequences[0].frame_rate));
    const auto parts = evaluate::split_sequence(frames_[0], second, kMaxParts);
    if (parts.size() < 2) return;
    counts->clear();
    for (const auto& part : parts) counts->push_back(evaluate::count_tracks(part));
    out->units = parts.size();
    out->unit_name = "parts of one sequence";
  }
  // What the scores of the whole are more than those of its parts, in which no track is longer than
  // its part.
  static std::vector<double> find_shift(const Evaluation& whole, const std::vector<double>& parts) {
    std::vector<double> out;
    for (size_t i = 0; i < parts.size(); ++i) out.push_back(whole.scores[i].value - parts[i]);
    return out;
  }

  // The frame with the most errors of each second, so that the page does not show one moment.
  void show(size_t sequence) {
    const auto errors = evaluate::errors_of_frames(frames_[sequence]);
    const auto second =
        std::max<size_t>(1, static_cast<size_t>(folder_.sequences[sequence].frame_rate));
    for (size_t begin = 0; begin < errors.size(); begin += second) {
      const auto first = errors.begin() + static_cast<ptrdiff_t>(begin);
      const auto end =
          errors.begin() + static_cast<ptrdiff_t>(std::min(begin + second, errors.size()));
      const auto frame = static_cast<size_t>(std::max_element(first, end) - errors.begin());
      if (worst_.would_keep(static_cast<double>(errors[frame])))
        show(sequence, frame, errors[frame]);
    }
  }

  void show(size_t sequence, size_t frame, size_t errors) {
    const LabelledSequence& labelled = folder_.sequences[sequence];
    Example example{.path = labelled.pictures[frame].path, .errors = static_cast<double>(errors)};
    example.caption = labelled.name + ", frame " + std::to_string(frame + 1) + ": " +
                      std::to_string(errors) + " errors";
    const auto& [truth, found] = frames_[sequence][frame];
    const auto fits = [](const auto& box, const auto& others) {
      return std::any_of(others.begin(), others.end(), [&](const auto& other) {
        return evaluate::overlap(box.box, other.box) >= 0.5;
      });
    };
    for (const auto& box : truth)
      example.shapes.push_back(
          {fits(box, found) ? PictureMark::Kind::Truth : PictureMark::Kind::Missed,
           box.box,
           {},
           "#" + std::to_string(box.track)});
    for (const auto& box : found)
      example.shapes.push_back(
          {fits(box, truth) ? PictureMark::Kind::Right : PictureMark::Kind::False,
           box.box,
           {},
           "#" + std::to_string(box.track)});
    worst_.add(std::move(example));
  }

  const LabelledFolder& folder_;
  const std::vector<std::string> labels_;
  std::vector<evaluate::Sequence> frames_;
  std::string counted_label_;
  size_t boxes_ = 0, tracks_ = 0, counted_ = 0;
  WorstExamples worst_;
};

}  // namespace

std::unique_ptr<Evaluator> make_track_evaluator(const LabelledFolder& folder,
                                                const EvaluateOptions& options) {
  return std::make_unique<TrackEvaluator>(folder, options);
}

}  // namespace weir::app
