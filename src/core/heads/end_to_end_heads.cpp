// Heads of detectors that give one row for each object and need no removal of duplicates: the DETR
// models, and YOLO models and others that end in their own suppression.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cmath>

#include "core/detection/best_class.hpp"
#include "core/detection/sigmoid.hpp"
#include "core/heads/coordinates.hpp"
#include "core/heads/families.hpp"
#include "core/heads/output_shapes.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::heads {
namespace {

using detection::Candidates;

constexpr size_t kMaxRows = 1000;  // that fit() takes for rows of objects

// The index of each number in a row. The numbers of the box are together.
struct Columns {
  size_t length = 0, box = 0, score = 0, class_index = 0;
  std::optional<size_t> picture{};  // number of the picture in a batch; below 0 ends the rows
};
constexpr Columns kYolov10Columns{.length = 6, .box = 0, .score = 4, .class_index = 5};
constexpr Columns kYolov7Columns{.length = 7, .box = 1, .score = 6, .class_index = 5, .picture = 0};
constexpr Columns kOutputColumns{.length = 7, .box = 3, .score = 2, .class_index = 1, .picture = 0};

class EndToEnd final : public Head {
 public:
  EndToEnd(const Columns& columns, Size input, Unit unit, float threshold)
      : columns_(columns), input_(input), boxes_(unit, threshold) {}

  results::Features features() const override { return {}; }

  Candidates find(OutputValues& outputs, Size input) override {
    const auto numbers = outputs.read(0);
    boxes_.begin();
    for (size_t i = 0; i < numbers.size() / columns_.length; ++i) {
      const auto row = numbers.subspan(i * columns_.length, columns_.length);
      if (columns_.picture && row[*columns_.picture] < 0) break;
      boxes_.add(row.subspan(columns_.box).first<4>(), row[columns_.score],
                 row[columns_.class_index], i);
    }
    auto found = boxes_.take(input.width > 0 ? input : input_);
    warn_once(boxes_.contradiction());
    return found;
  }

 private:
  const Columns& columns_;
  Size input_;
  CornerBoxes boxes_;
};

// One output of rows of this length; the rows of a batch of one picture.
bool has_rows(const ModelSignature& model, const Columns& columns) {
  if (model.outputs.size() != 1) return false;
  const Shape& shape = model.outputs[0].shape;
  const auto count = shape.count();
  return shape[0] == columns.length && shape.min_rank() <= 3 && count && *count > 0;
}
Match fit_rows(const ModelSignature& model, const Columns& columns) {
  if (!has_rows(model, columns)) return Match::No;
  return *model.outputs[0].shape.count() / columns.length <= kMaxRows ? Match::Possible : Match::No;
}
std::unique_ptr<Head> open_rows(const ModelSignature& model, const HeadOptions& options,
                                const Family& family, const Columns& columns) {
  if (!has_rows(model, columns)) throw wrong_outputs(model, family);
  return std::make_unique<EndToEnd>(columns, model.input, unit_setting(options), options.threshold);
}

using detection::Candidate;
using detection::Candidates;

constexpr size_t kMaxQueries = 1000, kDetrBox = 4, kCoco = 80, kCocoOfDetr = 92;

// Centre and size, in pixels of the input or from 0 to 1.
Candidate make_candidate(std::span<const float> box) {
  return {.x = box[0] - box[2] / 2, .y = box[1] - box[3] / 2, .width = box[2], .height = box[3]};
}

// Where the classes and the boxes of queries are: in two outputs, or both in rows of one.
struct Queries {
  size_t count = 0, classes = 0;
  size_t scores_output = 0, boxes_output = 0;
  size_t row_length = 0;  // of scores; of boxes too if they are in one output
  bool are_together() const noexcept { return scores_output == boxes_output; }
};

std::optional<Queries> find_queries(const ModelSignature& model) {
  if (model.outputs.size() != 2) return std::nullopt;
  // Four classes and boxes have the same shape: names decide, then the usual order.
  const bool is_swapped =
      has_name_with(model.outputs[0], "box") && !has_name_with(model.outputs[1], "box");
  for (const size_t attempt : {0u, 1u}) {
    const size_t boxes = is_swapped ? attempt : 1 - attempt;
    const Shape &box = model.outputs[boxes].shape, &score = model.outputs[1 - boxes].shape;
    if (box.min_rank() > 2 || score.min_rank() > 2) continue;
    if (box[0] != kDetrBox || box[1] != score[1] || box[1] == 0 || box[1] > kMaxQueries) continue;
    return Queries{.count = box[1],
                   .classes = score[0],
                   .scores_output = 1 - boxes,
                   .boxes_output = boxes,
                   .row_length = score[0]};
  }
  return std::nullopt;
}

// Rows of boxes and scores, as Ultralytics exports RT-DETR.
std::optional<Queries> find_joined_queries(const ModelSignature& model) {
  if (model.outputs.size() != 1 || model.outputs[0].shape.min_rank() != 2) return std::nullopt;
  const Shape& shape = model.outputs[0].shape;
  if (shape[0] <= kDetrBox || shape[1] > kMaxQueries) return std::nullopt;
  return Queries{.count = shape[1], .classes = shape[0] - kDetrBox, .row_length = shape[0]};
}

class QueryHead : public Head {
 public:
  QueryHead(const Queries& queries, Size input, Unit unit, float threshold)
      : queries_(queries), input_(input), numbers_(unit), threshold_(threshold) {}

  results::Features features() const override { return {}; }

  Candidates find(OutputValues& outputs, Size frame_input) override {
    const auto scores = outputs.read(queries_.scores_output);
    const auto boxes = outputs.read(queries_.boxes_output);
    check(scores, queries_.row_length);
    const size_t box_length = queries_.are_together() ? queries_.row_length : kDetrBox;
    check(boxes, box_length);
    begin(scores);
    numbers_.begin();
    Candidates found;
    for (size_t i = 0; i < queries_.count; ++i) {
      const size_t first = queries_.are_together() ? kDetrBox : 0;
      const auto row = scores.subspan(i * queries_.row_length + first, queries_.classes);
      const auto box = boxes.subspan(i * box_length, kDetrBox);
      Candidate candidate = make_candidate(box);
      if (!choose(row, &candidate) || !candidate.is_finite()) continue;
      candidate.row = static_cast<uint32_t>(i);
      numbers_.add(box);
      found.push_back(candidate);
    }
    const Unit unit = numbers_.unit();
    warn_once(numbers_.contradiction());
    if (unit == Unit::Picture && !found.empty())
      enlarge(frame_input.width > 0 ? frame_input : input_, &found);
    return found;
  }

 protected:
  virtual void begin(std::span<const float> scores) { (void)scores; }
  // Sets score and class; returns whether the score reaches the threshold.
  virtual bool choose(std::span<const float> row, Candidate* candidate) const = 0;
  bool reaches(float score) const noexcept { return heads::reaches(score, threshold_); }

 private:
  void check(std::span<const float> numbers, size_t length) const {
    if (numbers.size() == queries_.count * length) return;
    throw Failure(
        {.code = Code::SPEC_MISMATCH,
         .what = "the frame has a different number of queries than the head was opened for",
         .offered = std::to_string(numbers.size()) + " numbers",
         .needed = std::to_string(queries_.count * length)});
  }

  static void enlarge(Size input, Candidates* found) {
    require_size(input);
    const auto width = static_cast<float>(input.width), height = static_cast<float>(input.height);
    for (Candidate& candidate : *found) {
      candidate.x *= width, candidate.width *= width;
      candidate.y *= height, candidate.height *= height;
    }
    std::erase_if(*found, [](const Candidate& candidate) { return !candidate.is_finite(); });
  }

  Queries queries_;
  Size input_;
  UnitOfNumbers numbers_;
  float threshold_;
};

// The last class is "no object"; scores are the softmax of all.
class Detr final : public QueryHead {
 public:
  using QueryHead::QueryHead;

 private:
  bool choose(std::span<const float> row, Candidate* candidate) const override {
    const auto classes = row.first(row.size() - 1);
    const float best = detection::best_score(classes);
    const float max = std::max(best, row.back());
    double sum = 0;
    for (const float logit : row) sum += std::exp(static_cast<double>(logit) - max);
    candidate->score = static_cast<float>(std::exp(static_cast<double>(best) - max) / sum);
    candidate->class_index = detection::class_with(classes, best);
    return reaches(candidate->score);
  }
};

class RtDetr final : public QueryHead {
 public:
  RtDetr(const Queries& queries, Size input, Unit unit, float threshold, ScoreKind kind)
      : QueryHead(queries, input, unit, threshold),
        first_(queries.are_together() ? kDetrBox : 0),
        length_(queries.row_length),
        kind_(kind) {}

 private:
  // Boxes may be beyond 0 and 1, so only the scores are looked at.
  void begin(std::span<const float> scores) override {
    if (kind_ != ScoreKind::Automatic) return;
    for (size_t at = 0; at + length_ <= scores.size() && kind_ == ScoreKind::Automatic;
         at += length_)
      if (are_logits(scores.subspan(at + first_, length_ - first_))) kind_ = ScoreKind::Logits;
  }
  bool choose(std::span<const float> row, Candidate* candidate) const override {
    const float best = detection::best_score(row);
    candidate->score = kind_ == ScoreKind::Logits ? detection::sigmoid(best) : best;
    candidate->class_index = detection::class_with(row, best);
    return reaches(candidate->score);
  }

  size_t first_, length_;
  ScoreKind kind_;  // logits, once one was seen
};

Match fit_detr(const ModelSignature& model) {
  const auto queries = find_queries(model);
  if (!queries || queries->classes < 2) return Match::No;
  if (model.labels > 0 && model.labels == queries->classes) return Match::Possible;
  const bool is_usual =
      model.labels > 0 ? model.labels + 1 == queries->classes : queries->classes == kCocoOfDetr;
  return is_usual ? Match::Certain : Match::Possible;
}

Match fit_rt_detr(const ModelSignature& model) {
  if (const auto queries = find_queries(model)) {
    const bool is_usual =
        model.labels > 0 ? model.labels == queries->classes : queries->classes == kCoco;
    return is_usual ? Match::Certain : Match::Possible;
  }
  constexpr size_t kUsualQueries = 300;
  const auto joined = find_joined_queries(model);
  // Rows of 6 numbers are more likely x1, y1, x2, y2, score, class.
  const bool is_likely = joined && (joined->classes > 2 || model.labels == joined->classes);
  return is_likely && joined->count == kUsualQueries ? Match::Possible : Match::No;
}

std::unique_ptr<Head> open_detr(const ModelSignature& model, const HeadOptions& options) {
  const auto queries = find_queries(model);
  if (!queries || queries->classes < 2) throw wrong_outputs(model, kDetr);
  return std::make_unique<Detr>(*queries, model.input, unit_setting(options), options.threshold);
}

std::unique_ptr<Head> open_rt_detr(const ModelSignature& model, const HeadOptions& options) {
  auto queries = find_queries(model);
  if (!queries) queries = find_joined_queries(model);
  if (!queries) throw wrong_outputs(model, kRtDetr);
  return std::make_unique<RtDetr>(*queries, model.input, unit_setting(options), options.threshold,
                                  score_kind(options));
}

// Three outputs: labels N, boxes 4:N of x1, y1, x2, y2, scores N. Or two: labels N, boxes 5:N with
// the score last.
struct Roles {
  size_t labels = 0, boxes = 0, scores = 0;
  bool are_together() const noexcept { return scores == boxes; }
  size_t row_length() const noexcept { return are_together() ? kDetrBox + 1 : kDetrBox; }
};

// Whether the output `list` has a number for each row of `boxes`.
bool is_list_of(const OutputSignature& boxes, const OutputSignature& list) {
  return list.shape.min_rank() == 1 && list.shape[0] == std::max(boxes.shape[1], 1u);
}
bool are_boxes(const OutputSignature& boxes, size_t length) {
  return boxes.shape[0] == length && boxes.shape.min_rank() <= 2;
}

// Whether the names make `labels` the labels and `scores` the scores.
bool are_named(const OutputSignature& labels, const OutputSignature& scores) {
  return has_name_with(scores, "score") || has_name_with(labels, "label") ||
         has_name_with(labels, "class");
}

// Labels are integers where scores are not; else the names decide.
std::optional<Roles> roles_around(const ModelSignature& model, size_t boxes) {
  const size_t first = boxes == 0 ? 1 : 0, second = boxes == 2 ? 1 : 2;
  const auto &a = model.outputs[first], &b = model.outputs[second];
  const auto& box = model.outputs[boxes];
  if (!are_boxes(box, kDetrBox) || !is_list_of(box, a) || !is_list_of(box, b)) return std::nullopt;
  if (is_integer(a.type) != is_integer(b.type))
    return is_integer(a.type) ? Roles{first, boxes, second} : Roles{second, boxes, first};
  if (are_named(b, a)) return Roles{second, boxes, first};
  if (are_named(a, b)) return Roles{first, boxes, second};
  return std::nullopt;
}

// As MMDetection exports its detectors.
std::optional<Roles> find_roles_of_two(const ModelSignature& model) {
  for (const size_t boxes : {0u, 1u}) {
    const auto &box = model.outputs[boxes], &list = model.outputs[1 - boxes];
    const bool are_labels =
        is_integer(list.type) || has_name_with(list, "label") || has_name_with(list, "class");
    if (are_boxes(box, kDetrBox + 1) && is_list_of(box, list) && are_labels)
      return Roles{1 - boxes, boxes, boxes};
  }
  return std::nullopt;
}

std::optional<Roles> find_roles(const ModelSignature& model) {
  if (model.outputs.size() == 2) return find_roles_of_two(model);
  if (model.outputs.size() != 3) return std::nullopt;
  for (size_t boxes = 0; boxes < 3; ++boxes)
    if (const auto roles = roles_around(model, boxes)) return roles;
  return std::nullopt;
}

class LabelsBoxesScores final : public Head {
 public:
  LabelsBoxesScores(const Roles& roles, Size input, Unit unit, int64_t first_class, float threshold)
      : roles_(roles),
        input_(input),
        first_class_(static_cast<float>(first_class)),
        boxes_(unit, threshold) {}

  results::Features features() const override { return {}; }

  Candidates find(OutputValues& outputs, Size input) override {
    const auto labels = outputs.read_raw(roles_.labels);
    const auto boxes = outputs.read(roles_.boxes), scores = outputs.read(roles_.scores);
    const size_t length = roles_.row_length();
    size_t count = std::min(labels.size(), boxes.size() / length);
    if (!roles_.are_together()) count = std::min(count, scores.size());
    boxes_.begin();
    for (size_t i = 0; i < count; ++i) {
      const auto box = boxes.subspan(i * length, length);
      boxes_.add(box.first<kDetrBox>(), roles_.are_together() ? box.back() : scores[i],
                 labels[i] - first_class_, i);
    }
    auto found = boxes_.take(input.width > 0 ? input : input_);
    warn_once(boxes_.contradiction());
    return found;
  }

 private:
  Roles roles_;
  Size input_;
  float first_class_;
  CornerBoxes boxes_;
};

Match fit_labels_boxes_scores(const ModelSignature& model) {
  return find_roles(model) ? Match::Possible : Match::No;
}

std::unique_ptr<Head> open_labels_boxes_scores(const ModelSignature& model,
                                               const HeadOptions& options) {
  const auto roles = find_roles(model);
  if (!roles) throw wrong_outputs(model, kLabelsBoxesScores);
  const auto first = number_setting(options, "first-class", -1000, 1000).value_or(0);
  return std::make_unique<LabelsBoxesScores>(*roles, model.input, unit_setting(options), first,
                                             options.threshold);
}

}  // namespace

const Family kYolov10{
    .name = "yolov10",
    .aliases = "yolo26,end-to-end",
    .tasks = kDetection,
    .outputs = "1 tensor 6:N of x1, y1, x2, y2, score, class",
    .custom = "unit",
    .threshold = 0.25f,
    .fit = [](const ModelSignature& model) { return fit_rows(model, kYolov10Columns); },
    .open =
        [](const ModelSignature& model, const HeadOptions& options) {
          return open_rows(model, options, kYolov10, kYolov10Columns);
        }};

const Family kYolov7EndToEnd{
    .name = "yolov7-end2end",
    .aliases = "",
    .tasks = kDetection,
    .outputs = "1 tensor 7:N of picture, x1, y1, x2, y2, class, score",
    .custom = "unit",
    .threshold = 0.25f,
    .fit = [](const ModelSignature& model) { return fit_rows(model, kYolov7Columns); },
    .open =
        [](const ModelSignature& model, const HeadOptions& options) {
          return open_rows(model, options, kYolov7EndToEnd, kYolov7Columns);
        }};

const Family kDetectionOutput{
    .name = "detection-output",
    .aliases = "openvino,caffe-ssd",
    .tasks = kDetection,
    .outputs = "1 tensor 7:N of picture, class, score, x1, y1, x2, y2",
    .custom = "unit",
    .threshold = 0.5f,
    .fit = [](const ModelSignature& model) { return fit_rows(model, kOutputColumns); },
    .open =
        [](const ModelSignature& model, const HeadOptions& options) {
          return open_rows(model, options, kDetectionOutput, kOutputColumns);
        }};

const Family kDetr{.name = "detr",
                   .aliases = "",
                   .tasks = kDetection,
                   .outputs = "logits CLASSES+1:N, the last for no object, and boxes 4:N",
                   .custom = "unit",
                   .threshold = 0.5f,
                   .fit = fit_detr,
                   .open = open_detr};

const Family kRtDetr{.name = "rtdetr",
                     .aliases = "rt-detr,deformable-detr",
                     .tasks = kDetection,
                     .outputs = "scores CLASSES:N and boxes 4:N, or 1 tensor 4+CLASSES:300",
                     .custom = "scores,unit",
                     .threshold = 0.5f,
                     .fit = fit_rt_detr,
                     .open = open_rt_detr};

const Family kLabelsBoxesScores{
    .name = "labels-boxes-scores",
    .aliases = "rtdetr-deployed,torchvision,mmdetection",
    .tasks = kDetection,
    .outputs = "labels N (integers), boxes 4:N, scores N in any order; or labels N, boxes 5:N",
    .custom = "unit,first-class",
    .threshold = 0.5f,
    .fit = fit_labels_boxes_scores,
    .open = open_labels_boxes_scores};

}  // namespace weir::heads
