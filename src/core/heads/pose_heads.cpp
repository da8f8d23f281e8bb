// Reads the key points of MoveNet, which are parts of the input's height and width: y, x, score
// (published description of the models on TensorFlow Hub).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/pose_heads.hpp"

#include "core/heads/head_options.hpp"
#include "core/heads/output_shapes.hpp"
#include "core/heads/points_head.hpp"

namespace weir::heads {
namespace {

using detection::Candidates;
using detection::PictureSize;

constexpr size_t kPoints = 17, kPointValues = 3;
constexpr size_t kPersonValues = kPoints * kPointValues + 5;  // then a box and its score

// Fills `points` and returns their mean score.
float read_points(const float* values, PictureSize input, std::vector<results::KeyPoint>* points) {
  points->clear();
  float sum = 0;
  for (size_t i = 0; i < kPoints; ++i, values += kPointValues) {
    points->push_back(key_point(values[1] * static_cast<float>(input.width),
                                values[0] * static_cast<float>(input.height), values[2]));
    sum += points->back().score;
  }
  return sum / static_cast<float>(kPoints);
}

class Movenet final : public PointsHead {
 public:
  explicit Movenet(float threshold) : PointsHead(kPoints), threshold_(threshold) {}

  Candidates find(OutputValues& outputs, PictureSize input) override {
    need_input_size(input);
    begin();
    const float score = read_points(outputs.read(0).data(), input, &points_);
    if (score >= threshold_ && score > 0) add(points_, threshold_, score, 0);
    return take();
  }

 private:
  float threshold_;
  std::vector<results::KeyPoint> points_;
};

class Multipose final : public PointsHead {
 public:
  Multipose(size_t persons, float threshold)
      : PointsHead(kPoints), persons_(persons), threshold_(threshold) {}

  Candidates find(OutputValues& outputs, PictureSize input) override {
    need_input_size(input);
    begin();
    const auto width = static_cast<float>(input.width), height = static_cast<float>(input.height);
    for (size_t i = 0; i < persons_; ++i) {
      const float* person = outputs.read(0).data() + i * kPersonValues;
      const float* box = person + kPoints * kPointValues;  // y1, x1, y2, x2, score
      const float score = probability_of(box[4]);
      if (!(score >= threshold_) || score == 0) continue;
      read_points(person, input, &points_);
      add(points_, Box{box[1] * width, box[0] * height, box[3] * width, box[2] * height}, score);
    }
    return take();
  }

 private:
  size_t persons_;
  float threshold_;
  std::vector<results::KeyPoint> points_;
};

bool is_movenet(const ModelFacts& model) {
  return model.outputs.size() == 1 && matrix_rows(model.outputs[0], kPointValues) == kPoints;
}
size_t persons_of(const ModelFacts& model) {
  return model.outputs.size() == 1 ? matrix_rows(model.outputs[0], kPersonValues) : 0;
}

Fit fit_movenet(const ModelFacts& model) {
  return is_movenet(model) ? Fit::Possible : Fit::No;
}
Fit fit_multipose(const ModelFacts& model) {
  return persons_of(model) > 0 ? Fit::Possible : Fit::No;
}
std::unique_ptr<Head> open_movenet(const ModelFacts& model, const HeadOptions& options) {
  if (!is_movenet(model)) throw wrong_outputs(model, kMovenet);
  return std::make_unique<Movenet>(options.threshold);
}
std::unique_ptr<Head> open_multipose(const ModelFacts& model, const HeadOptions& options) {
  const size_t persons = persons_of(model);
  if (persons == 0) throw wrong_outputs(model, kMovenetMultipose);
  return std::make_unique<Multipose>(persons, options.threshold);
}

}  // namespace

const Family kMovenet{.name = "movenet",
                      .aliases = "movenet-lightning,movenet-thunder",
                      .tasks = kPose,
                      .outputs = "1 tensor 3:17",
                      .custom = "",
                      .threshold = 0.2f,
                      .fit = fit_movenet,
                      .open = open_movenet};

const Family kMovenetMultipose{.name = "movenet-multipose",
                               .aliases = "",
                               .tasks = kPose,
                               .outputs = "1 tensor 56:N, N persons",
                               .custom = "",
                               .threshold = 0.2f,
                               .fit = fit_multipose,
                               .open = open_multipose};

}  // namespace weir::heads
