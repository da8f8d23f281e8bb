// Runs our own float32 kernels without the engine's module.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <vector>

#include "floor.hpp"
#include "mtcnn-kernels/runner.hpp"

namespace control {
namespace {

namespace kernels = mtcnn::kernels;

std::unique_ptr<kernels::Runner> open_runner(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  if (!file) throw std::runtime_error(path + " cannot be read");
  const auto network = kernels::read_network(std::as_bytes(std::span(bytes)), path);
  if (!network) throw std::runtime_error(network.error().message());
  return kernels::make_runner(*network, kernels::Precision::Float32);
}

class OfKernels final : public Invokes {
 public:
  OfKernels(const std::string& models, uint32_t min_face, const Requests& max, const Seen& seen)
      : p_(open_runner(models + "/onnx/pnet.onnx")),
        r_(open_runner(models + "/onnx/rnet.onnx")),
        o_(open_runner(models + "/onnx/onet.onnx")),
        min_face_(min_face),
        bytes_(make_inputs(max, min_face, seen)) {}
  void p(const Requests& requests) override {
    size_t at = 0;
    for (const auto& layer : mtcnn::pyramid(requests.picture, min_face_)) {
      one(*p_, &bytes_[0][at], 1, layer.width, layer.height);
      at += 3 * size_t{layer.width} * layer.height;
    }
  }
  void r(const Requests& requests) override {
    one(*r_, bytes_[1].data(), requests.refined, mtcnn::kRefineSide, mtcnn::kRefineSide);
  }
  void o(const Requests& requests) override {
    one(*o_, bytes_[2].data(), requests.marked, mtcnn::kLandmarkSide, mtcnn::kLandmarkSide);
  }

 private:
  static constexpr size_t kMaxOutputs[] = {2, 4, 10};  // values per place and output

  void one(kernels::Runner& runner, const uint8_t* bytes, size_t count, uint32_t width,
           uint32_t height) {
    if (count == 0) return;
    const auto map = runner.map_size(width, height);
    float* out[3];
    for (size_t i = 0; i < 3; ++i) {
      out_[i].resize(kMaxOutputs[i] * count * map.width * map.height);
      out[i] = out_[i].data();
    }
    runner.run(bytes, count, width, height, out);
  }
  std::unique_ptr<kernels::Runner> p_, r_, o_;
  uint32_t min_face_;
  Seen bytes_;
  std::vector<float> out_[3];
};

}  // namespace

std::unique_ptr<Invokes> make_invokes(const std::string& models, uint32_t min_face,
                                      const Requests& max, const Seen& seen) {
  return std::make_unique<OfKernels>(models, min_face, max, seen);
}

}  // namespace control
