// Tests of the functions of libnnstreamer.so for descriptions, text and accelerators.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "nnstreamer_plugin_api_filter.h"
#include "nnstreamer_plugin_api_util.h"

namespace functions_test {

std::string taken(gchar* text) {
  const std::string out = text ? text : "(none)";
  g_free(text);
  return out;
}

class Info {
 public:
  Info() { gst_tensors_info_init(&info_); }
  Info(const char* dimensions, const char* types) : Info() {
    info_.num_tensors = gst_tensors_info_parse_dimensions_string(&info_, dimensions);
    EXPECT_EQ(gst_tensors_info_parse_types_string(&info_, types), info_.num_tensors);
  }
  ~Info() { gst_tensors_info_free(&info_); }
  Info(const Info&) = delete;
  Info& operator=(const Info&) = delete;
  GstTensorsInfo* operator->() { return &info_; }
  GstTensorsInfo* get() { return &info_; }

 private:
  GstTensorsInfo info_;
};

TEST(CompatTypes, NamesAndNumbersAgree) {
  const std::vector<std::pair<const char*, size_t>> wanted{
      {"int32", 4},   {"uint32", 4},  {"int16", 2}, {"uint16", 2}, {"int8", 1},   {"uint8", 1},
      {"float64", 8}, {"float32", 4}, {"int64", 8}, {"uint64", 8}, {"float16", 2}};
  for (size_t i = 0; i < wanted.size(); ++i) {
    const auto type = static_cast<tensor_type>(i);
    EXPECT_EQ(gst_tensor_get_type(wanted[i].first), type);
    EXPECT_STREQ(gst_tensor_get_type_string(type), wanted[i].first);
    EXPECT_EQ(gst_tensor_get_element_size(type), wanted[i].second);
  }
  EXPECT_EQ(gst_tensor_get_type(" UInt8\t"), _NNS_UINT8);
  for (const char* bad : {"uint", "uint8x", "", "float8", "uint 8"})
    EXPECT_EQ(gst_tensor_get_type(bad), _NNS_END) << bad;
  EXPECT_EQ(gst_tensor_get_type(nullptr), _NNS_END);
  EXPECT_EQ(gst_tensor_get_type_string(_NNS_END), nullptr);
  EXPECT_EQ(gst_tensor_get_element_size(static_cast<tensor_type>(99)), 0u);
}

TEST(CompatDimensions, TextBecomesNumbersAndBack) {
  tensor_dim dim;
  EXPECT_EQ(gst_tensor_parse_dimension(" 3 :224: 224:1", dim), 4u);
  EXPECT_EQ(dim[1], 224u);
  EXPECT_EQ(dim[4], 0u);
  EXPECT_EQ(taken(gst_tensor_get_dimension_string(dim)), "3:224:224:1");
  EXPECT_EQ(gst_tensor_get_element_count(dim), 3u * 224 * 224);
  tensor_dim shorter;
  EXPECT_EQ(gst_tensor_parse_dimension("3:224:224", shorter), 3u);
  EXPECT_TRUE(gst_tensor_dimension_is_equal(dim, shorter));
  shorter[2] = 225;
  EXPECT_FALSE(gst_tensor_dimension_is_equal(dim, shorter));
}

TEST(CompatDimensions, InvalidDimensionsAreZero) {
  tensor_dim dim;
  std::fill(std::begin(dim), std::end(dim), 7u);
  EXPECT_EQ(gst_tensor_parse_dimension("x", dim), 0u);
  for (const uint32_t value : dim) EXPECT_EQ(value, 0u);
  EXPECT_EQ(taken(gst_tensor_get_dimension_string(dim)), "");
  EXPECT_FALSE(gst_tensor_dimension_is_equal(dim, dim));
  EXPECT_EQ(gst_tensor_parse_dimension(nullptr, dim), 0u);
  EXPECT_EQ(gst_tensor_parse_dimension("3:0:2", dim), 1u);
  EXPECT_FALSE(gst_tensor_dimension_is_valid(dim));
  EXPECT_EQ(gst_tensor_parse_dimension("4294967295:4294967295:4294967295", dim), 3u);
  EXPECT_EQ(gst_tensor_get_element_count(dim), 0u);
}

TEST(CompatInfo, SizesOfTensorsAndFrames) {
  Info info("3:4:5.10", "float32,uint16");
  ASSERT_EQ(info->num_tensors, 2u);
  EXPECT_TRUE(gst_tensors_info_validate(info.get()));
  EXPECT_EQ(gst_tensors_info_get_size(info.get(), 0), 240u);
  EXPECT_EQ(gst_tensors_info_get_size(info.get(), 1), 20u);
  EXPECT_EQ(gst_tensors_info_get_size(info.get(), -1), 260u);
  EXPECT_EQ(gst_tensors_info_get_size(info.get(), 2), 0u);
  EXPECT_EQ(taken(gst_tensors_info_get_dimensions_string(info.get())), "3:4:5,10");
  EXPECT_EQ(taken(gst_tensors_info_get_types_string(info.get())), "float32,uint16");
}

TEST(CompatInfo, EachTensorOf256HasItsPlace) {
  Info info;
  for (unsigned i = 0; i < 256; ++i) {
    auto* tensor = gst_tensors_info_get_nth_info(info.get(), i);
    ASSERT_NE(tensor, nullptr) << i;
    tensor->type = _NNS_INT32;
    tensor->dimension[0] = i + 1;
  }
  info->num_tensors = 256;
  EXPECT_EQ(gst_tensors_info_get_nth_info(info.get(), 256), nullptr);
  EXPECT_EQ(gst_tensors_info_get_size(info.get(), -1), 4u * 256 * 257 / 2);
  EXPECT_EQ(info->extra[239].dimension[0], 256u);
  Info copy;
  gst_tensors_info_copy(copy.get(), info.get());
  EXPECT_NE(copy->extra, info->extra);
  EXPECT_TRUE(gst_tensors_info_is_equal(copy.get(), info.get()));
  copy->extra[239].dimension[0] = 7;
  EXPECT_FALSE(gst_tensors_info_is_equal(copy.get(), info.get()));
}

TEST(CompatInfo, IncompleteInfosAreNotValid) {
  Info info("3:4", "float32");
  info->num_tensors = 2;
  EXPECT_FALSE(gst_tensors_info_validate(info.get()));
  info->num_tensors = 17;  // without `extra`
  EXPECT_FALSE(gst_tensors_info_validate(info.get()));
  info->num_tensors = 257;
  EXPECT_FALSE(gst_tensors_info_validate(info.get()));
  EXPECT_FALSE(gst_tensors_info_is_equal(info.get(), info.get()));
  info->format = _NNS_TENSOR_FORMAT_FLEXIBLE;
  info->num_tensors = 0;
  EXPECT_TRUE(gst_tensors_info_validate(info.get()));
  EXPECT_FALSE(gst_tensors_info_validate(nullptr));
  EXPECT_EQ(gst_tensors_info_get_size(nullptr, 0), 0u);
  gst_tensors_info_free(nullptr);
}

TEST(CompatInfo, NamesAreCopies) {
  Info info("1,1,1", "int8,int8,int8");
  EXPECT_EQ(gst_tensors_info_parse_names_string(info.get(), "a, ,c "), 3u);
  EXPECT_STREQ(info->info[0].name, "a");
  EXPECT_EQ(info->info[1].name, nullptr);
  EXPECT_EQ(taken(gst_tensors_info_get_names_string(info.get())), "a,,c");
  GstTensorInfo copy;
  gst_tensor_info_copy(&copy, &info->info[2]);
  EXPECT_STREQ(copy.name, "c");
  EXPECT_NE(copy.name, info->info[2].name);
  gst_tensor_info_free(&copy);
  EXPECT_EQ(copy.name, nullptr);
}

TEST(CompatInfo, MoreThan256EntriesAreTruncated) {
  std::string list = "1";
  for (int i = 0; i < 300; ++i) list += ",1";
  Info info;
  EXPECT_EQ(gst_tensors_info_parse_dimensions_string(info.get(), list.c_str()), 256u);
}

TEST(CompatConfig, RatesAreFractions) {
  GstTensorsConfig a, b;
  gst_tensors_config_init(&a);
  EXPECT_FALSE(gst_tensors_config_validate(&a));
  a.info.num_tensors = gst_tensors_info_parse_dimensions_string(&a.info, "2:2");
  gst_tensors_info_parse_types_string(&a.info, "uint8");
  a.rate_n = 30, a.rate_d = 1;
  EXPECT_TRUE(gst_tensors_config_validate(&a));
  gst_tensors_config_copy(&b, &a);
  b.rate_n = 60, b.rate_d = 2;
  EXPECT_TRUE(gst_tensors_config_is_equal(&a, &b));
  b.rate_d = 1;
  EXPECT_FALSE(gst_tensors_config_is_equal(&a, &b));
  b.rate_d = 0;
  EXPECT_FALSE(gst_tensors_config_validate(&b));
  gst_tensors_config_free(&a);
  gst_tensors_config_free(&b);
}

TEST(CompatAccelerators, TheUsersListThenTheFrameworks) {
  const char* supported[] = {"gpu", "cpu.simd", nullptr};
  const auto parse = [&](const char* text) { return parse_accl_hw(text, supported, "cpu", "gpu"); };
  EXPECT_EQ(parse(nullptr), ACCL_GPU);
  EXPECT_EQ(parse(""), ACCL_GPU);
  EXPECT_EQ(parse("false"), ACCL_NONE);
  EXPECT_EQ(parse("true"), ACCL_CPU);
  EXPECT_EQ(parse("TRUE:npu,GPU"), ACCL_GPU);
  EXPECT_EQ(parse("true:npu"), ACCL_CPU);
  EXPECT_EQ(parse("true:!gpu,cpu.neon"), ACCL_CPU_SIMD);
  EXPECT_EQ(parse("perhaps:gpu"), ACCL_NONE);
  EXPECT_EQ(parse_accl_hw("true:npu.edgetpu", nullptr, nullptr, nullptr), ACCL_NPU_EDGETPU);
  EXPECT_EQ(get_accl_hw_type("npu.sr"), ACCL_NPU_SR);
  EXPECT_EQ(get_accl_hw_type("quantum"), ACCL_NONE);
  EXPECT_STREQ(get_accl_hw_str(ACCL_NPU_SLSI), "npu.slsi");
  EXPECT_STREQ(get_accl_hw_str(static_cast<accl_hw>(77)), "none");
}

int freed, reported;
void free_one(void*) {
  ++freed;
}
void count_replacement(void*, void*) {
  ++reported;
}

TEST(CompatSharedModels, TheLastUserFrees) {
  int model = 0, other = 0, a = 0, b = 0;
  freed = reported = 0;
  EXPECT_EQ(nnstreamer_filter_shared_model_get(&a, "k"), nullptr);
  EXPECT_EQ(nnstreamer_filter_shared_model_insert_and_get(&a, "k", &model), &model);
  EXPECT_EQ(nnstreamer_filter_shared_model_insert_and_get(&b, "k", &other), &model);
  nnstreamer_filter_shared_model_replace(&a, "k", &other, count_replacement, free_one);
  EXPECT_EQ(freed, 1);
  EXPECT_EQ(reported, 1);
  EXPECT_EQ(nnstreamer_filter_shared_model_get(&b, "k"), &other);
  EXPECT_TRUE(nnstreamer_filter_shared_model_remove(&a, "k", free_one));
  EXPECT_FALSE(nnstreamer_filter_shared_model_remove(&a, "k", free_one));
  EXPECT_EQ(freed, 1);
  EXPECT_TRUE(nnstreamer_filter_shared_model_remove(&b, "k", free_one));
  EXPECT_EQ(freed, 2);
  EXPECT_EQ(nnstreamer_filter_shared_model_get(&b, "k"), nullptr);
  EXPECT_EQ(nnstreamer_filter_shared_model_insert_and_get(&b, nullptr, &model), nullptr);
}

TEST(CompatVersion, EqualsTheInterfaceVersion) {
  EXPECT_EQ(taken(nnstreamer_version_string()), "NNStreamer 2.7.0");
  guint major = 0, minor = 0;
  nnstreamer_version_fetch(&major, &minor, nullptr);
  EXPECT_EQ(major * 100 + minor, 207u);
}

}  // namespace functions_test
