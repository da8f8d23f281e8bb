// Memory in tensor_converter: sharing, pools and ALLOCATION queries.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/video/video.h>

#include <fstream>
#include <set>

#include "elements/tensor_converter/converter_test_support.hpp"

namespace weir::testing_tensor_converter {
namespace tensor_converter_memory_test {

GstMemory* only_memory(GstBuffer* buffer) {
  EXPECT_EQ(gst_buffer_n_memory(buffer), 1u);
  return gst_buffer_peek_memory(buffer, 0);
}

TEST(TensorConverterMemory, SharesContiguousPlanes) {
  const auto h = harness("", video("RGBP", 8, 2));
  GstBuffer* in = frame(ramp(48));
  const GstMemory* before = only_memory(in);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  EXPECT_EQ(only_memory(out.get()), before);
  EXPECT_EQ(stat(h, "bytes-copied"), 0u);
}

TEST(TensorConverterMemory, CopiesSeparatePlanes) {
  const auto h = harness("", video("RGBP", 8, 2));
  GstBuffer* in = frame(ramp(64));
  gsize offset[] = {0, 24, 48};
  gint stride[] = {8, 8, 8};
  gst_buffer_add_video_meta_full(in, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_RGBP, 8, 2, 3,
                                 offset, stride);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  Bytes expected;
  for (const size_t plane : offset)
    for (size_t i = 0; i < 16; ++i) expected.push_back(static_cast<uint8_t>(plane + i));
  EXPECT_EQ(content(out.get()), expected);
  EXPECT_EQ(stat(h, "bytes-copied"), 48u);
}

TEST(TensorConverterMemory, CopiesPartsOfMemoryThatMayNotBeShared) {
  auto h = harness("input-dim=2:1,3:1 input-type=uint8,uint16",
                   "application/octet-stream,framerate=10/1");
  GstBuffer* in = frame(ramp(8));
  GST_MINI_OBJECT_FLAG_SET(gst_buffer_peek_memory(in, 0), GST_MEMORY_FLAG_NO_SHARE);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  ASSERT_EQ(gst_buffer_n_memory(out.get()), 2u);
  EXPECT_EQ(content(out.get()), ramp(8));
  EXPECT_EQ(stat(h, "bytes-copied"), 8u);
}

TEST(TensorConverterMemory, TakesCopiesFromAPoolAndKeepsMetadata) {
  const auto h = harness("", video("RGB", 5, 2));  // rows of 15 bytes with a stride of 16
  const auto clock = Ref<GstCaps>::adopt(gst_caps_new_empty_simple("timestamp/x-ntp"));
  std::set<const GstMemory*> memories;
  for (uint64_t i = 0; i < 50; ++i) {
    GstBuffer* in = frame(ramp(32));
    gst_buffer_add_reference_timestamp_meta(in, clock.get(), i, GST_CLOCK_TIME_NONE);
    const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
    memories.insert(only_memory(out.get()));
    const auto* meta = gst_buffer_get_reference_timestamp_meta(out.get(), clock.get());
    ASSERT_NE(meta, nullptr);
    EXPECT_EQ(meta->timestamp, i);
  }
  EXPECT_LE(memories.size(), 2u);
  EXPECT_EQ(stat(h, "bytes-copied"), 50u * 30);
}

TEST(TensorConverterMemory, WritesHeadersAgainIntoPooledFrames) {
  const auto h = make_harness("tensor_converter");
  gst_harness_set_sink_caps_str(h.get(), "other/tensors,format=flexible,framerate=10/1");
  gst_harness_set_src_caps_str(h.get(), video("GRAY8", 4, 2).c_str());
  std::set<const GstMemory*> memories;
  Bytes first;
  for (int i = 0; i < 20; ++i) {
    const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(ramp(8))));
    memories.insert(only_memory(out.get()));
    if (first.empty()) first = content(out.get());
    EXPECT_EQ(content(out.get()), first);
    gst_buffer_memset(out.get(), 0, 0xEE, 128);  // as a downstream element may
  }
  EXPECT_LE(memories.size(), 2u);
  EXPECT_EQ(first.size(), 128u + 8);
  EXPECT_EQ(stat(h, "bytes-copied"), 20u * 8);
}

// 5x2 pixels of 3 bytes: rows of 15 with a stride of 16. The transform adds 1 to each byte.
TEST(TensorConverterMemory, HandsPaddedRowsToATransformWithoutACopy) {
  const auto h = make_harness("tensor_converter ! tensor_transform mode=arithmetic option=add:1",
                              video("RGB", 5, 2));
  Bytes expected;
  for (const int i : {0, 16})
    for (int k = 0; k < 15; ++k) expected.push_back(static_cast<uint8_t>(i + k + 1));
  for (int i = 0; i < 20; ++i) {
    const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(ramp(32))));
    EXPECT_EQ(content(out.get()), expected);
  }
  EXPECT_EQ(stat(h, "bytes-copied"), 0u);
  EXPECT_EQ(test::stat(h, "tensor_transform", "fused-frames"), 20u);
}

TEST(TensorConverterMemory, PassesSeparatePlanesToATransformWithoutACopy) {
  const auto h = make_harness("tensor_converter ! tensor_transform mode=typecast option=int16",
                              video("RGBP", 8, 2));
  const gint stride[] = {12, 12, 12};
  gsize offset[] = {4, 44, 84};
  for (const bool even : {true, false}) {
    if (!even) offset[2] = 90;  // no stride fits that offset
    GstBuffer* in = frame(ramp(128));
    gst_buffer_add_video_meta_full(in, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_RGBP, 8, 2, 3,
                                   offset, const_cast<gint*>(stride));
    const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
    std::vector<int16_t> expected;
    for (const gsize plane : offset)
      for (const gsize row : {0, 12})
        for (gsize x = 0; x < 8; ++x) expected.push_back(static_cast<int16_t>(plane + row + x));
    EXPECT_EQ(values<int16_t>(out.get()), expected);
    EXPECT_EQ(stat(h, "bytes-copied"), even ? 0u : 48u);
  }
}

TEST(TensorConverterMemory, CopiesRowsForThoseWhoReadThemInAnotherOrder) {
  const auto h = make_harness("tensor_converter ! tensor_transform mode=transpose option=1:0:2:3",
                              video("RGB", 5, 2));
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(ramp(32))));
  EXPECT_EQ(content(out.get())[1], 3);
  EXPECT_EQ(stat(h, "bytes-copied"), 30u);
}

TEST(TensorConverterMemory, GathersRowsWhenSomebodyLooksAndCountsThat) {
  const auto h =
      make_harness("tensor_converter name=c ! tensor_transform mode=arithmetic option=add:1",
                   video("RGB", 5, 2));
  Bytes seen;
  const auto element = find_element(h, "tensor_converter");
  const auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "src"));
  gst_pad_add_probe(
      pad.get(), GST_PAD_PROBE_TYPE_BUFFER,
      [](GstPad*, GstPadProbeInfo* info, gpointer data) {
        *static_cast<Bytes*>(data) = content(GST_PAD_PROBE_INFO_BUFFER(info));
        return GST_PAD_PROBE_OK;
      },
      &seen, nullptr);
  for (int i = 0; i < 3; ++i) {
    const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(ramp(32))));
    ASSERT_EQ(seen.size(), 30u);
    EXPECT_EQ(seen[15], 16);
    EXPECT_EQ(content(out.get())[15], 17);
  }
  EXPECT_EQ(stat(h, "bytes-copied"), 90u);
}

TEST(TensorConverterMemory, RefusesStridesBeyondTheBufferBeforeATransformToo) {
  const auto h = make_harness("tensor_converter ! tensor_transform mode=arithmetic option=add:1",
                              video("RGB", 5, 2));
  GstBuffer* in = frame(ramp(32));
  gsize offset[] = {0};
  gint stride[] = {100};
  gst_buffer_add_video_meta_full(in, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_RGB, 5, 2, 1,
                                 offset, stride);
  EXPECT_SAYS(get_error(h, in), "WEIR-2004: a video buffer is smaller than its caps require");
}

TEST(TensorConverterMemory, ProposesTheEnginesRequirementsAndMeetsThem) {
  const std::string model = testing::TempDir() + "weir-memory-model.bin";
  std::ofstream(model) << "x";
  const Harness h{gst_harness_new_parse(
      ("tensor_converter ! tensor_transform mode=dimchg option=0:2 ! tensor_transform "
       "mode=typecast option=float32 ! tensor_filter name=filter framework=fake "
       "custom=alignment:4096,padding:9000 model=" +
       model)
          .c_str())};
  const std::string caps_text = video("GRAY8", 4, 3);
  gst_harness_set_src_caps_str(h.get(), caps_text.c_str());
  const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(caps_text.c_str()));
  const Unique<GstQuery, gst_query_unref> query(gst_query_new_allocation(caps.get(), TRUE));
  ASSERT_TRUE(gst_pad_peer_query(h->srcpad, query.get()));
  GstAllocationParams params;
  ASSERT_EQ(gst_query_get_n_allocation_params(query.get()), 1u);
  gst_query_parse_nth_allocation_param(query.get(), 0, nullptr, &params);
  EXPECT_EQ(params.align, 4095u);
  EXPECT_EQ(params.padding, 9000u);
  EXPECT_TRUE(gst_query_find_allocation_meta(query.get(), GST_VIDEO_META_API_TYPE, nullptr));
  ASSERT_EQ(gst_query_get_n_allocation_pools(query.get()), 1u);

  // A frame from the proposed pool, as a decoder would use it.
  GstBufferPool* raw = nullptr;
  gst_query_parse_nth_allocation_pool(query.get(), 0, &raw, nullptr, nullptr, nullptr);
  const auto pool = Ref<GstBufferPool>::adopt(raw);
  ASSERT_TRUE(gst_buffer_pool_set_active(pool.get(), TRUE));
  GstBuffer* in = nullptr;
  ASSERT_EQ(gst_buffer_pool_acquire_buffer(pool.get(), &in, nullptr), GST_FLOW_OK);
  {
    const Mapped map(in, GST_MAP_WRITE);
    EXPECT_EQ(reinterpret_cast<uintptr_t>(map.bytes().data()) % 4096, 0u);
    for (size_t i = 0; i < 12; ++i) map.bytes()[i] = static_cast<std::byte>(i);
  }
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  ASSERT_TRUE(out);
  const Mapped map(out.get(), GST_MAP_READ);
  for (size_t i = 0; i < 12; ++i) EXPECT_EQ(map.as<const float>()[i], static_cast<float>(i + 1));
  EXPECT_EQ(test::stat(h, "tensor_filter", "bytes-copied"), 0u)
      << "the transform's memory is as the engine wants it";
  gst_buffer_pool_set_active(pool.get(), FALSE);
}

TEST(TensorConverterMemory, OffersNoPoolWhereRowsHaveGaps) {
  const auto h = harness("", video("RGB", 5, 2));
  const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(video("RGB", 5, 2).c_str()));
  const Unique<GstQuery, gst_query_unref> query(gst_query_new_allocation(caps.get(), TRUE));
  ASSERT_TRUE(gst_pad_peer_query(h->srcpad, query.get()));
  EXPECT_EQ(gst_query_get_n_allocation_pools(query.get()), 0u);
}

TEST(TensorConverterMemory, AnswersNothingBeforeCaps) {
  const Harness h{gst_harness_new_parse("tensor_converter")};
  const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(video("RGB", 4, 2).c_str()));
  const Unique<GstQuery, gst_query_unref> query(gst_query_new_allocation(caps.get(), TRUE));
  EXPECT_FALSE(gst_pad_peer_query(h->srcpad, query.get()));
}

void ask_for_alignment(const Harness& h, gsize alignment) {
  GstAllocationParams params;
  gst_allocation_params_init(&params);
  params.align = alignment - 1;
  gst_harness_set_propose_allocator(h.get(), nullptr, &params);
}
// The alignment of a frame whose rows must be copied.
gsize alignment_of_next(const Harness& h, int width) {
  gst_harness_set_src_caps_str(h.get(), video("GRAY8", width, 2).c_str());
  gst_harness_push(h.get(), frame(ramp(static_cast<size_t>(width + 3) / 4 * 8)));
  const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  return only_memory(out.get())->align + 1;
}

TEST(TensorConverterMemory, QueriesTheSameThreadAgainWhenCapsChange) {
  const auto h = make_harness("tensor_converter");
  ask_for_alignment(h, 4096);
  EXPECT_EQ(alignment_of_next(h, 5), 4096u);
  ask_for_alignment(h, 1024);
  EXPECT_EQ(alignment_of_next(h, 6), 1024u);
}

TEST(TensorConverterMemory, KeepsTheQueryResultOfAQueueWhileFramesFlow) {
  const auto h = make_harness("tensor_converter ! identity ! queue");
  ask_for_alignment(h, 4096);
  EXPECT_EQ(alignment_of_next(h, 5), 4096u);
  ask_for_alignment(h, 1024);
  EXPECT_EQ(alignment_of_next(h, 6), 4096u);
}

// Frames within one buffer are not copied; others are copied once.
TEST(TensorConverterMemory, CountsWhatIsGatheredFromSeveralBuffers) {
  for (const auto& [bytes, copied] : {std::pair{12u, 0u}, {36u, 0u}, {18u, 12u}, {6u, 36u}}) {
    const auto h = harness("input-dim=2 input-type=uint8 frames-per-tensor=6",
                           "application/octet-stream,framerate=30/1");
    for (size_t sent = 0; sent < 36; sent += bytes)
      ASSERT_EQ(gst_harness_push(h.get(), frame(ramp(bytes))), GST_FLOW_OK);
    ASSERT_EQ(gst_harness_buffers_received(h.get()), 3u);
    EXPECT_EQ(stat(h, "bytes-copied"), copied) << "from buffers of " << bytes;
  }
}

}  // namespace tensor_converter_memory_test
}  // namespace weir::testing_tensor_converter
