// Tests of nnstreamer_filter_find() and its siblings for Weir's own engines, decoders and
// converters: their results are called as programs call them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <numeric>
#include <string>
#include <vector>

#include "nnstreamer_plugin_api_converter.h"
#include "nnstreamer_plugin_api_decoder.h"
#include "nnstreamer_plugin_api_filter.h"
#include "tensor_filter_custom_easy.h"

namespace builtin_test {

class Info {
 public:
  Info(const char* dimensions, const char* types) {
    gst_tensors_info_init(&info_);
    info_.num_tensors = gst_tensors_info_parse_dimensions_string(&info_, dimensions);
    gst_tensors_info_parse_types_string(&info_, types);
  }
  ~Info() { gst_tensors_info_free(&info_); }
  Info(const Info&) = delete;
  Info& operator=(const Info&) = delete;
  const GstTensorsInfo* get() const { return &info_; }

 private:
  GstTensorsInfo info_;
};

std::string taken(gchar* text) {
  const std::string out = text ? text : "(none)";
  g_free(text);
  return out;
}

int squares(void*, const GstTensorFilterProperties*, const GstTensorMemory* in,
            GstTensorMemory* out) {
  for (size_t i = 0; i < in[0].size; ++i) {
    const uint32_t x = static_cast<const uint8_t*>(in[0].data)[i];
    static_cast<uint32_t*>(out[0].data)[i] = x * x;
  }
  return 0;
}

// A model of a framework, opened with its descriptor's functions.
class Opened {
 public:
  Opened(const char* framework, const char* model, const char* custom = nullptr)
      : found(nnstreamer_filter_find(framework)), model_(model) {
    gst_tensors_info_init(&prop.input_meta);
    gst_tensors_info_init(&prop.output_meta);
    prop.fwname = framework;
    prop.model_files = &model_;
    prop.num_models = 1;
    prop.custom_properties = custom;
    result = found ? found->open(&prop, &priv) : -1;
  }
  ~Opened() {
    if (found) found->close(&prop, &priv);
    EXPECT_EQ(priv, nullptr);
    gst_tensors_info_free(&prop.output_meta);
  }
  Opened(const Opened&) = delete;
  Opened& operator=(const Opened&) = delete;

  int info(model_info_ops op, GstTensorsInfo* in, GstTensorsInfo* out) {
    return found->getModelInfo(found, &prop, priv, op, in, out);
  }
  int invoke(const GstTensorMemory* in, GstTensorMemory* out) {
    return found->invoke(found, &prop, priv, in, out);
  }

  const GstTensorFilterFramework* found;
  GstTensorFilterProperties prop{};
  void* priv = nullptr;
  int result;

 private:
  const char* model_;
};

class BuiltInFilter : public testing::Test {
 protected:
  BuiltInFilter() {
    const Info in("4", "uint8"), out("4", "uint32");
    EXPECT_EQ(NNS_custom_easy_register("squares", squares, nullptr, in.get(), out.get()), 0);
  }
  ~BuiltInFilter() override { EXPECT_EQ(NNS_custom_easy_unregister("squares"), 0); }
};

TEST_F(BuiltInFilter, ReportsItselfAndItsModelsInputs) {
  Opened opened("custom-easy", "squares");
  ASSERT_NE(opened.found, nullptr);
  ASSERT_EQ(opened.result, 0);
  EXPECT_EQ(opened.found->version >> 16, UINT64_C(0xDEAFDEAD0001));
  GstTensorFilterFrameworkInfo about{};
  ASSERT_EQ(opened.found->getFrameworkInfo(opened.found, &opened.prop, nullptr, &about), 0);
  EXPECT_STREQ(about.name, "custom-easy");
  EXPECT_FALSE(about.verify_model_path);
  ASSERT_GT(about.num_hw, 0);
  EXPECT_EQ(about.hw_list[0], ACCL_CPU);
  GstTensorsInfo in, out;
  ASSERT_EQ(opened.info(GET_IN_OUT_INFO, &in, &out), 0);
  EXPECT_EQ(taken(gst_tensors_info_get_dimensions_string(&in)), "4");
  EXPECT_EQ(taken(gst_tensors_info_get_types_string(&out)), "uint32");
  gst_tensors_info_free(&in);
  gst_tensors_info_free(&out);
}

TEST_F(BuiltInFilter, InvokesIntoTheCallersMemoryAndIntoItsOwn) {
  Opened opened("custom-easy", "squares");
  ASSERT_EQ(opened.result, 0);
  uint8_t numbers[] = {1, 2, 3, 255};
  const uint32_t wanted[] = {1, 4, 9, 65025};
  uint32_t place[4] = {};
  const GstTensorMemory in{numbers, sizeof numbers};
  GstTensorMemory out{place, sizeof place};
  ASSERT_EQ(opened.invoke(&in, &out), 0);
  EXPECT_EQ(std::memcmp(place, wanted, sizeof wanted), 0);
  GstTensorMemory given{nullptr, 0};
  ASSERT_EQ(opened.invoke(&in, &given), 0);
  ASSERT_EQ(given.size, sizeof wanted);
  EXPECT_EQ(std::memcmp(given.data, wanted, sizeof wanted), 0);
  GstTensorFilterFrameworkEventData event{};
  event.data = given.data;
  EXPECT_EQ(
      opened.found->eventHandler(opened.found, &opened.prop, opened.priv, DESTROY_NOTIFY, &event),
      0);
}

// Programs pass NULL for what these functions do not need.
TEST_F(BuiltInFilter, IsCalledWithoutDescriptorAndProperties) {
  Opened opened("custom-easy", "squares");
  ASSERT_EQ(opened.result, 0);
  const auto* found = opened.found;
  uint8_t numbers[] = {1, 2, 3, 4};
  uint32_t place[4] = {};
  const GstTensorMemory in{numbers, sizeof numbers};
  GstTensorMemory out{place, sizeof place};
  EXPECT_EQ(found->invoke(nullptr, nullptr, opened.priv, &in, &out), 0);
  EXPECT_EQ(place[3], 16u);
  EXPECT_EQ(found->invoke(nullptr, nullptr, nullptr, &in, &out), -EINVAL);
  GstTensorsInfo info_in, info_out;
  ASSERT_EQ(
      found->getModelInfo(nullptr, nullptr, opened.priv, GET_IN_OUT_INFO, &info_in, &info_out), 0);
  gst_tensors_info_free(&info_in);
  gst_tensors_info_free(&info_out);
  const char* model = "squares";
  GstTensorFilterFrameworkEventData event{};
  event.model_files = &model;
  event.num_models = 1;
  EXPECT_EQ(found->eventHandler(nullptr, nullptr, opened.priv, RELOAD_MODEL, &event), 0);
  EXPECT_EQ(found->eventHandler(nullptr, nullptr, nullptr, RELOAD_MODEL, &event), -EINVAL);
  event.hw = ACCL_CPU;
  event.custom = nullptr;
  EXPECT_EQ(found->eventHandler(nullptr, nullptr, opened.priv, CHECK_HW_AVAILABILITY, &event), 0);
  EXPECT_EQ(found->invoke(nullptr, nullptr, opened.priv, &in, &out), 0);
}

TEST_F(BuiltInFilter, RejectsInvalidCalls) {
  Opened unknown("custom-easy", "no-such-function");
  ASSERT_NE(unknown.found, nullptr);
  EXPECT_LT(unknown.result, 0);
  EXPECT_LT(unknown.invoke(nullptr, nullptr), 0);
  Opened opened("custom-easy", "squares");
  ASSERT_EQ(opened.result, 0);
  uint8_t numbers[3] = {};
  uint32_t place[4] = {};
  const GstTensorMemory in{numbers, sizeof numbers};
  GstTensorMemory out{place, sizeof place};
  EXPECT_LT(opened.invoke(&in, &out), 0) << "3 bytes for 4 numbers";
  uint8_t four[4] = {};
  const GstTensorMemory good{four, sizeof four};
  GstTensorMemory small{place, 8};
  EXPECT_LT(opened.invoke(&good, &small), 0) << "8 bytes for 4 uint32";
  const Info other("5", "uint8");
  GstTensorsInfo ignored;
  EXPECT_LT(opened.info(SET_INPUT_INFO, const_cast<GstTensorsInfo*>(other.get()), &ignored), 0);
  EXPECT_LT(opened.found->open(nullptr, nullptr), 0);
  EXPECT_LT(opened.found->getFrameworkInfo(opened.found, nullptr, nullptr, nullptr), 0);
  EXPECT_EQ(nnstreamer_filter_find("no-such-framework"), nullptr);
  EXPECT_EQ(nnstreamer_filter_find(nullptr), nullptr);
}

// y = x + 1 on float32 of any number of rows of four.
TEST_F(BuiltInFilter, OfAnEngineInAModuleAcceptsTheGivenSizes) {
  const std::string model = testing::TempDir() + "weir_built_in_model.bin";
  std::ofstream(model) << "x";
  Opened opened("fake", model.c_str());
  ASSERT_EQ(opened.result, 0);
  GstTensorFilterFrameworkInfo about{};
  ASSERT_EQ(opened.found->getFrameworkInfo(opened.found, &opened.prop, nullptr, &about), 0);
  EXPECT_TRUE(about.verify_model_path);
  GstTensorsInfo in, out;
  ASSERT_EQ(opened.info(GET_IN_OUT_INFO, &in, &out), 0);
  EXPECT_EQ(taken(gst_tensors_info_get_dimensions_string(&in)), "4:1") << "1 for what is open";
  gst_tensors_info_free(&in);
  gst_tensors_info_free(&out);
  const Info rows("4:2", "float32");
  ASSERT_EQ(opened.info(SET_INPUT_INFO, const_cast<GstTensorsInfo*>(rows.get()), &out), 0);
  EXPECT_EQ(taken(gst_tensors_info_get_dimensions_string(&out)), "4:2");
  gst_tensors_info_free(&out);
  std::vector<float> numbers(8), result(8), wanted(8);
  std::iota(numbers.begin(), numbers.end(), 0.0f);
  std::iota(wanted.begin(), wanted.end(), 1.0f);
  const GstTensorMemory input{numbers.data(), numbers.size() * sizeof(float)};
  GstTensorMemory output{result.data(), result.size() * sizeof(float)};
  ASSERT_EQ(opened.invoke(&input, &output), 0);
  EXPECT_EQ(result, wanted);
  Opened missing("fake", "/nonexistent.bin");
  EXPECT_LT(missing.result, 0);
}

TEST_F(BuiltInFilter, RejectsTooManyTensors) {
  Opened opened("custom-easy", "squares");
  ASSERT_EQ(opened.result, 0);
  Info many("4", "uint8");
  uint8_t numbers[4] = {};
  uint32_t place[4] = {};
  const GstTensorMemory in{numbers, sizeof numbers};
  GstTensorMemory out{place, sizeof place};
  GstTensorsInfo ignored;
  for (const unsigned count : {257u, 0xFFFFFFFFu}) {
    auto info = *many.get();
    info.num_tensors = count;
    EXPECT_LT(opened.info(SET_INPUT_INFO, &info, &ignored), 0) << count;
    opened.prop.input_meta.num_tensors = count;
    EXPECT_LT(opened.invoke(&in, &out), 0) << count;
    void* other = nullptr;
    EXPECT_LT(opened.found->open(&opened.prop, &other), 0) << count;
    EXPECT_EQ(other, nullptr);
    opened.prop.input_meta.num_tensors = 0;
  }
  EXPECT_EQ(opened.invoke(&in, &out), 0);
}

TEST_F(BuiltInFilter, IsOneDescriptorForEachEngine) {
  const auto* easy = nnstreamer_filter_find("custom-easy");
  EXPECT_EQ(nnstreamer_filter_find("custom-easy"), easy);
  EXPECT_NE(nnstreamer_filter_find("custom"), easy);
  EXPECT_NE(nnstreamer_filter_find("cpp"), nullptr);
}

GstTensorsConfig make_config(const char* dimensions, const char* types) {
  GstTensorsConfig config;
  gst_tensors_config_init(&config);
  config.info.num_tensors = gst_tensors_info_parse_dimensions_string(&config.info, dimensions);
  gst_tensors_info_parse_types_string(&config.info, types);
  config.rate_n = 30;
  config.rate_d = 1;
  return config;
}

TEST(BuiltInDecoder, ProducesPicturesFollowingItsOptions) {
  const auto* found = nnstreamer_decoder_find("direct_video");
  ASSERT_NE(found, nullptr);
  EXPECT_STREQ(found->modename, "direct_video");
  EXPECT_EQ(nnstreamer_decoder_find("direct_video"), found);
  EXPECT_NE(nnstreamer_decoder_find("octet_stream"), found);
  void* priv = nullptr;
  ASSERT_TRUE(found->init(&priv));
  const auto config = make_config("3:4:2", "uint8");
  GstCaps* caps = found->getOutCaps(&priv, &config);
  ASSERT_NE(caps, nullptr);
  const auto* structure = gst_caps_get_structure(caps, 0);
  int width = 0;
  EXPECT_STREQ(gst_structure_get_string(structure, "format"), "RGB");
  EXPECT_TRUE(gst_structure_get_int(structure, "width", &width));
  EXPECT_EQ(width, 4);
  gst_caps_unref(caps);
  EXPECT_TRUE(found->setOption(&priv, 0, "BGR"));
  EXPECT_FALSE(found->setOption(&priv, 9, "BGR"));
  caps = found->getOutCaps(&priv, &config);
  EXPECT_STREQ(gst_structure_get_string(gst_caps_get_structure(caps, 0), "format"), "BGR");
  gst_caps_unref(caps);
  std::vector<uint8_t> pixels(24);
  std::iota(pixels.begin(), pixels.end(), 1);
  const GstTensorMemory memory{pixels.data(), pixels.size()};
  GstBuffer* out = gst_buffer_new();
  ASSERT_EQ(found->decode(&priv, &config, &memory, out), GST_FLOW_OK);
  std::vector<uint8_t> read(24);
  EXPECT_EQ(gst_buffer_extract(out, 0, read.data(), 100), 24u);
  EXPECT_EQ(read, pixels);
  const GstTensorMemory small{pixels.data(), 23};
  EXPECT_EQ(found->decode(&priv, &config, &small, out), GST_FLOW_ERROR);
  gst_buffer_unref(out);
  found->exit(&priv);
  EXPECT_EQ(priv, nullptr);
}

// GStreamer merges the memories of a buffer when the 17th is added.
TEST(BuiltInDecoder, ProducesOneBufferOfManyTensors) {
  const auto* found = nnstreamer_decoder_find("octet_stream");
  ASSERT_NE(found, nullptr);
  for (const size_t count : {1, 15, 16, 17, 20, 256}) {
    std::string dimensions = "4", types = "uint8";
    for (size_t i = 1; i < count; ++i) dimensions += ",4", types += ",uint8";
    auto config = make_config(dimensions.c_str(), types.c_str());
    ASSERT_EQ(config.info.num_tensors, count);
    std::vector<uint8_t> bytes(4 * count);
    std::iota(bytes.begin(), bytes.end(), uint8_t{1});
    std::vector<GstTensorMemory> memories;
    for (size_t i = 0; i < count; ++i) memories.push_back({bytes.data() + 4 * i, 4});
    void* priv = nullptr;
    ASSERT_TRUE(found->init(&priv));
    GstBuffer* out = gst_buffer_new();
    for (int frame = 0; frame < 2; ++frame) {
      ASSERT_EQ(found->decode(&priv, &config, memories.data(), out), GST_FLOW_OK) << count;
      std::vector<uint8_t> read(bytes.size());
      EXPECT_EQ(gst_buffer_get_size(out), bytes.size()) << count;
      EXPECT_EQ(gst_buffer_extract(out, 0, read.data(), read.size()), bytes.size()) << count;
      EXPECT_EQ(read, bytes) << count;
      EXPECT_EQ(gst_buffer_n_memory(out), std::min<size_t>(count, 16));
    }
    gst_buffer_unref(out);
    found->exit(&priv);
    gst_tensors_config_free(&config);
  }
}

TEST(BuiltInDecoder, RejectsUnsupportedTensors) {
  const auto* found = nnstreamer_decoder_find("direct_video");
  ASSERT_NE(found, nullptr);
  void* priv = nullptr;
  ASSERT_TRUE(found->init(&priv));
  const auto config = make_config("7:4:2", "float64");
  EXPECT_EQ(found->getOutCaps(&priv, &config), nullptr);
  EXPECT_EQ(found->getOutCaps(&priv, nullptr), nullptr);
  EXPECT_EQ(found->decode(&priv, &config, nullptr, nullptr), GST_FLOW_ERROR);
  found->exit(&priv);
  EXPECT_FALSE(found->init(nullptr));
  EXPECT_EQ(nnstreamer_decoder_find("no_such_decoder"), nullptr);
  EXPECT_EQ(nnstreamer_decoder_find(nullptr), nullptr);
}

TEST(BuiltInDecoder, RejectsCallsWithoutInit) {
  const auto* found = nnstreamer_decoder_find("direct_video");
  ASSERT_NE(found, nullptr);
  const auto config = make_config("3:4:2", "uint8");
  std::vector<uint8_t> pixels(24);
  const GstTensorMemory memory{pixels.data(), pixels.size()};
  GstBuffer* out = gst_buffer_new();
  void* priv = nullptr;
  for (const char* when : {"before init", "after exit"}) {
    EXPECT_EQ(found->getOutCaps(&priv, &config), nullptr) << when;
    EXPECT_FALSE(found->setOption(&priv, 0, "BGR")) << when;
    EXPECT_EQ(found->decode(&priv, &config, &memory, out), GST_FLOW_ERROR) << when;
    found->exit(&priv);
    ASSERT_TRUE(found->init(&priv));
    EXPECT_EQ(found->decode(&priv, &config, &memory, out), GST_FLOW_OK);
    found->exit(&priv);
  }
  EXPECT_EQ(found->getOutCaps(nullptr, &config), nullptr);
  EXPECT_FALSE(found->setOption(nullptr, 0, "BGR"));
  EXPECT_EQ(found->decode(nullptr, &config, &memory, out), GST_FLOW_ERROR);
  found->exit(nullptr);
  gst_buffer_unref(out);
}

// 300 memories are given, but streams have at most 256 tensors.
TEST(BuiltInDecoder, RejectsTooManyTensors) {
  const auto* found = nnstreamer_decoder_find("octet_stream");
  ASSERT_NE(found, nullptr);
  auto config = make_config("4", "uint8");
  uint8_t bytes[4] = {};
  const std::vector<GstTensorMemory> memories(300, {bytes, sizeof bytes});
  void* priv = nullptr;
  ASSERT_TRUE(found->init(&priv));
  GstBuffer* out = gst_buffer_new();
  for (const unsigned count : {257u, 300u, 0xFFFFFFFFu}) {
    config.info.num_tensors = count;
    for (const auto format : {_NNS_TENSOR_FORMAT_STATIC, _NNS_TENSOR_FORMAT_FLEXIBLE}) {
      config.info.format = format;
      EXPECT_EQ(found->decode(&priv, &config, memories.data(), out), GST_FLOW_ERROR) << count;
      EXPECT_EQ(found->getOutCaps(&priv, &config), nullptr) << count;
    }
  }
  config.info.format = _NNS_TENSOR_FORMAT_STATIC;
  config.info.num_tensors = 20;  // without `extra`
  EXPECT_EQ(found->decode(&priv, &config, memories.data(), out), GST_FLOW_ERROR);
  gst_buffer_unref(out);
  found->exit(&priv);
  gst_tensors_config_free(&config);
}

GstBuffer* make_buffer(const std::string& text) {
  GstBuffer* buffer = gst_buffer_new_memdup(text.data(), text.size());
  GST_BUFFER_PTS(buffer) = 7;
  return buffer;
}

TEST(BuiltInConverter, ProducesTensorsFromABuffer) {
  const auto* found = nnstreamer_converter_find("numbers");
  ASSERT_NE(found, nullptr);
  EXPECT_STREQ(found->name, "numbers");
  GstCaps* caps = found->query_caps(nullptr);
  ASSERT_NE(caps, nullptr);
  EXPECT_TRUE(gst_structure_has_name(gst_caps_get_structure(caps, 0), "application/x-numbers"));
  gst_caps_unref(caps);
  caps = gst_caps_from_string("application/x-numbers, mode=(string)three, framerate=(fraction)5/1");
  GstTensorsConfig config;
  ASSERT_TRUE(found->get_out_config(caps, &config));
  EXPECT_EQ(taken(gst_tensors_info_get_dimensions_string(&config.info)), "3:1");
  EXPECT_EQ(config.rate_n, 5);
  gst_caps_unref(caps);
  GstBuffer* in = make_buffer("1 2 3;4 5");
  GstBuffer* out = found->convert(in, &config, nullptr);
  ASSERT_NE(out, nullptr);
  EXPECT_EQ(gst_buffer_n_memory(out), 2u);
  EXPECT_EQ(GST_BUFFER_PTS(out), 7u);
  EXPECT_EQ(taken(gst_tensors_info_get_dimensions_string(&config.info)), "3,2");
  EXPECT_EQ(config.rate_n, 5);
  int32_t numbers[5] = {};
  EXPECT_EQ(gst_buffer_extract(out, 0, numbers, sizeof numbers), sizeof numbers);
  EXPECT_EQ(numbers[4], 5);
  gst_buffer_unref(out);
  gst_buffer_unref(in);
  gst_tensors_config_free(&config);
}

TEST(BuiltInConverter, SaysThatTheScriptIsOpenAlready) {
  const auto* found = nnstreamer_converter_find("python3");
  if (!found) GTEST_SKIP() << "not built";
  const std::string folder =
      std::string(std::getenv("WEIR_MODELS")) + "/../src/modules/converters/python3/";
  const std::string script = folder + "histogram.py";
  void* priv = nullptr;
  ASSERT_EQ(found->open(script.c_str(), &priv), 0);
  void* const before = priv;
  EXPECT_EQ(found->open(script.c_str(), &priv), 1);
  EXPECT_EQ(priv, before);
  EXPECT_LT(found->open((folder + "none.py").c_str(), &priv), 0);
  EXPECT_EQ(priv, nullptr) << "the other one is closed";
  found->close(&priv);
}

TEST(BuiltInConverter, RejectsInvalidCalls) {
  const auto* found = nnstreamer_converter_find("numbers");
  ASSERT_NE(found, nullptr);
  GstTensorsConfig config;
  GstCaps* caps = gst_caps_from_string("application/x-numbers, mode=(string)refused");
  EXPECT_FALSE(found->get_out_config(caps, &config));
  gst_caps_unref(caps);
  GstBuffer* in = make_buffer("failure");
  EXPECT_EQ(found->convert(in, &config, nullptr), nullptr);
  EXPECT_EQ(found->convert(nullptr, &config, nullptr), nullptr);
  gst_buffer_unref(in);
  EXPECT_FALSE(found->get_out_config(nullptr, &config));
  EXPECT_EQ(nnstreamer_converter_find("no_such_converter"), nullptr);
  EXPECT_EQ(nnstreamer_converter_find(nullptr), nullptr);
}

}  // namespace builtin_test

int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
