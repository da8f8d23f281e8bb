// Tests of Weir's decoders and converters of messages through NNStreamer's descriptors. Skipped for
// formats that were not built.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <numeric>
#include <string>
#include <vector>

#include "nnstreamer_plugin_api.h"
#include "nnstreamer_plugin_api_converter.h"
#include "nnstreamer_plugin_api_decoder.h"

namespace builtin_message_test {

class BuiltInMessage : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    decoder_ = nnstreamer_decoder_find(GetParam().c_str());
    converter_ = nnstreamer_converter_find(GetParam().c_str());
    ASSERT_EQ(decoder_ == nullptr, converter_ == nullptr);
    if (!decoder_) GTEST_SKIP() << "not built";
  }

  // `data` as a message, and what the converter makes of it. `config` is that of the input.
  std::vector<uint8_t> back_from_message(const GstTensorsConfig& config,
                                         std::vector<uint8_t> data) {
    void* priv = nullptr;
    EXPECT_TRUE(decoder_->init(&priv));
    GstBuffer* message = gst_buffer_new();
    const GstTensorMemory memory{data.data(), data.size()};
    EXPECT_EQ(decoder_->decode(&priv, &config, &memory, message), GST_FLOW_OK);
    decoder_->exit(&priv);
    gst_tensors_config_init(&made_);
    made_.rate_n = 1;
    made_.rate_d = 1;
    GstBuffer* out = converter_->convert(message, &made_, nullptr);
    gst_buffer_unref(message);
    EXPECT_NE(out, nullptr);
    if (!out) return {};
    std::vector<uint8_t> read(gst_buffer_get_size(out));
    gst_buffer_extract(out, 0, read.data(), read.size());
    gst_buffer_unref(out);
    return read;
  }
  void TearDown() override { gst_tensors_config_free(&made_); }

  const GstTensorDecoderDef* decoder_ = nullptr;
  const NNStreamerExternalConverter* converter_ = nullptr;
  GstTensorsConfig made_{};
};

TEST_P(BuiltInMessage, CarriesStaticTensorsAndTheFrameRate) {
  GstTensorsConfig config;
  gst_tensors_config_init(&config);
  config.info.num_tensors = 1;
  config.info.format = _NNS_TENSOR_FORMAT_STATIC;
  config.info.info[0].type = _NNS_UINT8;
  gst_tensor_parse_dimension("3:2", config.info.info[0].dimension);
  config.rate_n = 25;
  config.rate_d = 2;
  const std::vector<uint8_t> data{1, 2, 3, 4, 5, 6};
  EXPECT_EQ(back_from_message(config, data), data);
  EXPECT_EQ(made_.info.format, _NNS_TENSOR_FORMAT_STATIC);
  EXPECT_EQ(made_.info.num_tensors, 1u);
  EXPECT_EQ(made_.info.info[0].type, _NNS_UINT8);
  EXPECT_EQ(made_.info.info[0].dimension[0], 3u);
  EXPECT_EQ(made_.info.info[0].dimension[1], 2u);
  EXPECT_EQ(made_.rate_n, 25);
  EXPECT_EQ(made_.rate_d, 2);
  gst_tensors_config_free(&config);
}

// Programs do not call init() of decoders that keep nothing between frames.
TEST_P(BuiltInMessage, IsMadeWithoutAPrivatePointer) {
  GstTensorsConfig config;
  gst_tensors_config_init(&config);
  config.info.num_tensors = 1;
  config.info.info[0].type = _NNS_UINT8;
  gst_tensor_parse_dimension("4", config.info.info[0].dimension);
  config.rate_n = config.rate_d = 1;
  std::vector<uint8_t> data{1, 2, 3, 4};
  const GstTensorMemory memory{data.data(), data.size()};
  void* priv = nullptr;
  ASSERT_TRUE(decoder_->init(&priv));
  EXPECT_EQ(priv, nullptr);
  std::vector<size_t> sizes;
  for (void** place : {&priv, static_cast<void**>(nullptr)}) {
    GstBuffer* message = gst_buffer_new();
    EXPECT_EQ(decoder_->decode(place, &config, &memory, message), GST_FLOW_OK);
    EXPECT_EQ(gst_buffer_n_memory(message), 1u);
    sizes.push_back(gst_buffer_get_size(message));
    gst_buffer_unref(message);
    GstCaps* caps = decoder_->getOutCaps(place, &config);
    EXPECT_NE(caps, nullptr);
    if (caps) gst_caps_unref(caps);
  }
  EXPECT_EQ(sizes[0], sizes[1]);
  decoder_->exit(&priv);
  gst_tensors_config_free(&config);
}

TEST_P(BuiltInMessage, CarriesFlexibleTensorsWithTheirHeader) {
  GstTensorsConfig config;
  gst_tensors_config_init(&config);
  config.info.num_tensors = 1;
  config.info.format = _NNS_TENSOR_FORMAT_FLEXIBLE;
  config.rate_n = 0;
  config.rate_d = 1;
  GstTensorMetaInfo meta;
  gst_tensor_meta_info_init(&meta);
  meta.type = _NNS_INT16;
  meta.dimension[0] = 3;
  meta.media_type = _NNS_VIDEO;
  std::vector<uint8_t> data(gst_tensor_meta_info_get_header_size(&meta));
  ASSERT_TRUE(gst_tensor_meta_info_update_header(&meta, data.data()));
  for (uint8_t i = 0; i < 6; ++i) data.push_back(i);
  EXPECT_EQ(back_from_message(config, data), data);
  EXPECT_EQ(made_.info.format, _NNS_TENSOR_FORMAT_FLEXIBLE);
  gst_tensors_config_free(&config);
}

TEST_P(BuiltInMessage, HasAPlaceholderBeforeTheFirstBuffer) {
  GstCaps* caps = gst_caps_from_string(
      GetParam() == "flexbuf" ? "other/flexbuf"
                              : ("other/" + GetParam() + "-tensor, framerate=5/1").c_str());
  GstTensorsConfig config;
  ASSERT_TRUE(converter_->get_out_config(caps, &config));
  EXPECT_EQ(config.info.num_tensors, 1u);
  EXPECT_EQ(config.info.info[0].type, _NNS_UINT8);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(config.info.info[0].dimension[i], 1u);
  EXPECT_EQ(config.rate_n, GetParam() == "flexbuf" ? 0 : 5);
  EXPECT_EQ(config.rate_d, 1);
  gst_caps_unref(caps);
  gst_tensors_config_free(&config);
}

TEST_P(BuiltInMessage, RefusesOneThatIsDamaged) {
  GstBuffer* noise = gst_buffer_new_memdup("no message", 10);
  gst_tensors_config_init(&made_);
  EXPECT_EQ(converter_->convert(noise, &made_, nullptr), nullptr);
  gst_buffer_unref(noise);
}

TEST(BuiltInScript, HasAPlaceholderBeforeTheScriptIsOpen) {
  const auto* found = nnstreamer_converter_find("python3");
  if (!found) GTEST_SKIP() << "built without the python3 converter";
  GstCaps* caps = gst_caps_from_string("application/octet-stream, framerate=(fraction)5/1");
  GstTensorsConfig config;
  ASSERT_TRUE(found->get_out_config(caps, &config));
  EXPECT_EQ(config.info.num_tensors, 1u);
  EXPECT_EQ(config.info.info[0].type, _NNS_UINT8);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(config.info.info[0].dimension[i], 1u);
  EXPECT_EQ(config.rate_n, 5);
  EXPECT_EQ(config.rate_d, 1);
  gst_tensors_config_free(&config);
  gst_caps_unref(caps);
  caps = gst_caps_from_string("video/x-raw");
  EXPECT_FALSE(found->get_out_config(caps, &config));
  gst_caps_unref(caps);
  GstBuffer* in = gst_buffer_new_memdup("abc", 3);
  EXPECT_EQ(found->convert(in, &config, nullptr), nullptr) << "no script";
  gst_buffer_unref(in);
}

INSTANTIATE_TEST_SUITE_P(Each, BuiltInMessage, testing::Values("protobuf", "flatbuf", "flexbuf"),
                         [](const auto& info) { return info.param; });

}  // namespace builtin_message_test
