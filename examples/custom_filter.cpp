// A program that registers its own filters, three lambdas and a class, and uses them in a pipeline.
//
//   custom_filter 'tensor_filter framework=custom-easy model=doubler'
//   custom_filter 'tensor_filter framework=custom-easy model=positive invoke-dynamic=true'
//   custom_filter 'tensor_filter framework=custom-easy model=odd'
//   custom_filter 'tensor_filter framework=cpp model=Power custom=exponent:3'
//   c++ -std=c++20 custom_filter.cpp $(pkg-config --cflags --libs weir weir-pipeline)
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "weir/custom_filter.hpp"
#include "weir/pipeline.hpp"

namespace {

using namespace std::chrono_literals;
using In = std::span<const weir_tensor>;
using Out = std::span<weir_tensor>;

weir_tensor_info four(const char* name) {
  return weir::tensor_info(name, WEIR_FLOAT32, {4});
}

// With known sizes, the memory of the outputs is provided.
weir::RegisteredFilter doubler() {
  return {"doubler", {.inputs = {four("x")}, .outputs = {four("y")}}, [](In in, Out out) {
            const auto x = weir::elements<const float>(in[0]);
            const auto y = weir::elements<float>(out[0]);
            for (size_t i = 0; i < x.size(); ++i) y[i] = 2 * x[i];
          }};
}

// With sizes that change per frame, the filter provides the memory. It may drop a frame.
weir::RegisteredFilter positive() {
  return {"positive",
          {.inputs = {four("x")},
           .outputs = {weir::tensor_info("y", WEIR_FLOAT32, {-1})},
           .dynamic = true},
          [](In in, Out out) {
            std::vector<float> y;
            for (const float value : weir::elements<const float>(in[0]))
              if (value > 0) y.push_back(value);
            if (y.empty()) return false;
            const auto count = static_cast<int64_t>(y.size());
            weir::allocate(&out[0], weir::tensor_info("y", WEIR_FLOAT32, {count}),
                           y.size() * sizeof(float));
            std::copy(y.begin(), y.end(), weir::elements<float>(out[0]).begin());
            return true;
          }};
}

// The lambda owns its state; an exception ends the stream with its message.
weir::RegisteredFilter odd() {
  return {"odd",
          {.inputs = {four("x")}, .outputs = {four("y")}, .stateful = true},
          [frames = 0](In in, Out out) mutable {
            if (++frames == 3)
              throw weir::Failure({.code = weir::Code::CALLBACK_FAILED,
                                   .what = "the third frame is too much",
                                   .offered = std::to_string(frames),
                                   .needed = "two frames"});
            const auto x = weir::elements<const float>(in[0]);
            std::copy(x.begin(), x.end(), weir::elements<float>(out[0]).begin());
          }};
}

// A class may have options, and each element gets its own object.
class Power {
 public:
  static constexpr const char* kOptions =
      R"([{"name": "exponent", "type": "number", "default": "2", "help": "of each value"}])";
  explicit Power(const weir::OpenRequest& request)
      : exponent_(std::stof(std::string(request.options.get("exponent").value_or("2")))) {}
  std::span<const weir_tensor_info> inputs() const { return {&tensor_, 1}; }
  std::span<const weir_tensor_info> outputs() const { return {&tensor_, 1}; }
  bool invoke(In in, Out out) {
    const auto x = weir::elements<const float>(in[0]);
    const auto y = weir::elements<float>(out[0]);
    for (size_t i = 0; i < x.size(); ++i) y[i] = std::pow(x[i], exponent_);
    return true;
  }

 private:
  float exponent_;
  weir_tensor_info tensor_ = four("x");
};

int complain(const weir::Error& error) {
  std::fprintf(stderr, "%s\n", error.message().c_str());
  return 1;
}

int run(const std::string& filter) {
  auto made = weir::Pipeline::parse("appsrc name=in ! " + filter + " ! tensor_sink name=out");
  if (!made) return complain(made.error());
  weir::Pipeline& pipeline = *made;
  if (const auto status = pipeline.start(); !status) return complain(status.error());
  for (int n = 0; n < 3; ++n) {
    const float x = static_cast<float>(n);
    const std::vector<float> values{x - 2, x - 1, x, x + 1};
    if (const auto status = pipeline.push<float>("in", values, {.shape = {4}}); !status)
      return complain(status.error());
  }
  if (const auto status = pipeline.end("in"); !status) return complain(status.error());
  for (;;) {
    const auto frame = pipeline.pull<float>("out", 30s);
    if (!frame) return complain(frame.error());
    if (!*frame) return 0;
    const auto values = (**frame)[0].as<float>();
    for (const float value : *values) std::printf("%g ", static_cast<double>(value));
    std::printf("\n");
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "custom_filter 'tensor_filter ...'\n"), 2;
  [[maybe_unused]] const auto lambdas = {doubler(), positive(), odd()};
  [[maybe_unused]] const weir::RegisteredFilterClass<Power> power("Power");
  return run(argv[1]);
}
