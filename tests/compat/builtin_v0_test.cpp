// Programs that know a framework call its descriptor's members of version 0 without looking at the
// version, and compare the numbers that they return.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "nnstreamer_plugin_api_filter.h"
#include "nnstreamer_plugin_api_util.h"
#include "tensorflow-lite/tflite_builder_test_support.hpp"

namespace builtin_v0_test {

class Info {
 public:
  explicit Info(const char* dimensions = "", const char* types = "") {
    gst_tensors_info_init(&info);
    info.num_tensors = gst_tensors_info_parse_dimensions_string(&info, dimensions);
    gst_tensors_info_parse_types_string(&info, types);
  }
  ~Info() { gst_tensors_info_free(&info); }
  Info(const Info&) = delete;
  Info& operator=(const Info&) = delete;
  std::string dimensions() const {
    gchar* text = gst_tensors_info_get_dimensions_string(&info);
    std::string out = text;
    g_free(text);
    return out;
  }
  GstTensorsInfo info;
};

class Properties {
 public:
  explicit Properties(std::string model, const char* custom = nullptr) : path_(std::move(model)) {
    set_model(path_);
    prop.num_models = 1;
    prop.custom_properties = custom;
  }
  void set_model(const std::string& path) {
    path_ = path;
    file_ = path_.c_str();
    prop.model_files = &file_;
  }
  GstTensorFilterProperties prop{};

 private:
  std::string path_;
  const char* file_ = nullptr;
};

std::string filter_file(const char* name) {
  return std::string(std::getenv("WEIR_COMPAT_FILTERS")) + "/" + name + ".so";
}

std::string tflite_file(const char* name, const std::vector<int32_t>& shape) {
  const auto bytes = weir::engine_test::tflite_negation(shape).bytes();
  const std::string path = testing::TempDir() + name;
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  return path;
}

TEST(VersionZero, HasTheMembersOfNnstreamer) {
  const auto* custom = nnstreamer_filter_find("custom");
  ASSERT_NE(custom, nullptr);
  EXPECT_EQ(custom->version >> 16, UINT64_C(0xDEAFDEAD0000));
  EXPECT_STREQ(custom->name, "custom");
  EXPECT_TRUE(custom->allocate_in_invoke);
  EXPECT_FALSE(custom->verify_model_path || custom->allow_in_place || custom->run_without_model);
  EXPECT_TRUE(custom->invoke_NN && custom->getInputDimension && custom->getOutputDimension &&
              custom->setInputDimension && custom->destroyNotify && custom->checkAvailability &&
              custom->allocateInInvoke);
  EXPECT_FALSE(custom->reloadModel || custom->handleEvent || custom->statistics);
  const auto* cpp = nnstreamer_filter_find("cpp");
  ASSERT_NE(cpp, nullptr);
  EXPECT_EQ(cpp->version >> 16, UINT64_C(0xDEAFDEAD0000));
  EXPECT_FALSE(cpp->allocate_in_invoke || cpp->checkAvailability || cpp->destroyNotify);
  const auto* easy = nnstreamer_filter_find("custom-easy");
  EXPECT_EQ(easy->version >> 16, UINT64_C(0xDEAFDEAD0001));
}

TEST(VersionZero, CustomFilterWithItsOwnTensors) {
  const auto* fw = nnstreamer_filter_find("custom");
  long freed = 0;
  const std::string counter = std::to_string(reinterpret_cast<uintptr_t>(&freed));
  Properties given(filter_file("allocating"), counter.c_str());
  void* priv = nullptr;
  ASSERT_EQ(fw->open(&given.prop, &priv), 0);
  EXPECT_EQ(fw->open(&given.prop, &priv), -EINVAL) << "open already";
  Info in, out;
  EXPECT_EQ(fw->getInputDimension(&given.prop, &priv, &in.info), 0);
  EXPECT_EQ(in.dimensions(), "2");
  EXPECT_EQ(fw->getOutputDimension(&given.prop, &priv, &out.info), 0);
  EXPECT_EQ(fw->setInputDimension(&given.prop, &priv, &in.info, &out.info), -ENOENT);
  EXPECT_EQ(fw->allocateInInvoke(&priv), 0);
  uint64_t numbers[2] = {7, 8};
  const GstTensorMemory input{numbers, sizeof numbers};
  GstTensorMemory output{nullptr, sizeof numbers};
  ASSERT_EQ(fw->invoke_NN(&given.prop, &priv, &input, &output), 0);
  ASSERT_EQ(output.size, sizeof numbers);
  EXPECT_EQ(static_cast<uint64_t*>(output.data)[1], 1u);
  fw->destroyNotify(&priv, output.data);
  fw->destroyNotify(&priv, nullptr);
  fw->close(&given.prop, &priv);
  EXPECT_EQ(priv, nullptr);
  fw->close(&given.prop, &priv);
}

TEST(VersionZero, CustomFilterOfAnySize) {
  const auto* fw = nnstreamer_filter_find("custom");
  Properties given(filter_file("passthrough"));
  void* priv = nullptr;
  ASSERT_EQ(fw->open(&given.prop, &priv), 0);
  Info in, out;
  EXPECT_EQ(fw->getInputDimension(&given.prop, &priv, &in.info), -ENOENT);
  EXPECT_EQ(fw->getOutputDimension(&given.prop, &priv, &out.info), -ENOENT);
  const Info wanted("3:2", "uint8");
  EXPECT_EQ(fw->setInputDimension(&given.prop, &priv, &wanted.info, &out.info), 0);
  EXPECT_EQ(out.dimensions(), "3:2");
  EXPECT_EQ(fw->allocateInInvoke(&priv), -EINVAL);
  fw->close(&given.prop, &priv);
}

TEST(VersionZero, RefusesNullWithTheNumbersThatProgramsCompare) {
  const auto* fw = nnstreamer_filter_find("custom");
  Info info;
  const GstTensorMemory input{};
  GstTensorMemory output{};
  void* priv = nullptr;
  Properties none("");
  none.prop.model_files = nullptr;
  EXPECT_EQ(fw->open(&none.prop, &priv), -1);
  EXPECT_EQ(fw->invoke_NN(&none.prop, &priv, &input, &output), -EINVAL);
  EXPECT_EQ(fw->invoke_NN(&none.prop, nullptr, &input, &output), -EINVAL);
  EXPECT_EQ(fw->getInputDimension(&none.prop, nullptr, &info.info), -EINVAL);
  EXPECT_EQ(fw->getOutputDimension(&none.prop, &priv, &info.info), -EINVAL);
  EXPECT_EQ(fw->setInputDimension(&none.prop, &priv, &info.info, &info.info), -EINVAL);
  Properties missing("/nonexistent.so");
  EXPECT_LT(fw->open(&missing.prop, &priv), -1);
  EXPECT_EQ(priv, nullptr);
}

class TfliteVersionZero : public testing::Test {
 protected:
  void SetUp() override {
    fw = nnstreamer_filter_find("tensorflow-lite");
    if (!fw) GTEST_SKIP() << "the engine tensorflow-lite is not built";
    if (const int result = fw->open(&given.prop, &priv); result < 0)
      GTEST_SKIP() << "the library of TensorFlow Lite is not installed";
  }
  void TearDown() override {
    if (fw) fw->close(&given.prop, &priv);
  }
  void expect_negation(size_t count) {
    std::vector<float> x(count, 2.5f), y(count);
    const GstTensorMemory input{x.data(), count * sizeof(float)};
    GstTensorMemory output{y.data(), count * sizeof(float)};
    ASSERT_EQ(fw->invoke_NN(&given.prop, &priv, &input, &output), 0);
    EXPECT_EQ(y, std::vector<float>(count, -2.5f));
  }

  Properties given{tflite_file("weir_v0.tflite", {2, 3})};
  const GstTensorFilterFramework* fw = nullptr;
  void* priv = nullptr;
};

TEST_F(TfliteVersionZero, HasItsNameAndMembers) {
  EXPECT_EQ(fw->version >> 16, UINT64_C(0xDEAFDEAD0000));
  EXPECT_STREQ(fw->name, "tensorflow2-lite");
  EXPECT_TRUE(fw->verify_model_path && fw->statistics && fw->reloadModel && fw->setInputDimension &&
              fw->checkAvailability);
  EXPECT_FALSE(fw->allocate_in_invoke || fw->destroyNotify || fw->handleEvent ||
               fw->allocateInInvoke);
  EXPECT_EQ(fw->checkAvailability(ACCL_CPU), 0);
  EXPECT_EQ(fw->checkAvailability(ACCL_NPU_SLSI), -ENOENT);
  EXPECT_EQ(nnstreamer_filter_find("tensorflow2-lite"), fw);
}

TEST_F(TfliteVersionZero, SaysThatTheModelIsOpenAlready) {
  void* const before = priv;
  EXPECT_EQ(fw->open(&given.prop, &priv), 1);
  EXPECT_EQ(priv, before);
  expect_negation(6);
  given.set_model(tflite_file("weir_v0_other.tflite", {4}));
  EXPECT_EQ(fw->open(&given.prop, &priv), 0);
  expect_negation(4);
}

TEST_F(TfliteVersionZero, TakesInputsOfAnyRank) {
  Info in, out;
  for (const auto& [dimensions, count] :
       {std::pair{"2:3:4:1", 24}, {"5", 5}, {"3:2", 6}, {"2:3:4:5", 120}, {"3:2:1:1", 6}}) {
    const Info wanted(dimensions, "float32");
    ASSERT_EQ(fw->setInputDimension(&given.prop, &priv, &wanted.info, &out.info), 0) << dimensions;
    expect_negation(static_cast<size_t>(count));
  }
  const Info type("3:2", "uint8"), more("3:2,3:2", "float32,float32"),
      huge("2147483648", "float32");
  EXPECT_EQ(fw->setInputDimension(&given.prop, &priv, &type.info, &out.info), -EINVAL);
  EXPECT_EQ(fw->setInputDimension(&given.prop, &priv, &more.info, &out.info), -EINVAL);
  EXPECT_EQ(fw->setInputDimension(&given.prop, &priv, &huge.info, &out.info), -ERANGE);
  expect_negation(6);
}

TEST_F(TfliteVersionZero, KeepsTheModelWhenAnotherDoesNotFit) {
  EXPECT_EQ(fw->reloadModel(&given.prop, &priv), 0);
  void* nothing = nullptr;
  EXPECT_EQ(fw->reloadModel(&given.prop, &nothing), -EINVAL);
  given.prop.num_models = 0;
  EXPECT_EQ(fw->reloadModel(&given.prop, &priv), -1);
  given.prop.num_models = 1;
  given.set_model("/nonexistent.tflite");
  EXPECT_NE(fw->reloadModel(&given.prop, &priv), 0);
  given.set_model(tflite_file("weir_v0_other.tflite", {4}));
  EXPECT_NE(fw->reloadModel(&given.prop, &priv), 0);
  expect_negation(6);
}

}  // namespace builtin_v0_test
