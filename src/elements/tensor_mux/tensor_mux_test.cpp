// tensor_mux: its output for static and flexible inputs, and its errors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/packed_tensors.hpp"
#include "core/tensor/tensor_header.hpp"
#include "elements/tensor_mux/many_inputs_test_support.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"
#include "gstcpp/element/result_events.hpp"

namespace weir::test {
namespace tensor_mux_test {

constexpr char kFlexible[] = "other/tensors,format=flexible,framerate=30/1";

Bytes filled(size_t size, uint8_t value) {
  return Bytes(size, value);
}
Bytes chunk(const Bytes& payload) {
  TensorHeader header;
  header.spec = {ElementType::UInt8, Shape{static_cast<uint32_t>(payload.size())}, ""};
  Bytes out(kTensorHeaderBytes);
  write_tensor_header(header, std::span<std::byte, kTensorHeaderBytes>(
                                  reinterpret_cast<std::byte*>(out.data()), kTensorHeaderBytes));
  out.insert(out.end(), payload.begin(), payload.end());
  return out;
}
std::span<const std::byte> to_span(const Bytes& bytes) {
  return {reinterpret_cast<const std::byte*>(bytes.data()), bytes.size()};
}

TEST(TensorMux, CombinesStaticTensorsWithoutACopy) {
  ManyInputs mux("tensor_mux");
  mux.add("other/tensor,dimension=(string)3:2,type=(string)uint8,framerate=(fraction)30/1");
  mux.add(
      "other/tensors,format=static,num_tensors=2,dimensions=(string)\"2,1\","
      "types=(string)\"uint8,int16\",framerate=(fraction)15/2");
  mux.play();
  auto first = mux.push_later(0, filled(6, 7), 100);
  EXPECT_EQ(mux.push(1, make_buffer({filled(2, 8), filled(2, 9)}, 100)), GST_FLOW_OK);
  EXPECT_EQ(first.get(), GST_FLOW_OK);
  ASSERT_EQ(mux.buffers().size(), 1u);
  EXPECT_EQ(read_memories(mux.buffers()[0].get()),
            (std::vector<Bytes>{filled(6, 7), filled(2, 8), filled(2, 9)}));
  EXPECT_EQ(mux.caps(),
            "other/tensors, format=(string)static, num_tensors=(int)3, "
            "dimensions=(string)\"3:2\\,2\\,1\", types=(string)\"uint8\\,uint8\\,int16\", "
            "framerate=(fraction)15/1");
  EXPECT_EQ(mux.stat("bytes-copied"), 0u);
  EXPECT_EQ(mux.stat("consumed"), 2u);
  EXPECT_EQ(mux.stat("pushed"), 1u);
}

TEST(TensorMux, SharesTheMemoriesOfItsInputs) {
  ManyInputs mux("tensor_mux");
  mux.add(caps_of_bytes(4).c_str());
  mux.play();
  auto in = make_buffer({filled(4, 1)}, 0);
  GstMemory* memory = gst_buffer_peek_memory(in.get(), 0);
  EXPECT_EQ(mux.push(0, in), GST_FLOW_OK);
  EXPECT_EQ(gst_buffer_peek_memory(mux.buffers()[0].get(), 0), memory);
}

TEST(TensorMux, StartsItsOwnStreamInOrder) {
  ManyInputs mux("tensor_mux");
  mux.add(caps_of_bytes(1).c_str());
  mux.play();
  auto in = make_buffer({filled(1, 1)}, 500);
  GST_BUFFER_DTS(in.get()) = 400;
  GST_BUFFER_DURATION(in.get()) = 33;
  mux.push(0, in);
  mux.event(0, gst_event_new_eos());
  EXPECT_EQ(mux.event_names(),
            (std::vector<std::string>{"stream-start", "caps", "segment", "eos"}));
  GstSegment segment;
  gst_event_copy_segment(mux.events(GST_EVENT_SEGMENT)[0].get(), &segment);
  EXPECT_EQ(segment.format, GST_FORMAT_TIME);
  EXPECT_EQ(segment.start, 400u);
  EXPECT_EQ(gst_segment_to_running_time(&segment, GST_FORMAT_TIME, 500), 500u);
  EXPECT_EQ(GST_BUFFER_DTS(mux.buffers()[0].get()), 400u);
  EXPECT_EQ(GST_BUFFER_DURATION(mux.buffers()[0].get()), 33u);
}

TEST(TensorMux, EndsWithoutAFrame) {
  ManyInputs mux("tensor_mux");
  mux.add(caps_of_bytes(1).c_str());
  mux.play();
  mux.event(0, gst_event_new_eos());
  EXPECT_EQ(mux.event_names(), (std::vector<std::string>{"stream-start", "segment", "eos"}));
}

TEST(TensorMux, CopiesTimeAndMetadataOfTheDecidingFrame) {
  ManyInputs mux("tensor_mux sync-mode=nosync");
  mux.add(caps_of_bytes(1).c_str());
  mux.add(caps_of_bytes(1).c_str());
  mux.play();
  auto early = make_buffer({filled(1, 1)}, 10), late = make_buffer({filled(1, 2)}, 20);
  GST_BUFFER_DURATION(early.get()) = 1;
  GST_BUFFER_DURATION(late.get()) = 2;
  GST_BUFFER_OFFSET(late.get()) = 77;
  gst::set_source_maps(late.get(), {picture_as_it_is(64, 48, false)});
  auto first = mux.push_later(0, early);
  mux.push(1, late);
  first.get();
  GstBuffer* out = mux.buffers().at(0).get();
  EXPECT_EQ(GST_BUFFER_PTS(out), 20u);
  EXPECT_EQ(GST_BUFFER_DURATION(out), 2u);
  ASSERT_EQ(gst::source_maps(out).size(), 1u);
  EXPECT_EQ(gst::source_maps(out)[0].source_width, 64u);
}

TEST(TensorMux, KeepsTheSourceMapOfEachTensor) {
  ManyInputs mux("tensor_mux");
  mux.add(caps_of_bytes(1).c_str());
  mux.add(caps_of_bytes(1).c_str());
  mux.play();
  auto a = make_buffer({filled(1, 1)}, 0), b = make_buffer({filled(1, 2)}, 0);
  gst::set_source_maps(a.get(), {picture_as_it_is(64, 48, false)});
  gst::set_source_maps(b.get(), {picture_as_it_is(32, 24, true)});
  auto first = mux.push_later(0, a);
  mux.push(1, b);
  first.get();
  const auto maps = gst::source_maps(mux.buffers().at(0).get());
  ASSERT_EQ(maps.size(), 2u);
  EXPECT_EQ(maps[0].source_width, 64u);
  EXPECT_EQ(maps[1].source_width, 32u);
}

TEST(TensorMux, NumbersItsPadsInTheOrderOfRequests) {
  ManyInputs mux("tensor_mux");
  mux.add(caps_of_bytes(1).c_str(), "sink_1");
  mux.add(caps_of_bytes(2).c_str(), "sink_0");
  mux.add(caps_of_bytes(3).c_str());
  EXPECT_STREQ(GST_PAD_NAME(mux.get_sink(0)), "sink_1");
  EXPECT_STREQ(GST_PAD_NAME(mux.get_sink(1)), "sink_0");
  EXPECT_STREQ(GST_PAD_NAME(mux.get_sink(2)), "sink_2");
  mux.play();
  mux.push_all({filled(1, 1), filled(2, 2), filled(3, 3)}, 0);
  EXPECT_EQ(read_memories(mux.buffers()[0].get()),
            (std::vector<Bytes>{filled(1, 1), filled(2, 2), filled(3, 3)}));
}

TEST(TensorMux, PacksTensorsBeyondTheSixteenth) {
  for (const size_t count : {16u, 17u, 20u}) {
    ManyInputs mux("tensor_mux");
    std::vector<Bytes> frames;
    for (size_t i = 0; i < count; ++i) {
      mux.add(caps_of_bytes(i + 1).c_str());
      frames.push_back(filled(i + 1, static_cast<uint8_t>(i)));
    }
    mux.play();
    mux.push_all(frames, 5);
    const auto out = read_memories(mux.buffers().at(0).get());
    ASSERT_EQ(out.size(), 16u);
    for (size_t i = 0; i < 15; ++i) EXPECT_EQ(out[i], frames[i]);
    if (count == 16) {
      EXPECT_EQ(out[15], frames[15]);
      EXPECT_EQ(mux.stat("bytes-copied"), 0u);
      continue;
    }
    const auto ranges = read_packed_tensors(to_span(out[15]), Format::Static);
    ASSERT_TRUE(ranges);
    ASSERT_EQ(ranges->size(), count - 15);
    uint64_t copied = 0;
    for (size_t i = 15; i < count; ++i) {
      const auto at = out[15].begin() + static_cast<std::ptrdiff_t>((*ranges)[i - 15].offset);
      EXPECT_EQ(Bytes(at, at + static_cast<std::ptrdiff_t>(i + 1)), frames[i]);
      copied += i + 1;
    }
    EXPECT_EQ(mux.stat("bytes-copied"), copied);
  }
}

TEST(TensorMux, UnpacksPackedFrames) {
  ManyInputs outer("tensor_mux"), inner("tensor_mux");
  std::vector<Bytes> frames;
  for (size_t i = 0; i < 18; ++i) {
    inner.add(caps_of_bytes(2).c_str());
    frames.push_back(filled(2, static_cast<uint8_t>(i)));
  }
  inner.play();
  inner.push_all(frames, 5);
  outer.add(caps_of_bytes(3).c_str());
  outer.add(inner.caps().c_str());
  outer.play();
  auto first = outer.push_later(0, filled(3, 99), 5);
  EXPECT_EQ(outer.push(1, inner.buffers().at(0)), GST_FLOW_OK);
  first.get();
  const auto out = read_memories(outer.buffers().at(0).get());
  ASSERT_EQ(out.size(), 16u);
  EXPECT_EQ(out[0], filled(3, 99));
  EXPECT_EQ(out[1], frames[0]);
  const auto ranges = read_packed_tensors(to_span(out[15]), Format::Static);
  ASSERT_TRUE(ranges);
  ASSERT_EQ(ranges->size(), 4u);
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(out[15][(*ranges)[i].offset], 14 + i);
}

TEST(TensorMux, OneFlexibleInputMakesTheOutputFlexible) {
  ManyInputs mux("tensor_mux");
  mux.add(caps_of_bytes(4).c_str());
  mux.add(kFlexible);
  mux.play();
  auto first = mux.push_later(0, filled(4, 1), 0);
  EXPECT_EQ(mux.push(1, chunk(filled(3, 2)), 0), GST_FLOW_OK);
  first.get();
  EXPECT_EQ(read_memories(mux.buffers().at(0).get()),
            (std::vector<Bytes>{chunk(filled(4, 1)), chunk(filled(3, 2))}));
  EXPECT_SAYS(mux.caps(), "format=(string)flexible");
  EXPECT_EQ(mux.stat("bytes-copied"), 4u);
}

TEST(TensorMux, AddsHeadersForAPeerThatNeedsThem) {
  ManyInputs mux("tensor_mux", "other/tensors,format=flexible,framerate=[0/1,2147483647/1]");
  mux.add(caps_of_bytes(4).c_str());
  mux.play();
  EXPECT_EQ(mux.push(0, filled(4, 1), 0), GST_FLOW_OK);
  EXPECT_EQ(read_memories(mux.buffers().at(0).get()), (std::vector<Bytes>{chunk(filled(4, 1))}));
}

TEST(TensorMux, SplitsAMemoryOfSeveralChunks) {
  ManyInputs mux("tensor_mux");
  mux.add(kFlexible);
  mux.play();
  Bytes both = chunk(filled(3, 1));
  const Bytes second = chunk(filled(5, 2));
  both.insert(both.end(), second.begin(), second.end());
  EXPECT_EQ(mux.push(0, both, 0), GST_FLOW_OK);
  EXPECT_EQ(read_memories(mux.buffers().at(0).get()),
            (std::vector<Bytes>{chunk(filled(3, 1)), second}));
  EXPECT_EQ(mux.stat("bytes-copied"), 0u);
}

TEST(TensorMux, SplitsOneMemoryOfSeveralStaticTensors) {
  ManyInputs mux("tensor_mux");
  mux.add(
      "other/tensors,format=static,num_tensors=2,dimensions=(string)\"2,1\","
      "types=(string)\"uint8,uint8\",framerate=(fraction)30/1");
  mux.play();
  EXPECT_EQ(mux.push(0, {1, 2, 3}, 0), GST_FLOW_OK);
  EXPECT_EQ(read_memories(mux.buffers().at(0).get()), (std::vector<Bytes>{{1, 2}, {3}}));
}

TEST(TensorMux, CopiesPartsOfMemoryThatCannotBeShared) {
  ManyInputs mux("tensor_mux");
  mux.add(
      "other/tensors,format=static,num_tensors=2,dimensions=(string)\"2,3\","
      "types=(string)\"uint8,uint8\",framerate=(fraction)30/1");
  mux.play();
  auto in = make_buffer({{1, 2, 3, 4, 5}}, 0);
  GST_MINI_OBJECT_FLAG_SET(gst_buffer_peek_memory(in.get(), 0), GST_MEMORY_FLAG_NO_SHARE);
  EXPECT_EQ(mux.push(0, std::move(in)), GST_FLOW_OK);
  EXPECT_EQ(read_memories(mux.buffers().at(0).get()), (std::vector<Bytes>{{1, 2}, {3, 4, 5}}));
  EXPECT_EQ(mux.stat("bytes-copied"), 5u);
}

TEST(TensorMux, FollowsChangedCaps) {
  ManyInputs mux("tensor_mux");
  mux.add(caps_of_bytes(1).c_str());
  mux.add(caps_of_bytes(1).c_str());
  mux.play();
  mux.push_all({{1}, {2}}, 0);
  mux.set_caps(1, caps_of_bytes(2).c_str());
  mux.push_all({{3}, {4, 5}}, 10);
  EXPECT_EQ(read_memories(mux.buffers().at(1).get()), (std::vector<Bytes>{{3}, {4, 5}}));
  EXPECT_EQ(mux.events(GST_EVENT_CAPS).size(), 2u);
  EXPECT_SAYS(mux.caps(), "1\\,2");
}

TEST(TensorMux, PadsCanBeAddedAndReleasedWhilePlaying) {
  ManyInputs mux("tensor_mux");
  mux.add(caps_of_bytes(1).c_str());
  mux.play();
  mux.push_all({{1}}, 0);
  mux.add(caps_of_bytes(2).c_str());
  mux.push_all({{2}, {3, 4}}, 10);
  auto waiting = mux.push_later(0, Bytes{5}, 20);
  mux.wait_for_stat("received", 4);
  mux.remove(1);
  EXPECT_EQ(waiting.get(), GST_FLOW_OK);  // taken, and perhaps still being pushed by another thread
  mux.wait_for_stat("pushed", 3);
  const auto out = mux.buffers();
  ASSERT_EQ(out.size(), 3u);
  EXPECT_EQ(read_memories(out[1].get()), (std::vector<Bytes>{{2}, {3, 4}}));
  EXPECT_EQ(read_memories(out[2].get()), (std::vector<Bytes>{{5}}));
  EXPECT_EQ(mux.stat("held"), 0u);
}

// The names of classes of both inputs stay beside each other downstream.
TEST(TensorMux, PassesOnTheLabelsOfAllInputs) {
  ManyInputs mux("tensor_mux");
  mux.add(caps_of_bytes(1).c_str());
  mux.add(caps_of_bytes(1).c_str());
  mux.play();
  const gst::LabelsOfSource cats{"detector", {"cat"}}, reds{"classifier", {"red"}};
  mux.event(0, gst::make_labels_event(cats).release());
  mux.push_all({{1}, {2}}, 0);
  mux.event(1, gst::make_labels_event(reds).release());
  mux.push_all({{3}, {4}}, 10);
  const auto events = mux.events(GST_EVENT_CUSTOM_DOWNSTREAM_STICKY);
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(gst::parse_labels_event(events[0].get()), cats);
  EXPECT_EQ(gst::parse_labels_event(events[1].get()), reds);
}

TEST(TensorMux, RejectsSeeks) {
  ManyInputs mux("tensor_mux");
  mux.add(caps_of_bytes(1).c_str());
  mux.play();
  EXPECT_FALSE(gst_pad_push_event(
      mux.sink(), gst_event_new_seek(1, GST_FORMAT_TIME, GST_SEEK_FLAG_FLUSH, GST_SEEK_TYPE_SET, 0,
                                     GST_SEEK_TYPE_NONE, 0)));
}

TEST(TensorMux, AnUnknownModeIsReportedAndFallsBackToSlowest) {
  ManyInputs mux("tensor_mux sync-mode=slowset");
  mux.add(caps_of_bytes(1).c_str());
  EXPECT_EQ(mux.play(), GST_STATE_CHANGE_SUCCESS);
  const std::string warning = mux.warning();
  EXPECT_SAYS(warning, "WEIR-1005: sync-mode is unknown; slowest is used");
  EXPECT_SAYS(warning, "slowset");
  EXPECT_SAYS(warning, "sync-mode=slowest");
  mux.push_all({{1}}, 0);
  EXPECT_EQ(mux.buffers().size(), 1u);
}

TEST(TensorMux, ADeprecatedModeIsReportedAndAccepted) {
  ManyInputs mux("tensor_mux sync-mode=fastest");
  mux.add(caps_of_bytes(1).c_str());
  EXPECT_EQ(mux.play(), GST_STATE_CHANGE_SUCCESS);
  const std::string warning = mux.warning();
  EXPECT_SAYS(warning,
              "WEIR-1005: sync-mode=fastest is an old name that NNStreamer 2.7 does not know; "
              "it is read as refresh");
  EXPECT_SAYS(warning, "fix: sync-mode=refresh");
  mux.push_all({{1}}, 0);
  EXPECT_EQ(mux.buffers().size(), 1u);
}

TEST(TensorMux, AnUnreadableBaseFailsTheStart) {
  ManyInputs mux("tensor_mux sync-mode=basepad sync-option=0:5ms");
  EXPECT_EQ(mux.play(), GST_STATE_CHANGE_FAILURE);
  const std::string error = mux.error();
  EXPECT_SAYS(error, "WEIR-1001");
  EXPECT_SAYS(error, "    0:5ms\n      ^");
}

TEST(TensorMux, ReportsAMissingBasePad) {
  ManyInputs mux("tensor_mux sync-mode=basepad sync-option=3");
  mux.add(caps_of_bytes(1).c_str());
  mux.play();
  EXPECT_EQ(mux.push(0, Bytes{1}, 0), GST_FLOW_ERROR);
  const std::string error = mux.error();
  EXPECT_SAYS(error, "WEIR-1004");
  EXPECT_SAYS(error, "pad 3 of 1");
}

TEST(TensorMux, RejectsABufferThatIsTooSmall) {
  ManyInputs mux("tensor_mux");
  mux.add(caps_of_bytes(4).c_str());
  mux.play();
  EXPECT_EQ(mux.push(0, Bytes{1, 2, 3}, 0), GST_FLOW_ERROR);
  const std::string error = mux.error();
  EXPECT_SAYS(error, "WEIR-2004");
  EXPECT_SAYS(error, "3 bytes in memory 0 on pad 0");
}

TEST(TensorMux, ReportsCapsThatDownstreamRejects) {
  ManyInputs mux("tensor_mux",
                 "other/tensors,format=static,num_tensors=1,dimensions=(string)3,"
                 "types=(string)uint8,framerate=(fraction)30/1");
  mux.add("other/tensor,dimension=(string)2,type=(string)uint8,framerate=(fraction)30/1");
  mux.play();
  EXPECT_NE(mux.push(0, filled(2, 7), 0), GST_FLOW_OK);
  const std::string error = mux.error();
  EXPECT_SAYS(error, "WEIR-2001: the element downstream of tensor_mux does not accept its output");
  EXPECT_SAYS(error, "first difference: tensor 0: dimension is 2, needed is 3");
}

TEST(TensorMux, RejectsInvalidHeaders) {
  ManyInputs mux("tensor_mux");
  mux.add(kFlexible);
  mux.play();
  Bytes lying = chunk(filled(3, 1));
  lying.pop_back();
  EXPECT_EQ(mux.push(0, lying, 0), GST_FLOW_ERROR);
  EXPECT_SAYS(mux.error(), "WEIR-2005");
  EXPECT_EQ(mux.push(0, chunk(filled(3, 1)), 0), GST_FLOW_ERROR);
}

TEST(TensorMux, RejectsMoreTensorsThanAFrameCanHold) {
  ManyInputs mux("tensor_mux");
  std::string dims = "1", types = "uint8";
  for (int i = 1; i < 200; ++i) dims += ",1", types += ",uint8";
  const std::string caps = "other/tensors,format=static,num_tensors=200,dimensions=(string)\"" +
                           dims + "\",types=(string)\"" + types + "\",framerate=(fraction)30/1";
  mux.add(caps.c_str());
  mux.add(caps.c_str());
  mux.play();
  auto first = mux.push_later(0, Bytes(200), 0);
  auto second = mux.push_later(1, Bytes(200), 0);
  EXPECT_TRUE(first.get() == GST_FLOW_ERROR || second.get() == GST_FLOW_ERROR);
  const std::string error = mux.error();
  EXPECT_SAYS(error, "WEIR-2006");
  EXPECT_SAYS(error, "400");
}

TEST(TensorMux, RejectsIncompleteCaps) {
  ManyInputs mux("tensor_mux");
  mux.add(nullptr);
  mux.play();
  mux.set_caps(0, "other/tensors,format=static,num_tensors=1,framerate=30/1");
  EXPECT_SAYS(mux.error(), "WEIR-2002");
  EXPECT_NE(mux.push(0, Bytes{1}, 0), GST_FLOW_OK);
}

}  // namespace tensor_mux_test
}  // namespace weir::test
