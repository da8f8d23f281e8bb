// ONNX Runtime's own API, as the control uses it.
#include "floor.hpp"
#include "network.hpp"

namespace control {
namespace {

class OfOnnxRuntime final : public Invokes {
 public:
  OfOnnxRuntime(const std::string& models, uint32_t min_face)
      : p_(p_net(env_, models, 1)),
        r_(r_net(env_, models, 1)),
        o_(o_net(env_, models, 1)),
        min_face_(min_face) {}
  void p(const Asked& asked) override {
    for (const auto& layer : mtcnn::pyramid(asked.picture, min_face_))
      one(p_, 1, layer.width, layer.height);
  }
  void r(const Asked& asked) override {
    one(r_, asked.refined, mtcnn::kRefineSide, mtcnn::kRefineSide);
  }
  void o(const Asked& asked) override {
    one(o_, asked.marked, mtcnn::kLandmarkSide, mtcnn::kLandmarkSide);
  }

 private:
  void one(Network& network, size_t count, uint32_t width, uint32_t height) {
    numbers_.resize(3 * count * width * height, 0.1f);
    if (count > 0) network.run(numbers_, {static_cast<int64_t>(count), 3, height, width});
  }
  Ort::Env env_ = silent_environment();
  Network p_, r_, o_;
  uint32_t min_face_;
  std::vector<float> numbers_;
};

}  // namespace

std::unique_ptr<Invokes> make_invokes(const std::string& models, uint32_t min_face) {
  return std::make_unique<OfOnnxRuntime>(models, min_face);
}

}  // namespace control
