// Wraps ../stages.hpp in the API of parts.hpp.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "parts.hpp"

#include <cstdio>

#include "../stages.hpp"
#include "faces_text.hpp"
#include "stage_times.hpp"

namespace control {
namespace {

std::vector<weir::Box> to_boxes(const Numbers& numbers) {
  std::vector<weir::Box> out;
  for (size_t i = 0; i + 4 <= numbers.size(); i += 4)
    out.push_back({numbers[i], numbers[i + 1], numbers[i + 2], numbers[i + 3]});
  return out;
}

void put(const weir::Box& box, Numbers* out) {
  out->insert(out->end(), {box.x1, box.y1, box.x2, box.y2});
}

Numbers to_numbers(const std::vector<weir::Box>& boxes) {
  Numbers out;
  for (const auto& box : boxes) put(box, &out);
  return out;
}

Numbers to_numbers(const std::vector<mtcnn::Face>& faces) {
  Numbers out;
  for (const auto& face : faces) {
    put(face.box, &out);
    out.push_back(face.score);
    out.insert(out.end(), face.points.begin(), face.points.end());
  }
  return out;
}

struct P : Part {
  P(const std::string& models, uint32_t min_face) : stage(env, models, 1, min_face) {}
  Numbers find(const cv::Mat& picture, const Numbers&) override {
    return to_numbers(stage.find(picture));
  }
  Ort::Env env = silent_environment();
  Propose stage;
};

template <class Stage>
struct LaterStage : Part {
  explicit LaterStage(const std::string& models) : stage(env, models, 1) {}
  Numbers find(const cv::Mat& picture, const Numbers& regions) override {
    return to_numbers(stage.find(picture, to_boxes(regions)));
  }
  Ort::Env env = silent_environment();
  Stage stage;
};

}  // namespace

std::unique_ptr<Part> p_part(const std::string& models, uint32_t min_face) {
  return std::make_unique<P>(models, min_face);
}
std::unique_ptr<Part> r_part(const std::string& models) {
  return std::make_unique<LaterStage<Refine>>(models);
}
std::unique_ptr<Part> o_part(const std::string& models) {
  return std::make_unique<LaterStage<Mark>>(models);
}

std::string to_json(const Numbers& numbers) {
  constexpr size_t kLength = 5 + 2 * mtcnn::kPoints;
  std::vector<mtcnn::Face> faces;
  for (size_t i = 0; i + kLength <= numbers.size(); i += kLength) {
    const float* at = numbers.data() + i;
    mtcnn::Face face{{at[0], at[1], at[2], at[3]}, at[4], {}};
    std::copy_n(at + 5, face.points.size(), face.points.begin());
    faces.push_back(face);
  }
  return mtcnn::faces_text(faces);
}

struct Times::State {
  mtcnn::StageTimes times;
};

Times::Times() : state_(std::make_unique<State>()) {}
Times::~Times() = default;

void Times::picture(int64_t begin, int64_t proposed, int64_t refined, int64_t marked) {
  const int64_t all[] = {begin, proposed, refined, marked};
  for (size_t i = 0; i < mtcnn::kStages; ++i)
    state_->times.reached(static_cast<mtcnn::Stage>(i), begin,
                          std::chrono::steady_clock::time_point(std::chrono::nanoseconds(all[i])));
}

void Times::copied(uint64_t bytes) {
  state_->times.copied(bytes);
}

bool Times::write(const std::string& file) {
  const auto status = state_->times.write(file);
  if (!status) std::fprintf(stderr, "o: %s\n", status.error().message().c_str());
  return static_cast<bool>(status);
}

}  // namespace control
