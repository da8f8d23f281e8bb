// A test engine whose model each test defines: tensors, flags, resolve and invoke.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <memory>
#include <span>

#include "core/direct/direct_model.hpp"
#include "core/direct/tensor_text.hpp"
#include "core/infer/module/host.hpp"
#include "says.hpp"
#include "weir/engine.hpp"

namespace weir::direct {

using In = std::span<const weir_tensor>;
using Out = std::span<weir_tensor>;

inline weir_tensor_info tensor_info(const char* name, uint32_t type, std::vector<int64_t> shape) {
  weir_tensor_info info{};
  info.type = type;
  info.name = name;
  info.rank = static_cast<uint32_t>(shape.size());
  std::copy(shape.begin(), shape.end(), info.shape);
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  return info;
}

inline std::span<const float> floats(const weir_tensor& tensor) {
  return {static_cast<const float*>(tensor.data), tensor.bytes / sizeof(float)};
}

// A float tensor lent by the caller; without a shape, it has the model's.
inline weir_tensor lend(std::span<const float> elements, std::vector<int64_t> shape = {}) {
  weir_tensor tensor{};
  tensor.data = const_cast<float*>(elements.data());
  tensor.bytes = tensor.capacity = elements.size_bytes();
  tensor.info = tensor_info("", WEIR_FLOAT32, shape);
  if (shape.empty()) tensor.info.rank = WEIR_RANK_UNKNOWN;
  return tensor;
}

struct TestModel {
  explicit TestModel(const OpenRequest&) {}
  ~TestModel() { ++closed; }
  std::span<const weir_tensor_info> inputs() const { return in; }
  std::span<const weir_tensor_info> outputs() const { return out; }
  void resolve(std::span<const weir_tensor_info> given, std::span<weir_tensor_info> to_fill) {
    ++resolves;
    if (resolve_body) resolve_body(given, to_fill);
  }
  bool invoke(In given, Out to_fill) { return invoke_body(given, to_fill); }

  static inline std::vector<weir_tensor_info> in, out;
  static inline std::function<void(std::span<const weir_tensor_info>, std::span<weir_tensor_info>)>
      resolve_body;
  static inline std::function<bool(In, Out)> invoke_body;
  static inline uint32_t flags = 0, alignment = 1, padding = 0;
  static inline std::atomic<int> closed = 0, resolves = 0;
};

// y = x + 1 on float32, one tensor each.
inline bool add_one(In in, Out out) {
  const auto x = floats(in[0]);
  auto* y = static_cast<float*>(out[0].data);
  for (size_t i = 0; i < x.size(); ++i) y[i] = x[i] + 1;
  return true;
}

class DirectTest : public testing::Test {
 protected:
  void SetUp() override {
    module_host = &infer::host();
    TestModel::in = {tensor_info("x", WEIR_FLOAT32, {-1, 2})};
    TestModel::out = {tensor_info("y", WEIR_FLOAT32, {-1, 2})};
    TestModel::resolve_body = [](auto in, auto out) { out[0].shape[0] = in[0].shape[0]; };
    TestModel::invoke_body = add_one;
    TestModel::flags = TestModel::padding = 0;
    TestModel::alignment = 1;
    TestModel::closed = TestModel::resolves = 0;
    table_ = engine_table<TestModel>("test", "1", "", "");
    table_.info = [](weir_model* model, weir_model_info* info, weir_error* error) {
      const int result = EngineTable<TestModel>::info(model, info, error);
      info->flags = TestModel::flags;
      info->alignment = TestModel::alignment;
      info->input_padding = TestModel::padding;
      return result;
    };
  }
  std::unique_ptr<DirectModel> open() {
    auto model = DirectModel::open(table_, {});
    EXPECT_TRUE(model) << model.error().message();
    return model ? *std::move(model) : nullptr;
  }
  static std::vector<float> values(const Results& results, size_t index = 0) {
    const auto all = floats(results.tensors()[index]);
    return {all.begin(), all.end()};
  }

  weir_engine table_{};
};

}  // namespace weir::direct
