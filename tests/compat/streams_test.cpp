// Tests of the functions of libnnstreamer.so for caps, headers and buffers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <cstring>
#include <numeric>
#include <string>
#include <vector>

#include "nnstreamer_plugin_api.h"

namespace streams_test {

std::string taken(GstCaps* caps) {
  if (!caps) return "(none)";
  gchar* text = gst_caps_to_string(caps);
  const std::string out = text;
  g_free(text);
  gst_caps_unref(caps);
  return out;
}

class Stream {
 public:
  explicit Stream(const char* caps, bool validate = true) {
    GstCaps* read = gst_caps_from_string(caps);
    good = gst_tensors_config_from_caps(&config, read, validate);
    gst_caps_unref(read);
  }
  ~Stream() { gst_tensors_config_free(&config); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  GstTensorsConfig config;
  bool good;
};

constexpr char kTwo[] =
    "other/tensors, format=(string)static, num_tensors=(int)2, "
    "dimensions=(string)\"3:4\\,5\", types=(string)\"uint8\\,float32\", framerate=(fraction)30/1";

TEST(CompatCaps, RoundTripThroughAConfiguration) {
  Stream two(kTwo);
  ASSERT_TRUE(two.good);
  EXPECT_EQ(two.config.info.num_tensors, 2u);
  EXPECT_EQ(two.config.info.info[1].type, _NNS_FLOAT32);
  EXPECT_EQ(two.config.rate_n, 30);
  EXPECT_EQ(taken(gst_tensors_caps_from_config(&two.config)), kTwo);
  Stream one("other/tensor, dimension=(string)3:4, type=(string)int8, framerate=(fraction)0/1");
  ASSERT_TRUE(one.good);
  EXPECT_EQ(taken(gst_tensor_caps_from_config(&one.config)),
            "other/tensor, dimension=(string)3:4, type=(string)int8, framerate=(fraction)0/1");
  Stream flexible("other/tensors, format=(string)flexible, framerate=(fraction)15/1");
  ASSERT_TRUE(flexible.good);
  EXPECT_EQ(taken(gst_tensors_caps_from_config(&flexible.config)),
            "other/tensors, format=(string)flexible, framerate=(fraction)15/1");
}

TEST(CompatCaps, AreRejectedWithValidationOnly) {
  for (const char* bad : {"video/x-raw", "other/tensors, format=static, framerate=30/1",
                          "other/tensor, dimension=(string)3:0:4, type=uint8, framerate=30/1",
                          "other/tensor, dimension=(string){3, 4}, type=uint8, framerate=30/1"})
    EXPECT_FALSE(Stream(bad).good) << bad;
  Stream open("other/tensors, format=static, num_tensors=1", false);
  EXPECT_TRUE(open.good);
  EXPECT_EQ(open.config.rate_d, -1);
  EXPECT_EQ(gst_tensors_caps_from_config(nullptr), nullptr);
}

TEST(CompatCaps, OfAPadAreThoseThatItsPeerAccepts) {
  Stream one("other/tensor, dimension=(string)3:4, type=(string)int8, framerate=(fraction)30/1");
  GstPad* source = gst_pad_new("src", GST_PAD_SRC);
  EXPECT_EQ(taken(gst_tensor_pad_caps_from_config(source, &one.config)),
            "other/tensors, format=(string)static, num_tensors=(int)1, "
            "dimensions=(string)3:4, types=(string)int8, framerate=(fraction)30/1");
  EXPECT_EQ(gst_tensor_pad_caps_from_config(nullptr, &one.config), nullptr);
  gst_object_unref(source);
}

TEST(CompatMeta, HeaderHasTheDocumentedFields) {
  GstTensorMetaInfo meta;
  gst_tensor_meta_info_init(&meta);
  EXPECT_FALSE(gst_tensor_meta_info_validate(&meta));
  uint32_t words[32];
  std::fill(std::begin(words), std::end(words), 0xAAAAAAAAu);
  EXPECT_FALSE(gst_tensor_meta_info_update_header(&meta, words));
  EXPECT_EQ(words[0], 0xAAAAAAAAu);
  GstTensorInfo info;
  gst_tensor_info_init(&info);
  info.type = _NNS_INT16;
  gst_tensor_parse_dimension("5:7", info.dimension);
  ASSERT_TRUE(gst_tensor_info_convert_to_meta(&info, &meta));
  meta.format = _NNS_TENSOR_FORMAT_FLEXIBLE;
  EXPECT_EQ(gst_tensor_meta_info_get_header_size(&meta), 128u);
  EXPECT_EQ(gst_tensor_meta_info_get_data_size(&meta), 70u);
  ASSERT_TRUE(gst_tensor_meta_info_update_header(&meta, words));
  uint32_t wanted[32] = {0xfeedcced, 0xDE001000, 2, 5, 7};
  wanted[19] = 1, wanted[20] = 4;
  EXPECT_EQ(std::memcmp(words, wanted, sizeof words), 0);
  words[21] = 3, words[19] = 2;  // sparse
  ASSERT_TRUE(gst_tensor_meta_info_parse_header(&meta, words));
  EXPECT_EQ(gst_tensor_meta_info_get_data_size(&meta), 3u * (2 + 4));
  guint major = 0, minor = 9;
  ASSERT_TRUE(gst_tensor_meta_info_get_version(&meta, &major, &minor));
  EXPECT_EQ(major, 1u);
  EXPECT_EQ(minor, 0u);
  GstTensorInfo back;
  ASSERT_TRUE(gst_tensor_meta_info_convert(&meta, &back));
  EXPECT_TRUE(gst_tensor_info_is_equal(&back, &info));
  words[0] = 1;
  EXPECT_FALSE(gst_tensor_meta_info_parse_header(&meta, words));
}

GstMemory* make_memory(size_t index, size_t bytes) {
  auto* data = static_cast<guint8*>(g_malloc(bytes));
  std::memset(data, static_cast<int>(index), bytes);
  return gst_memory_new_wrapped(GST_MEMORY_FLAG_READONLY, data, bytes, 0, bytes, data, g_free);
}

// Tensor i has i + 1 bytes of value i.
GstBuffer* buffer_with(size_t count) {
  GstBuffer* buffer = gst_buffer_new();
  for (size_t i = 0; i < count; ++i) {
    GstTensorInfo info;
    gst_tensor_info_init(&info);
    info.type = _NNS_UINT8;
    info.dimension[0] = static_cast<uint32_t>(i + 1);
    EXPECT_TRUE(gst_tensor_buffer_append_memory(buffer, make_memory(i, i + 1), &info)) << i;
  }
  return buffer;
}

TEST(CompatBuffer, HoldsUpTo256Tensors) {
  for (const size_t count : {1u, 15u, 16u, 17u, 40u, 256u}) {
    GstBuffer* buffer = buffer_with(count);
    EXPECT_EQ(gst_buffer_n_memory(buffer), std::min<size_t>(count, 16));
    ASSERT_EQ(gst_tensor_buffer_get_count(buffer), count);
    for (size_t i = 0; i < count; ++i) {
      GstMemory* memory = gst_tensor_buffer_get_nth_memory(buffer, static_cast<guint>(i));
      ASSERT_NE(memory, nullptr) << i;
      GstMapInfo map;
      ASSERT_TRUE(gst_memory_map(memory, &map, GST_MAP_READ));
      EXPECT_EQ(std::vector<guint8>(map.data, map.data + map.size),
                std::vector<guint8>(i + 1, static_cast<guint8>(i)));
      gst_memory_unmap(memory, &map);
      gst_memory_unref(memory);
    }
    EXPECT_EQ(gst_tensor_buffer_get_nth_memory(buffer, static_cast<guint>(count)), nullptr);
    gst_buffer_unref(buffer);
  }
}

TEST(CompatBuffer, RejectsThe257thTensor) {
  GstBuffer* buffer = buffer_with(256);
  GstTensorInfo info;
  gst_tensor_info_init(&info);
  EXPECT_FALSE(gst_tensor_buffer_append_memory(buffer, make_memory(0, 1), &info));
  EXPECT_EQ(gst_tensor_buffer_get_count(buffer), 256u);
  EXPECT_FALSE(gst_tensor_buffer_append_memory(nullptr, make_memory(0, 1), &info));
  EXPECT_EQ(gst_tensor_buffer_get_nth_memory(nullptr, 0), nullptr);
  gst_buffer_unref(buffer);
}

}  // namespace streams_test

int main(int argc, char** argv) {
  gst_init(nullptr, nullptr);
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
