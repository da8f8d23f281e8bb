// Source pads of tensor_demux: creation, events, combined flow returns, and errors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>

#include "elements/tests/branches_test_support.hpp"

namespace weir::test {
namespace pads_test {

constexpr char kTwo[] =
    "other/tensors,format=static,num_tensors=2,dimensions=(string)\"2,1\",types=(string)\"uint8,"
    "uint8\",framerate=30/1";

GstBuffer* two() {
  return make_frame({{1, 2}, {3}});
}
std::vector<std::string> names(std::initializer_list<const char*> list) {
  return {list.begin(), list.end()};
}

TEST(TensorDemuxPads, AreAddedWithTheFirstFrameInOrder) {
  Branches demux("tensor_demux");
  demux.caps(kTwo);
  EXPECT_TRUE(demux.added().empty());
  EXPECT_EQ(demux.no_more_pads_count(), 0);
  ASSERT_EQ(demux.push(two()), GST_FLOW_OK);
  EXPECT_EQ(demux.added(), names({"src_0", "src_1"}));
  EXPECT_EQ(demux.no_more_pads_count(), 1);
  ASSERT_EQ(demux.push(two()), GST_FLOW_OK);
  EXPECT_EQ(demux.added().size(), 2u);
  EXPECT_EQ(demux.no_more_pads_count(), 1);
}

TEST(TensorDemuxPads, GetTheStickyEventsInOrder) {
  Branches demux("tensor_demux");
  demux.caps(kTwo);
  demux.send(gst_event_new_tag(gst_tag_list_new(GST_TAG_TITLE, "a title", nullptr)));
  ASSERT_EQ(demux.push(two()), GST_FLOW_OK);
  for (const char* name : {"src_0", "src_1"}) {
    EXPECT_EQ(demux.branch(name).events, names({"stream-start", "caps", "segment", "tag"}));
    EXPECT_EQ(demux.branch(name).stream_id(), std::string("test/") + name);
  }
  demux.send(gst_event_new_gap(5, 3));
  EXPECT_EQ(demux.branch("src_1").events.back(), "gap");
  demux.send(gst_event_new_eos());
  EXPECT_EQ(demux.branch("src_1").events.back(), "eos");
  EXPECT_EQ(demux.error(), "");
}

TEST(TensorDemuxPads, FollowANewStream) {
  Branches demux("tensor_demux");
  demux.caps(kTwo);
  ASSERT_EQ(demux.push(two()), GST_FLOW_OK);
  demux.send(gst_event_new_stream_start("other"));
  EXPECT_EQ(demux.branch("src_1").stream_id(), "other/src_1");
  demux.caps(kTwo);
  ASSERT_EQ(demux.push(two()), GST_FLOW_OK);
  ASSERT_EQ(demux.push(two()), GST_FLOW_OK);
  EXPECT_EQ(demux.branch("src_1").events,
            names({"stream-start", "caps", "segment", "stream-start", "caps"}));
}

TEST(TensorDemuxPads, OfOneTensorFollowThePeer) {
  Branches demux("tensor_demux", {{"src_0", "other/tensor"}, {"src_1", "other/tensors"}});
  demux.caps(kTwo);
  ASSERT_EQ(demux.push(two()), GST_FLOW_OK);
  EXPECT_SAYS(demux.branch("src_0").caps(),
              "other/tensor, dimension=(string)2, type=(string)uint8");
  EXPECT_SAYS(demux.branch("src_1").caps(), "other/tensors, format=(string)static");
}

TEST(TensorDemuxPads, FollowChangedCaps) {
  Branches demux("tensor_demux");
  demux.caps(kTwo);
  ASSERT_EQ(demux.push(two()), GST_FLOW_OK);
  demux.caps(test::tensors("uint8,uint8", "1,3"));
  ASSERT_EQ(demux.push(make_frame({{1}, {2, 3, 4}})), GST_FLOW_OK);
  EXPECT_SAYS(demux.branch("src_1").caps(), "dimensions=(string)3");
  EXPECT_EQ(demux.branch("src_1").events, names({"stream-start", "caps", "segment", "caps"}));
  demux.caps(test::tensors("uint8,uint8,uint8", "1,3,1"));
  ASSERT_EQ(demux.push(make_frame({{1}, {2, 3, 4}, {5}})), GST_FLOW_OK);
  EXPECT_EQ(demux.added().back(), "src_2");
  EXPECT_EQ(demux.branch("src_1").events.size(), 4u) << "the same caps are not sent again";
  demux.expect_balance();
}

TEST(TensorDemuxPads, AreRemovedAndAddedAgain) {
  Branches demux("tensor_demux");
  demux.caps(kTwo);
  ASSERT_EQ(demux.push(two()), GST_FLOW_OK);
  gst_element_set_state(demux.element(), GST_STATE_READY);
  EXPECT_EQ(demux.element()->numsrcpads, 0u);
  gst_element_set_state(demux.element(), GST_STATE_PLAYING);
  EXPECT_EQ(demux.stat("received"), 0u);
}

TEST(TensorDemuxFlow, UnlinkedPadsAreTolerated) {
  Branches demux("tensor_demux", {}, {"src_0"});
  demux.caps(kTwo);
  ASSERT_EQ(demux.push(two()), GST_FLOW_OK);
  ASSERT_EQ(demux.push(two()), GST_FLOW_OK);
  EXPECT_EQ(demux.branch("src_1").buffers.size(), 2u);
}

TEST(TensorDemuxFlow, IsNotLinkedWhenNoPadIs) {
  Branches demux("tensor_demux", {}, {"src_0", "src_1"});
  demux.caps(kTwo);
  EXPECT_EQ(demux.push(two()), GST_FLOW_NOT_LINKED);
  demux.expect_balance();
}

TEST(TensorDemuxFlow, EndsWhenAllPadsEndAndFailsWhenOneDoes) {
  Branches demux("tensor_demux");
  demux.caps(kTwo);
  ASSERT_EQ(demux.push(two()), GST_FLOW_OK);
  demux.branch("src_0").flow = GST_FLOW_EOS;
  EXPECT_EQ(demux.push(two()), GST_FLOW_OK);
  demux.branch("src_1").flow = GST_FLOW_EOS;
  EXPECT_EQ(demux.push(two()), GST_FLOW_EOS);
  demux.branch("src_1").flow = GST_FLOW_ERROR;
  EXPECT_EQ(demux.push(two()), GST_FLOW_ERROR);
}

TEST(TensorDemuxFlow, ContinuesAfterAFlush) {
  Branches demux("tensor_demux");
  demux.caps(kTwo);
  ASSERT_EQ(demux.push(two()), GST_FLOW_OK);
  demux.branch("src_0").flow = demux.branch("src_1").flow = GST_FLOW_EOS;
  ASSERT_EQ(demux.push(two()), GST_FLOW_EOS);
  EXPECT_TRUE(demux.send(gst_event_new_flush_start()));
  EXPECT_EQ(demux.push(two()), GST_FLOW_FLUSHING);
  EXPECT_TRUE(demux.send(gst_event_new_flush_stop(TRUE)));
  demux.branch("src_0").flow = demux.branch("src_1").flow = GST_FLOW_OK;
  demux.send(test::time_segment());
  EXPECT_EQ(demux.push(two()), GST_FLOW_OK);
  EXPECT_EQ(demux.branch("src_1").events,
            names({"stream-start", "caps", "segment", "flush-start", "flush-stop", "segment"}));
  demux.expect_balance();
}

// A flexible frame of `count` tensors of one byte.
GstBuffer* flexible_frame(size_t count) {
  std::vector<Bytes> memories;
  for (size_t i = 0; i < count; ++i) {
    Bytes memory(128);  // docs/compatibility/types-and-caps.md 1.7
    const auto put = [&](size_t word, uint32_t value) {
      std::memcpy(&memory[4 * word], &value, 4);
    };
    put(0, 0xfeedcced);
    put(1, 0xDE001000);
    put(2, 5);  // uint8
    put(3, 1);
    put(20, 4);  // of a tensor
    memory.push_back(static_cast<uint8_t>(i));
    memories.push_back(std::move(memory));
  }
  return make_frame(memories);
}

TEST(TensorDemuxRejects, AnIndexBeyondTheTensorsOfAStaticStream) {
  for (const char* picks : {"1,7", "7", "0:7", "0,1:7"}) {
    Branches demux(std::string("tensor_demux tensorpick=") + picks);
    demux.caps(kTwo);
    EXPECT_EQ(demux.push(two()), GST_FLOW_ERROR);
    const std::string error = demux.error();
    EXPECT_SAYS(error, "WEIR-1004: tensorpick names a tensor that does not exist");
    EXPECT_SAYS(error, "index 7");
    EXPECT_SAYS(error, "there are 2 tensors");
    EXPECT_TRUE(demux.added().empty()) << "before the first pad is added";
    EXPECT_EQ(demux.stat("dropped-error"), 1u);
    demux.send(gst_event_new_eos());
    EXPECT_EQ(demux.error(), "");
  }
}

// The caps may be those of a placeholder.
TEST(TensorDemuxRejects, NoIndexBeforeTheFirstFrame) {
  Branches demux("tensor_demux tensorpick=1");
  demux.caps(
      "other/"
      "tensors,format=static,num_tensors=1,dimensions=(string)1,types=(string)uint8,framerate=30/"
      "1");
  EXPECT_EQ(demux.error(), "");
  demux.caps(kTwo);
  EXPECT_EQ(demux.push(two()), GST_FLOW_OK);
  EXPECT_EQ(content(demux.take("src_0").get(), 0), Bytes{3});
}

TEST(TensorDemuxRejects, AnIndexBeyondTheTensorsOfAFlexibleFrameWithAWarning) {
  Branches demux("tensor_demux tensorpick=1,7");
  demux.caps(kFlexibleBranch);
  ASSERT_EQ(demux.push(flexible_frame(2)), GST_FLOW_OK);
  ASSERT_EQ(demux.push(flexible_frame(2)), GST_FLOW_OK);
  EXPECT_EQ(demux.branch("src_0").buffers.size(), 2u);
  EXPECT_TRUE(demux.branch("src_1").events.empty());
  EXPECT_EQ(demux.branch("src_1").caps(), "");
  const std::string warning = demux.warning();
  EXPECT_SAYS(warning, "WEIR-1004: tensorpick names a tensor that does not exist");
  EXPECT_SAYS(warning, "index 7");
  EXPECT_SAYS(warning, "there are 2 tensors");
  EXPECT_EQ(demux.warning(), "") << "posted once";
  EXPECT_EQ(demux.error(), "");
  EXPECT_EQ(demux.stat("pushed-src_1"), 0u);
  demux.send(gst_event_new_eos());
  EXPECT_EQ(demux.branch("src_1").events, names({"stream-start", "eos"}));
}

// The sink of the first pad may block on the first frame until the other sink has one too.
TEST(TensorDemuxRejects, AnIndexBeyondTheTensorsBeforeAnythingIsPushed) {
  Branches demux("tensor_demux tensorpick=0,7");
  const auto refuse = +[](GstElement*, GstPad*, Branches* self) {
    if (self->has("src_0")) self->branch("src_0").flow = GST_FLOW_ERROR;
  };
  g_signal_connect(demux.element(), "pad-added", G_CALLBACK(refuse), &demux);
  demux.caps(kFlexibleBranch);
  EXPECT_EQ(demux.push(flexible_frame(2)), GST_FLOW_ERROR);
  EXPECT_SAYS(demux.warning(), "index 7");
}

TEST(TensorDemuxRejects, OnlyIndicesBeyondTheTensorsOfAFlexibleFrame) {
  Branches demux("tensor_demux tensorpick=0:9");
  demux.caps(kFlexibleBranch);
  EXPECT_EQ(demux.push(flexible_frame(2)), GST_FLOW_OK);
  EXPECT_SAYS(demux.warning(), "index 9");
  EXPECT_EQ(demux.stat("dropped-policy"), 1u);
}

TEST(TensorDemuxRejects, ATypoAtTheStart) {
  Branches demux("tensor_demux tensorpick=0,l");
  EXPECT_FALSE(demux.started());
  const std::string error = demux.error();
  EXPECT_SAYS(error, "WEIR-1001: tensorpick cannot be read");
  EXPECT_SAYS(error, "    0,l\n      ^");
}

TEST(TensorDemuxRejects, OnlyOnceBeforeTheEnd) {
  Branches demux("tensor_demux");
  demux.caps(kTwo);
  EXPECT_EQ(demux.push(make_frame({{1}, {2}})), GST_FLOW_ERROR);
  EXPECT_SAYS(demux.error(), "WEIR-2004");
  demux.send(gst_event_new_eos());
  EXPECT_EQ(demux.error(), "");
}

TEST(TensorDemuxRejects, AnEndWithoutAFrame) {
  Branches demux("tensor_demux");
  demux.caps(kTwo);
  demux.send(gst_event_new_eos());
  EXPECT_SAYS(demux.error(), "WEIR-2003: the stream ended without any output");
  EXPECT_EQ(demux.domain(), "gst-stream-error-quark");
  EXPECT_EQ(demux.code(), GST_STREAM_ERROR_WRONG_TYPE);
}

std::string refused(const std::string& caps, GstBuffer* buffer) {
  Branches demux("tensor_demux");
  demux.caps(caps);
  EXPECT_EQ(demux.push(buffer), GST_FLOW_ERROR);
  EXPECT_EQ(demux.stat("dropped-error"), 1u);
  demux.expect_balance();
  return demux.error();
}

TEST(TensorDemuxRejects, BuffersOfTheWrongSize) {
  EXPECT_SAYS(refused(kTwo, make_frame({{1}, {2}})),
              "WEIR-2004: the size of a buffer does not match its caps");
  EXPECT_SAYS(refused(kTwo, make_frame({{1}, {2}})), "1 bytes in memory 0");
  EXPECT_SAYS(refused(kTwo, make_frame({{1, 2}})), "2 bytes in 1 memory");
  EXPECT_SAYS(refused(kTwo, gst_buffer_new()), "the buffer is too small");
  EXPECT_SAYS(refused(kFlexibleBranch, gst_buffer_new()),
              "a buffer is empty\n  offered: 0 bytes\n  needed: at least one tensor\n  fix: check");
}

TEST(TensorDemuxRejects, InvalidHeaders) {
  Bytes header(128);
  EXPECT_SAYS(refused(kFlexibleBranch, make_frame({header})), "WEIR-2005");
  EXPECT_SAYS(refused(kFlexibleBranch, make_frame({{1, 2, 3}})), "too short for a tensor header");
  const auto put = [&](size_t at, uint32_t value) { std::memcpy(&header[at], &value, 4); };
  put(0, 0xfeedcced);
  put(4, 0xDE001000);
  put(8, 5);  // uint8
  put(12, 9);
  put(80, 4);
  Bytes short_of_one = header;
  short_of_one.resize(128 + 8);
  EXPECT_SAYS(refused(kFlexibleBranch, make_frame({short_of_one})),
              "a tensor header declares more bytes than its memory holds");
  put(8, 11);
  EXPECT_SAYS(refused(kFlexibleBranch, make_frame({header})), "unknown element type");
}

TEST(TensorDemuxRejects, InvalidPackedTensors) {
  std::string dimensions = "1", types = "uint8";
  for (int i = 1; i < 18; ++i) dimensions += ",1", types += ",uint8";
  const std::string caps = test::tensors(types, dimensions);
  std::vector<Bytes> memories(16, Bytes{1});
  EXPECT_SAYS(refused(caps, make_frame(memories)), "has no packed header");
  memories.back().resize(20000);
  const uint32_t magic = 0xf00dc0de, extra = 200;
  std::memcpy(memories.back().data(), &magic, 4);
  std::memcpy(memories.back().data() + 8, &extra, 4);
  EXPECT_SAYS(refused(caps, make_frame(memories)), "WEIR-2005");
}

TEST(TensorDemuxRejects, CapsThatDownstreamRejects) {
  Branches demux("tensor_demux", {{"src_1", "other/tensors,format=static,types=float32"}});
  demux.caps(kTwo);
  EXPECT_EQ(demux.push(two()), GST_FLOW_NOT_NEGOTIATED);
  const std::string error = demux.error();
  EXPECT_SAYS(error, "WEIR-2001: the element downstream of src_1 does not accept its output");
  EXPECT_SAYS(error, "types=(string)uint8");
  EXPECT_SAYS(error, "types=(string)float32");
}

TEST(TensorDemuxRejects, ABufferBeforeCaps) {
  Branches demux("tensor_demux");
  demux.send(test::time_segment());
  EXPECT_EQ(demux.push(two()), GST_FLOW_NOT_NEGOTIATED);
  EXPECT_SAYS(demux.error(), "WEIR-2003: a buffer arrived before caps");
  demux.expect_balance();
}

}  // namespace pads_test
}  // namespace weir::test
