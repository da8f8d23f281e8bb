// Measures the speed-up of a quantised .tflite model when it is lowered to ONNX Runtime.
//
// Usage: lowering_cost MODEL ROUNDS. Runs on one thread each, alternating, and takes the minimum
// CPU time of the process over the rounds. Prints the microseconds of an invoke for TensorFlow Lite
// (without its delegate if that rejects the model) and lowered, and the milliseconds of opening
// each.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "core/infer/model/model.hpp"
#include "core/infer/module/module_library.hpp"
#include "rounds.hpp"

namespace {

using namespace weir;

[[noreturn]] void fail(const Error& error) {
  std::fprintf(stderr, "%s\n", error.message().c_str());
  std::exit(1);
}

// A model that repeatedly runs the same frame of noise.
class Runner {
 public:
  Runner(const weir_engine& engine, const char* path, const char* lowering) {
    infer::OpenOptions options;
    options.paths = {path};
    options.options = {{"Lowering", lowering}};
    options.threads = 1;
    const double before = bench::seconds(CLOCK_MONOTONIC);
    auto model = infer::Model::open(engine, options);
    if (!model) fail(model.error());
    opened_ = bench::seconds(CLOCK_MONOTONIC) - before;
    auto session = infer::Session::create(*model);
    if (!session) fail(session.error());
    session_ = *std::move(session);
    auto inputs = (*model)->inputs();
    for (auto& info : inputs)  // open dimensions become 1
      for (uint32_t i = 0; i < info.rank; ++i) info.shape[i] = std::max<int64_t>(info.shape[i], 1);
    const auto outputs = session_->resolve(inputs);
    if (!outputs) fail(outputs.error());
    for (const auto& info : inputs) add(info, &in_);
    for (const auto& info : *outputs) add(info, &out_);
  }
  double opened() const { return opened_; }
  void invoke() {
    weir_frame in = frame(&in_), out = frame(&out_);
    if (const auto done = session_->invoke(in, out); !done) fail(done.error());
  }

 private:
  void add(const weir_tensor_info& info, std::vector<weir_tensor>* to) {
    size_t bytes = info.type == WEIR_FLOAT32 || info.type == WEIR_INT32 ? 4 : 1;
    for (uint32_t i = 0; i < info.rank; ++i) bytes *= static_cast<size_t>(info.shape[i]);
    memory_.push_back(std::make_unique<std::vector<unsigned char>>(bytes));
    auto& data = *memory_.back();
    for (size_t i = 0; i < bytes && info.type != WEIR_FLOAT32; ++i)
      data[i] = static_cast<unsigned char>(i * 37 % 251);
    weir_tensor tensor{};
    tensor.data = data.data();
    tensor.bytes = tensor.capacity = bytes;
    tensor.info = info;
    to->push_back(tensor);
  }
  static weir_frame frame(std::vector<weir_tensor>* tensors) {
    weir_frame out{};
    out.struct_size = sizeof out;
    out.n_tensors = static_cast<uint32_t>(tensors->size());
    out.tensors = tensors->data();
    out.pts = out.duration = out.deadline = -1;
    return out;
  }

  double opened_ = 0;
  std::unique_ptr<infer::Session> session_;
  std::vector<weir_tensor> in_, out_;
  std::vector<std::unique_ptr<std::vector<unsigned char>>> memory_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const auto engine = infer::ModuleLibrary::instance().engine("tensorflow-lite");
  if (!engine) fail(engine.error());
  Runner own(**engine, argv[1], "None"), lowered(**engine, argv[1], "onnxruntime");
  // The libraries are loaded now.
  const Runner own_again(**engine, argv[1], "None"), again(**engine, argv[1], "onnxruntime");
  const auto cost =
      bench::min({[&] { own.invoke(); }, [&] { lowered.invoke(); }}, std::atoi(argv[2]));
  std::printf(
      "{\"own_us\": %.0f, \"lowered_us\": %.0f, \"own_open_ms\": %.1f, \"lowered_open_ms\": "
      "%.1f}\n",
      cost[0].cpu * 1e6, cost[1].cpu * 1e6, own_again.opened() * 1e3, again.opened() * 1e3);
}
