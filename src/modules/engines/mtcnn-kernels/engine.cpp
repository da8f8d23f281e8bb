// mtcnn-kernels engine: runs P-, R- or O-Net of an ONNX file with kernels of our own. See
// README.md.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <array>
#include <span>

#include "byte_kernels.hpp"
#include "model_bytes.hpp"
#include "runner.hpp"
#include "tensor_check.hpp"
#include "weir/engine.hpp"
#include "weir/engine_tools.hpp"

namespace mtcnn::kernels {
namespace {

using weir::Code;
using weir::Error;
using weir::Failure;

void check(const weir::Status& status) {
  if (!status) throw Failure(status.error());
}

// Mixed: 8 bits for P-Net, which only proposes regions; float32 for the nets that decide on a face.
Precision parse_precision(const weir::Options& options, const NetworkPlan& plan) {
  const auto text = options.get("Precision").value_or("float32");
  if (text == "float32") return Precision::Float32;
  if (text == "int8") return Precision::Int8;
  if (text == "mixed") return plan.dense ? Precision::Float32 : Precision::Int8;
  throw Failure(weir::engine::bad_option("Precision", text, "float32, mixed or int8", "int8"));
}

weir::engine::ModelBytes get_bytes(const weir::OpenRequest& request) {
  weir_open named{};
  named.struct_size = sizeof named;
  named.paths = request.paths.data();
  named.n_models = static_cast<uint32_t>(request.paths.size());
  return weir::value_or_throw(weir::engine::read_model(named));
}

Network make_network(const weir::OpenRequest& request) {
  const auto model = get_bytes(request);
  return weir::value_or_throw(read_network(model.bytes, model.name()));
}

class Engine {
 public:
  static constexpr const char* kOptions = R"([
    {"name": "Precision", "type": "float32|mixed|int8", "default": "float32",
     "help": "int8 is faster on CPUs with VNNI and detects faint faces less reliably; mixed: only P-Net uses int8"}])";

  explicit Engine(const weir::OpenRequest& request) : Engine(make_network(request), request) {}

  std::span<const weir_tensor_info> inputs() const { return {&input_, 1}; }
  std::span<const weir_tensor_info> outputs() const { return outputs_; }

  void resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out) {
    check(weir::engine::check_infos(inputs(), in, "input"));
    check(weir::engine::check_count(outputs(), out.size(), "output"));
    std::copy(outputs_.begin(), outputs_.end(), out.begin());
    const auto& shape = in[0].shape;
    for (auto& one : out) {
      one.shape[0] = shape[0];
      if (plan_.dense || shape[1] < 0 || shape[2] < 0) continue;
      const auto size = map_size(shape);
      one.shape[1] = static_cast<int64_t>(size.height);
      one.shape[2] = static_cast<int64_t>(size.width);
    }
  }

  bool invoke(std::span<const weir_tensor> in, std::span<weir_tensor> out) {
    check(weir::engine::check_inputs(inputs(), in));
    std::vector<weir_tensor_info> infos(outputs_.size());
    resolve({&in[0].info, 1}, infos);
    std::vector<float*> data;
    for (size_t i = 0; i < out.size(); ++i) data.push_back(get_memory(&out[i], infos[i], i));
    const auto* shape = in[0].info.shape;
    runner_->run(weir::elements<const uint8_t>(in[0]).data(), static_cast<size_t>(shape[0]),
                 static_cast<size_t>(shape[2]), static_cast<size_t>(shape[1]), data.data());
    return true;
  }

 private:
  Engine(const Network& network, const weir::OpenRequest& request)
      : plan_(*network.plan),
        runner_(make_runner(network, parse_precision(request.options, plan_))) {
    const int64_t side = plan_.dense ? int64_t{plan_.side} : -1;
    input_ = weir::tensor_info("picture", WEIR_UINT8, {-1, side, side, 3});
    static constexpr const char* kNames[] = {"prob", "reg", "landmark"};
    for (size_t i = 0; i < plan_.heads.size(); ++i)
      outputs_.push_back(
          plan_.dense ? weir::tensor_info(kNames[i], WEIR_FLOAT32, {-1, plan_.heads[i]})
                      : weir::tensor_info(kNames[i], WEIR_FLOAT32, {-1, -1, -1, plan_.heads[i]}));
  }

  Runner::MapSize map_size(const int64_t* shape) const {
    if (shape[1] < plan_.side || shape[2] < plan_.side) {
      const auto side = std::to_string(plan_.side);
      throw Failure({.code = Code::SPEC_MISMATCH,
                     .what = "the picture is smaller than the receptive field of the network",
                     .offered = std::to_string(shape[2]) + "x" + std::to_string(shape[1]),
                     .needed = "at least " + side + "x" + side});
    }
    return runner_->map_size(static_cast<size_t>(shape[2]), static_cast<size_t>(shape[1]));
  }

  static float* get_memory(weir_tensor* tensor, const weir_tensor_info& info, size_t index) {
    const size_t bytes = weir::engine::tensor_bytes(info).value_or(0);
    if (!tensor->data) weir::allocate(tensor, info, bytes);
    if (tensor->bytes != bytes)
      throw Failure({.code = Code::FRAME_SIZE,
                     .what = "the memory for an output has the wrong size",
                     .offered = std::to_string(tensor->bytes) + " bytes",
                     .needed = std::to_string(bytes) + " bytes",
                     .difference = "output " + std::to_string(index)});
    return static_cast<float*>(tensor->data);
  }

  const NetworkPlan& plan_;
  weir_tensor_info input_{};
  std::vector<weir_tensor_info> outputs_;
  std::unique_ptr<Runner> runner_;
};

}  // namespace
}  // namespace mtcnn::kernels

WEIR_ENGINE(mtcnn::kernels::Engine, "mtcnn-kernels", "1", "", "")
