// Tests that every engine must pass with the same model in its own format.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <thread>

#include "engine_test_support.hpp"
#include "out_of_memory_test_support.hpp"

namespace weir::engine_test {

// Model: inputs "b" and "a"; outputs "difference" (b - a) and "a sum"; all float32[1].
inline void expect_order_and_names(OpenEngine& model) {
  EXPECT_STREQ(model.inputs()[0].name, "b");
  EXPECT_STREQ(model.inputs()[1].name, "a");
  EXPECT_STREQ(model.outputs()[0].name, "difference");
  EXPECT_STREQ(model.outputs()[1].name, "a sum");
  const auto out = model.invoke(
      {make_tensor<float>(WEIR_FLOAT32, {1}, {5}), make_tensor<float>(WEIR_FLOAT32, {1}, {3})});
  ASSERT_TRUE(out) << out.error().message();
  EXPECT_EQ((*out)[0].values<float>()[0], 2);
  EXPECT_EQ((*out)[1].values<float>()[0], 8);
}

// Model: one input and one output with rows of three float32; the stream sets the number of rows.
inline void expect_rows_of_the_stream(OpenEngine& model) {
  EXPECT_EQ(to_string(model.inputs()[0]), "float32[-1, 3]");
  EXPECT_EQ(model.inputs()[0].batch_axis, 0u);
  const auto out = model.resolve({make_tensor(WEIR_FLOAT32, {7, 3}).info});
  ASSERT_TRUE(out) << out.error().message();
  EXPECT_EQ(to_string((*out)[0]), "float32[7, 3]");
  const auto open_still = model.resolve(model.inputs());
  ASSERT_TRUE(open_still) << open_still.error().message();
  EXPECT_EQ(to_string((*open_still)[0]), "float32[-1, 3]");
}

// Model: y = -x of any length. Four threads open it, and each runs its own session.
inline void expect_threads_to_run_at_once(const std::string& path) {
  std::vector<std::thread> threads;
  std::vector<int> good(4);
  for (size_t t = 0; t < good.size(); ++t)
    threads.emplace_back([&, t] {
      auto model = OpenEngine::open(*engine(), path);
      for (int i = 0; model && i < 50; ++i) {
        const auto size = static_cast<int64_t>(t * 7 + 1);
        const std::vector<float> x(static_cast<size_t>(size), static_cast<float>(i));
        const auto y = (*model)->invoke({make_tensor<float>(WEIR_FLOAT32, {size}, x)});
        good[t] += y && (*y)[0].values<float>().back() == -static_cast<float>(i);
      }
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(good, std::vector<int>(4, 50));
}

}  // namespace weir::engine_test
