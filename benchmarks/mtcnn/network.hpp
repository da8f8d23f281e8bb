// Network: ONNX Runtime's own API with inputs and outputs by name, on the caller's input memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <onnxruntime_cxx_api.h>

#include <array>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

namespace control {

using Shape = std::array<int64_t, 4>;

// From 1.29 on the vendor's library reports opened models from its own threads. Disabled, as in
// Weir's engine.
inline Ort::Env silent_environment() {
  setenv("ORT_DISABLE_TELEMETRY", "1", 0);
  return Ort::Env();
}

class Network {
 public:
  Network(Ort::Env& env, const std::string& file, int threads, std::vector<const char*> outputs)
      : outputs_(std::move(outputs)), session_(env, file.c_str(), settings(threads)) {}
  std::vector<Ort::Value> run(std::span<float> values, const Shape& shape) {
    const auto memory = Ort::MemoryInfo::CreateCpu(OrtArenaAllocator, OrtMemTypeDefault);
    const auto input = Ort::Value::CreateTensor<float>(memory, values.data(), values.size(),
                                                       shape.data(), shape.size());
    const char* name = "input";
    return session_.Run(Ort::RunOptions{nullptr}, &name, &input, 1, outputs_.data(),
                        outputs_.size());
  }

 private:
  static Ort::SessionOptions settings(int threads) {
    Ort::SessionOptions options;
    options.SetIntraOpNumThreads(threads);
    options.AddConfigEntry("session.intra_op.allow_spinning", "0");
    return options;
  }
  std::vector<const char*> outputs_;
  Ort::Session session_;
};

inline Network p_net(Ort::Env& env, const std::string& models, int threads) {
  return {env, models + "/onnx/pnet.onnx", threads, {"prob", "reg"}};
}
inline Network r_net(Ort::Env& env, const std::string& models, int threads) {
  return {env, models + "/onnx/rnet.onnx", threads, {"prob", "reg"}};
}
inline Network o_net(Ort::Env& env, const std::string& models, int threads) {
  return {env, models + "/onnx/onet.onnx", threads, {"prob", "reg", "landmark"}};
}

}  // namespace control
