// SPDX-License-Identifier: LGPL-2.1-or-later
#include "onnxruntime/own_prelu.hpp"

#include <algorithm>
#include <limits>
#include <mutex>

namespace weir::engine {
namespace {

constexpr ONNXTensorElementDataType kFloat = ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT;

// `in` and `out` are either the same memory or disjoint. One loop for each case lets the compiler
// vectorise both.
template <class Slope>
void scale_negative(Slope slope, const float* in, size_t count, float* out) {
  if (in == out) {
    for (size_t i = 0; i < count; ++i) {
      const float scaled = slope(i) * out[i];
      out[i] = out[i] < 0 ? scaled : out[i];
    }
    return;
  }
  const float* __restrict from = in;
  float* __restrict to = out;
  for (size_t i = 0; i < count; ++i) {
    const float scaled = slope(i) * from[i];
    to[i] = from[i] < 0 ? scaled : from[i];
  }
}

// `inner`: the elements per index of the slopes' axis.
void prelu(const float* in, std::span<const float> slopes, size_t outer, size_t inner, float* out) {
  const size_t channels = slopes.size();
  for (size_t o = 0; o < outer; ++o) {
    if (inner == 1) {  // channels are contiguous
      const float* each = slopes.data();
      scale_negative([each](size_t i) { return each[i]; }, in, channels, out);
      in += channels, out += channels;
      continue;
    }
    for (size_t c = 0; c < channels; ++c, in += inner, out += inner)
      scale_negative([slope = slopes[c]](size_t) { return slope; }, in, inner, out);
  }
}

struct Call {
  const OrtApi& api;
  OrtKernelContext* context;
  OrtStatus* status = nullptr;

  bool good(OrtStatus* of) {
    if (!status) status = of;
    return !of;
  }
  std::vector<int64_t> shape(const OrtValue* value) {
    OrtTensorTypeAndShapeInfo* info = nullptr;
    std::vector<int64_t> out;
    if (!good(api.GetTensorTypeAndShape(value, &info))) return out;
    size_t rank = 0;
    if (good(api.GetDimensionsCount(info, &rank))) {
      out.resize(rank);
      good(api.GetDimensions(info, out.data(), rank));
    }
    api.ReleaseTensorTypeAndShapeInfo(info);
    return out;
  }
  const OrtValue* input(size_t index) {
    const OrtValue* value = nullptr;
    good(api.KernelContext_GetInput(context, index, &value));
    return value;
  }
  float* numbers(const OrtValue* value) {
    void* data = nullptr;
    good(api.GetTensorMutableData(const_cast<OrtValue*>(value), &data));
    return static_cast<float*>(data);
  }
};

size_t product(std::span<const int64_t> shape) {
  size_t out = 1;
  for (const int64_t extent : shape) out *= static_cast<size_t>(extent);
  return out;
}

OrtStatus* compute(Call call) {
  const OrtValue *x = call.input(0), *slope = call.input(1);
  if (call.status) return call.status;
  const auto shape = call.shape(x), of_slopes = call.shape(slope);
  const float *in = call.numbers(x), *slopes = call.numbers(slope);
  OrtValue* y = nullptr;
  if (!call.status)
    call.good(call.api.KernelContext_GetOutput(call.context, 0, shape.data(), shape.size(), &y));
  if (call.status) return call.status;
  // The slopes' last axis aligns with the last axis of x; at most one of them is longer than 1.
  const size_t count = product(of_slopes);
  size_t axis = of_slopes.size();
  for (size_t i = 0; i < of_slopes.size(); ++i)
    if (of_slopes[i] != 1) axis = i;
  size_t inner = product(shape), outer = 1;
  if (axis < of_slopes.size()) {
    const size_t trailing = of_slopes.size() - axis;  // includes the axis itself
    if (trailing > shape.size() || shape[shape.size() - trailing] != of_slopes[axis])
      return call.api.CreateStatus(
          ORT_INVALID_ARGUMENT, "PRelu: the number of slopes differs from the number of channels");
    const std::span all(shape);
    outer = product(all.first(all.size() - trailing));
    inner = product(all.last(trailing - 1));
  }
  float* out = call.numbers(y);
  if (!call.status) prelu(in, {slopes, count}, outer, inner, out);
  return call.status;
}

// The output has the shape of x. Open sizes are not reported: ONNX Runtime would take its own -1 as
// a size and warn about each frame.
OrtStatus* infer(Call call, OrtShapeInferContext* context) {
  OrtTensorTypeAndShapeInfo* info = nullptr;  // owned by `context`
  size_t rank = 0;
  if (!call.good(call.api.ShapeInferContext_GetInputTypeShape(context, 0, &info)) ||
      !call.good(call.api.GetDimensionsCount(info, &rank)))
    return call.status;
  std::vector<int64_t> shape(rank);
  if (!call.good(call.api.GetDimensions(info, shape.data(), rank))) return call.status;
  if (rank == 0 || std::ranges::any_of(shape, [](int64_t extent) { return extent < 0; }))
    return nullptr;
  return call.api.ShapeInferContext_SetOutputTypeShape(context, 0, info);
}

// The kernel has no state, so the API pointer takes its place.
struct OwnPrelu : OrtCustomOp {
  OwnPrelu() : OrtCustomOp{} {
    version = ORT_API_VERSION;
    CreateKernel = [](const OrtCustomOp*, const OrtApi* api, const OrtKernelInfo*) {
      return static_cast<void*>(const_cast<OrtApi*>(api));
    };
    KernelDestroy = [](void*) {};
    GetName = [](const OrtCustomOp*) { return "PRelu"; };
    GetExecutionProviderType = [](const OrtCustomOp*) -> const char* { return nullptr; };
    GetInputType = GetOutputType = [](const OrtCustomOp*, size_t) { return kFloat; };
    GetInputTypeCount = [](const OrtCustomOp*) -> size_t { return 2; };
    GetOutputTypeCount = [](const OrtCustomOp*) -> size_t { return 1; };
    GetInputCharacteristic =
        GetOutputCharacteristic = [](const OrtCustomOp*, size_t) { return INPUT_OUTPUT_REQUIRED; };
    GetInputMemoryType = [](const OrtCustomOp*, size_t) { return OrtMemTypeDefault; };
    GetVariadicInputMinArity = GetVariadicInputHomogeneity = GetVariadicOutputMinArity =
        GetVariadicOutputHomogeneity = GetStartVersion = [](const OrtCustomOp*) { return 1; };
    GetEndVersion = [](const OrtCustomOp*) { return std::numeric_limits<int>::max(); };
    KernelComputeV2 = [](void* api, OrtKernelContext* context) -> OrtStatusPtr {
      return compute({*static_cast<const OrtApi*>(api), context});
    };
    InferOutputShapeFn = [](const OrtCustomOp* op, OrtShapeInferContext* context) -> OrtStatusPtr {
      return infer({*static_cast<const OwnPrelu*>(op)->api, nullptr}, context);
    };
    // The result may be computed in place.
    GetMayInplace = [](int** input, int** output) -> size_t {
      static int first = 0;
      *input = *output = &first;
      return 1;
    };
    ReleaseMayInplace = [](int*, int*) {};
  }
  const OrtApi* api = nullptr;
};

}  // namespace

Result<std::shared_ptr<const OwnOperators>> OwnOperators::shared(
    const std::shared_ptr<const OrtRuntime>& runtime) {
  static std::mutex mutex;  // guards `operators` and `prelu`
  static OwnPrelu prelu;
  static std::weak_ptr<const OwnOperators> operators;
  const std::lock_guard lock(mutex);
  if (auto living = operators.lock()) return living;
  const OrtApi& api = runtime->api();
  prelu.api = &api;
  OrtCustomOpDomain* domain = nullptr;
  const auto refused = [](const OrtFailure& bad) {
    return Error{.code = Code::INTERNAL,
                 .what = "ONNX Runtime rejects an operator of Weir",
                 .offered = bad.text};
  };
  if (auto bad = take(api, api.CreateCustomOpDomain("weir", &domain))) return refused(bad);
  std::shared_ptr<const OwnOperators> out(new OwnOperators(runtime, domain));
  if (auto bad = take(api, api.CustomOpDomain_Add(domain, &prelu))) return refused(bad);
  operators = out;
  return out;
}

}  // namespace weir::engine
