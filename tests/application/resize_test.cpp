// Tests ml_single_* with a TensorFlow Lite model, whose inputs can be resized.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <numeric>
#include <string>
#include <vector>

#include "nnstreamer-single.h"
#include "nnstreamer.h"
#include "says.hpp"
#include "tensorflow-lite/tflite_builder_test_support.hpp"

namespace application_resize_test {

using namespace weir::engine_test;
using Dimension = std::vector<unsigned>;

std::string last_error() {
  const char* text = ml_error();
  return text ? text : "";
}

ml_tensors_info_h make_info(const Dimension& dimension,
                            ml_tensor_type_e type = ML_TENSOR_TYPE_FLOAT32, unsigned count = 1) {
  ml_tensors_info_h info = nullptr;
  ml_tensor_dimension entries = {};
  std::copy(dimension.begin(), dimension.end(), entries);
  ml_tensors_info_create_extended(&info);
  ml_tensors_info_set_count(info, count);
  for (unsigned i = 0; i < count; ++i) {
    ml_tensors_info_set_tensor_type(info, i, type);
    ml_tensors_info_set_tensor_dimension(info, i, entries);
  }
  return info;
}

// Writes y = x + 2, where the file has x with one element; `constant`: the number of 2s.
std::string write_model(int32_t constant) {
  const std::string path = ::testing::TempDir() + "/weir-add-" + std::to_string(constant) + "-" +
                           ::testing::UnitTest::GetInstance()->current_test_info()->name() +
                           ".tflite";
  const auto bytes = TfliteBuilder()
                         .input("x", kTfFloat, {constant})
                         .constant<float>("two", kTfFloat, {constant},
                                          std::vector<float>(static_cast<size_t>(constant), 2))
                         .output("y", kTfFloat, {constant})
                         .node(kOpAdd, {"x", "two"}, {"y"})
                         .bytes();
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  return path;
}

class Resize : public ::testing::Test {
 protected:
  void SetUp() override {
    bool available = false;
    ml_check_nnfw_availability(ML_NNFW_TYPE_TENSORFLOW_LITE, ML_NNFW_HW_ANY, &available);
    if (!available) GTEST_SKIP() << "TensorFlow Lite is not installed";
  }
  void TearDown() override {
    if (single_) ml_single_close(single_);
    for (auto* info : infos_) ml_tensors_info_destroy(info);
  }
  ml_tensors_info_h info(const Dimension& dimension, ml_tensor_type_e type = ML_TENSOR_TYPE_FLOAT32,
                         unsigned count = 1) {
    infos_.push_back(make_info(dimension, type, count));
    return infos_.back();
  }
  int open(int32_t constant, ml_tensors_info_h in = nullptr, ml_tensors_info_h out = nullptr) {
    return ml_single_open(&single_, write_model(constant).c_str(), in, out, ML_NNFW_TYPE_ANY,
                          ML_NNFW_HW_ANY);
  }
  size_t bytes(int (*get)(ml_single_h, ml_tensors_info_h*)) {
    ml_tensors_info_h got = nullptr;
    size_t size = 0;
    EXPECT_EQ(get(single_, &got), ML_ERROR_NONE);
    ml_tensors_info_get_tensor_size(got, -1, &size);
    ml_tensors_info_destroy(got);
    return size;
  }
  // The model takes and returns so many values now.
  void expect_values(size_t count) {
    EXPECT_EQ(bytes(ml_single_get_input_info), count * sizeof(float));
    EXPECT_EQ(bytes(ml_single_get_output_info), count * sizeof(float));
    std::vector<float> x(count);
    std::iota(x.begin(), x.end(), 0.0F);
    ml_tensors_data_h in = nullptr, out = nullptr;
    void* y = nullptr;
    size_t size = 0;
    ASSERT_EQ(ml_tensors_data_create(info({static_cast<unsigned>(count)}), &in), ML_ERROR_NONE);
    ml_tensors_data_set_tensor_data(in, 0, x.data(), size_t{count * sizeof(float)});
    ASSERT_EQ(ml_single_invoke(single_, in, &out), ML_ERROR_NONE) << ml_error();
    ASSERT_EQ(ml_tensors_data_get_tensor_data(out, 0, &y, &size), ML_ERROR_NONE);
    EXPECT_EQ(size, count * sizeof(float));
    for (auto& value : x) value += 2;
    EXPECT_EQ(std::memcmp(y, x.data(), size), 0);
    ml_tensors_data_destroy(in);
    ml_tensors_data_destroy(out);
  }

  ml_single_h single_ = nullptr;
  std::vector<ml_tensors_info_h> infos_;
};

TEST_F(Resize, AModelTakesShapesOfAnyRank) {
  ASSERT_EQ(open(1), ML_ERROR_NONE) << ml_error();
  expect_values(1);
  for (const auto& dimension : {Dimension{5, 1, 1, 1}, Dimension{5, 2, 3, 4}, Dimension{5, 2, 3, 4},
                                Dimension{2, 3, 1, 2, 2}, Dimension{7}, Dimension{1}}) {
    ASSERT_EQ(ml_single_set_input_info(single_, info(dimension)), ML_ERROR_NONE) << ml_error();
    expect_values(
        std::accumulate(dimension.begin(), dimension.end(), size_t{1},
                        [](size_t product, unsigned extent) { return product * extent; }));
  }
}

// The rank is that of the info, not that of the inputs before.
TEST_F(Resize, TheInputsDoNotDependOnThoseBefore) {
  ASSERT_EQ(open(1), ML_ERROR_NONE) << ml_error();
  const auto input = [this] {
    char* text = nullptr;
    EXPECT_EQ(ml_single_get_property(single_, "input", &text), ML_ERROR_NONE);
    const std::string out = text ? text : "";
    free(text);
    return out;
  };
  ASSERT_EQ(ml_single_set_input_info(single_, info({5})), ML_ERROR_NONE) << ml_error();
  const auto fresh = input();
  ASSERT_EQ(ml_single_set_input_info(single_, info({5, 2, 3, 4})), ML_ERROR_NONE) << ml_error();
  ASSERT_EQ(ml_single_set_input_info(single_, info({5})), ML_ERROR_NONE) << ml_error();
  EXPECT_EQ(input(), fresh);
}

TEST_F(Resize, AnAliasOfTheFrameworkResizesToo) {
  ml_option_h option = nullptr;
  ml_option_create(&option);
  const std::string path = write_model(1);
  ml_option_set(option, "models", const_cast<char*>(path.c_str()), nullptr);
  ml_option_set(option, "framework_name", const_cast<char*>("tensorflow2-lite"), nullptr);
  ASSERT_EQ(ml_single_open_with_option(&single_, option), ML_ERROR_NONE) << ml_error();
  EXPECT_EQ(ml_single_set_input_info(single_, info({4, 2})), ML_ERROR_NONE) << ml_error();
  expect_values(8);
  ml_option_destroy(option);
}

TEST_F(Resize, WhatTheModelCannotBeLeavesItUsable) {
  ASSERT_EQ(open(3), ML_ERROR_NONE) << ml_error();
  ASSERT_EQ(ml_single_set_input_info(single_, info({3, 2})), ML_ERROR_NONE) << ml_error();
  expect_values(6);
  EXPECT_EQ(ml_single_set_input_info(single_, info({5, 2})), ML_ERROR_INVALID_PARAMETER);
  EXPECT_SAYS(last_error(), "the model does not work with inputs of these shapes");
  expect_values(6);
  EXPECT_EQ(ml_single_set_input_info(single_, info({3, 2}, ML_TENSOR_TYPE_INT32)),
            ML_ERROR_INVALID_PARAMETER);
  EXPECT_SAYS(last_error(), "int32");
  EXPECT_EQ(ml_single_set_input_info(single_, info({3}, ML_TENSOR_TYPE_FLOAT32, 2)),
            ML_ERROR_INVALID_PARAMETER);
  EXPECT_SAYS(last_error(), "number of inputs");
  expect_values(6);
}

TEST_F(Resize, TheInfoOfOpenResizesToo) {
  ASSERT_EQ(open(1, info({4, 2})), ML_ERROR_NONE) << ml_error();
  expect_values(8);
  ml_single_close(single_);
  single_ = nullptr;
  EXPECT_EQ(open(1, info({4, 2}), info({4, 2})), ML_ERROR_NONE) << ml_error();
  ml_single_close(single_);
  single_ = nullptr;
  EXPECT_EQ(open(3, info({4, 2})), ML_ERROR_INVALID_PARAMETER);
  EXPECT_EQ(open(1, nullptr, info({4, 2})), ML_ERROR_INVALID_PARAMETER);
  EXPECT_SAYS(last_error(), "output_info differs from the outputs of the model");
}

TEST_F(Resize, ADynamicInvokeResizesUnlessItFails) {
  ASSERT_EQ(open(1), ML_ERROR_NONE) << ml_error();
  ml_tensors_data_h in = nullptr, out = nullptr;
  ml_tensors_info_h out_info = nullptr;
  size_t size = 0;
  ASSERT_EQ(ml_tensors_data_create(info({3, 2}), &in), ML_ERROR_NONE);
  ASSERT_EQ(ml_single_invoke_dynamic(single_, in, info({3, 2}), &out, &out_info), ML_ERROR_NONE)
      << ml_error();
  ml_tensors_info_get_tensor_size(out_info, 0, &size);
  EXPECT_EQ(size, 6 * sizeof(float));
  ml_tensors_info_destroy(out_info);
  ml_tensors_data_destroy(out);
  expect_values(6);
  EXPECT_EQ(ml_single_invoke_dynamic(single_, in, info({4, 2}), &out, &out_info),
            ML_ERROR_INVALID_PARAMETER);
  expect_values(6);
  ml_tensors_data_destroy(in);
}

TEST_F(Resize, AFileThatIsNoModelIsRefusedByTheEngine) {
  const std::string path = ::testing::TempDir() + "/weir-no-model.tflite";
  std::ofstream(path) << "no model";
  EXPECT_EQ(ml_single_open(&single_, path.c_str(), nullptr, nullptr, ML_NNFW_TYPE_TENSORFLOW_LITE,
                           ML_NNFW_HW_ANY),
            ML_ERROR_STREAMS_PIPE)
      << ml_error();
  EXPECT_EQ(single_, nullptr);
  EXPECT_EQ(ml_single_open(&single_, path.c_str(), nullptr, nullptr, ML_NNFW_TYPE_TENSORFLOW,
                           ML_NNFW_HW_ANY),
            ML_ERROR_INVALID_PARAMETER);
  EXPECT_EQ(ml_single_open(&single_, path.c_str(), nullptr, nullptr, ML_NNFW_TYPE_EDGE_TPU,
                           ML_NNFW_HW_ANY),
            ML_ERROR_INVALID_PARAMETER);
}

}  // namespace application_resize_test
