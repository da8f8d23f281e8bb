// Runs ONNX Runtime's own API as the control does.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "floor.hpp"
#include "network.hpp"

namespace control {
namespace {

// Normalised values in colour planes, for pictures of `places` pixels.
void add_planes(std::span<const uint8_t> bytes, size_t places, std::vector<float>* out) {
  for (; bytes.size() >= 3 * places; bytes = bytes.subspan(3 * places))
    for (size_t c = 0; c < 3; ++c)
      for (size_t i = 0; i < places; ++i)
        out->push_back((static_cast<float>(bytes[3 * i + c]) - 127.5f) / 128);
}

class OfOnnxRuntime final : public Invokes {
 public:
  OfOnnxRuntime(const std::string& models, uint32_t min_face, const Requests& max, const Seen& seen)
      : p_(p_net(env_, models, 1)),
        r_(r_net(env_, models, 1)),
        o_(o_net(env_, models, 1)),
        min_face_(min_face) {
    const Seen inputs = make_inputs(max, min_face, seen);
    std::span<const uint8_t> layers(inputs[0]);
    for (const auto& layer : mtcnn::pyramid(max.picture, min_face)) {
      const size_t places = size_t{layer.width} * layer.height;
      add_planes(layers.first(3 * places), places, &numbers_[0]);
      layers = layers.subspan(3 * places);
    }
    add_planes(inputs[1], mtcnn::kRefineSide * mtcnn::kRefineSide, &numbers_[1]);
    add_planes(inputs[2], mtcnn::kLandmarkSide * mtcnn::kLandmarkSide, &numbers_[2]);
  }
  void p(const Requests& requests) override {
    size_t at = 0;
    for (const auto& layer : mtcnn::pyramid(requests.picture, min_face_))
      at += one(p_, 0, at, 1, layer.width, layer.height);
  }
  void r(const Requests& requests) override {
    one(r_, 1, 0, requests.refined, mtcnn::kRefineSide, mtcnn::kRefineSide);
  }
  void o(const Requests& requests) override {
    one(o_, 2, 0, requests.marked, mtcnn::kLandmarkSide, mtcnn::kLandmarkSide);
  }

 private:
  // Returns how many values it used, starting at `at`.
  size_t one(Network& network, size_t of, size_t at, size_t count, uint32_t width,
             uint32_t height) {
    const size_t length = 3 * count * width * height;
    if (count > 0)
      network.run(std::span(numbers_[of]).subspan(at, length),
                  {static_cast<int64_t>(count), 3, height, width});
    return length;
  }
  Ort::Env env_ = silent_environment();
  Network p_, r_, o_;
  uint32_t min_face_;
  std::vector<float> numbers_[3];
};

}  // namespace

std::unique_ptr<Invokes> make_invokes(const std::string& models, uint32_t min_face,
                                      const Requests& max, const Seen& seen) {
  return std::make_unique<OfOnnxRuntime>(models, min_face, max, seen);
}

}  // namespace control
