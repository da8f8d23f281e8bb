// tensor_merge: its output along each dimension, and its errors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_mux/many_inputs_test_support.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir::test {
namespace tensor_merge_test {

std::string caps(const char* dims, const char* type = "uint8") {
  return std::string("other/tensor,dimension=(string)") + dims + ",type=(string)" + type +
         ",framerate=(fraction)30/1";
}

// 2:3 with consecutive numbers from `first`.
Bytes numbers(uint8_t first, size_t count = 6) {
  Bytes out;
  for (size_t i = 0; i < count; ++i) out.push_back(static_cast<uint8_t>(first + i));
  return out;
}

struct Line {
  const char *option, *dims;
  Bytes out;
};

TEST(TensorMerge, ConcatenatesTensorsAlongEachDimension) {
  const Line lines[] = {
      {"", "4:3:1:1", {1, 2, 11, 12, 3, 4, 13, 14, 5, 6, 15, 16}},
      {"option=0", "4:3:1:1", {1, 2, 11, 12, 3, 4, 13, 14, 5, 6, 15, 16}},
      {"option=1", "2:6:1:1", {1, 2, 3, 4, 5, 6, 11, 12, 13, 14, 15, 16}},
      {"option=2", "2:3:2:1", {1, 2, 3, 4, 5, 6, 11, 12, 13, 14, 15, 16}},
      {"option=3", "2:3:1:2", {1, 2, 3, 4, 5, 6, 11, 12, 13, 14, 15, 16}},
      {"option=5", "2:3:1:1:1:2", {1, 2, 3, 4, 5, 6, 11, 12, 13, 14, 15, 16}},
  };
  for (const Line& line : lines) {
    ManyInputs merge(std::string("tensor_merge mode=linear ") + line.option);
    merge.add(caps("2:3:1:1").c_str());
    merge.add(caps("2:3").c_str());
    merge.play();
    merge.push_all({numbers(1), numbers(11)}, 40);
    ASSERT_EQ(merge.buffers().size(), 1u) << line.option;
    EXPECT_EQ(read_memories(merge.buffers()[0].get()), std::vector<Bytes>{line.out}) << line.option;
    EXPECT_EQ(merge.caps(), std::string("other/tensors, format=(string)static, num_tensors=(int)1, "
                                        "dimensions=(string)") +
                                line.dims + ", types=(string)uint8, framerate=(fraction)30/1");
    EXPECT_EQ(merge.stat("bytes-copied"), 0u);
  }
}

TEST(TensorMerge, AcceptsManyPads) {
  ManyInputs merge("tensor_merge");
  std::vector<Bytes> frames;
  Bytes expected;
  for (uint8_t i = 0; i < 20; ++i) {
    merge.add(caps("1").c_str());
    frames.push_back({i});
    expected.push_back(i);
  }
  merge.play();
  merge.push_all(frames, 0);
  EXPECT_EQ(read_memories(merge.buffers().at(0).get()), std::vector<Bytes>{expected});
}

TEST(TensorMerge, PairsByOrderByDefault) {
  ManyInputs merge("tensor_merge");
  merge.add(caps("1").c_str());
  merge.add(caps("1").c_str());
  merge.play();
  auto first = merge.push_later(0, Bytes{1}, 10);
  merge.push(1, Bytes{2}, 500);
  first.get();
  ASSERT_EQ(merge.buffers().size(), 1u);
  EXPECT_EQ(GST_BUFFER_PTS(merge.buffers()[0].get()), 500u);
}

TEST(TensorMerge, SlowestDropsFramesThatAreTooOld) {
  ManyInputs merge("tensor_merge sync-mode=slowest");
  merge.add(caps("1").c_str());
  merge.add(caps("1").c_str());
  merge.play();
  auto colour = merge.push_later(1, Bytes{29}, 29);
  EXPECT_EQ(merge.push_later(0, Bytes{14}, 14).get(), GST_FLOW_OK);
  EXPECT_EQ(merge.push(0, Bytes{30}, 30), GST_FLOW_OK);
  colour.get();
  ASSERT_EQ(merge.buffers().size(), 1u);
  EXPECT_EQ(read_memories(merge.buffers()[0].get()), (std::vector<Bytes>{{30, 29}}));
  EXPECT_EQ(GST_BUFFER_PTS(merge.buffers()[0].get()), 29u);
  EXPECT_EQ(merge.stat("dropped-policy"), 1u);
}

TEST(TensorMerge, SendsOtherTensorToAPeerThatAcceptsIt) {
  ManyInputs merge("tensor_merge", "other/tensor,framerate=[0/1,2147483647/1]");
  merge.add(caps("2").c_str());
  merge.play();
  EXPECT_EQ(merge.push(0, Bytes{1, 2}, 0), GST_FLOW_OK);
  EXPECT_EQ(merge.caps(),
            "other/tensor, dimension=(string)2, type=(string)uint8, framerate=(fraction)30/1");
}

TEST(TensorMerge, KeepsTheSourceMapIfPixelsKeepTheirPlace) {
  for (const bool channels : {true, false}) {
    ManyInputs merge(channels ? "tensor_merge option=0" : "tensor_merge option=1");
    merge.add(caps("2:3").c_str());
    merge.play();
    auto in = make_buffer({numbers(1)}, 0);
    gst::set_source_maps(in.get(), {picture_as_it_is(64, 48, false)});
    EXPECT_EQ(merge.push(0, in), GST_FLOW_OK);
    EXPECT_EQ(gst::source_maps(merge.buffers().at(0).get()).size(), channels ? 1u : 0u);
  }
}

TEST(TensorMerge, CopiesTimesAndNothingElse) {
  ManyInputs merge("tensor_merge");
  merge.add(caps("1").c_str());
  merge.play();
  auto in = make_buffer({{1}}, 50);
  GST_BUFFER_DTS(in.get()) = 40;
  GST_BUFFER_DURATION(in.get()) = 5;
  GST_BUFFER_FLAG_SET(in.get(), GST_BUFFER_FLAG_MARKER);
  merge.push(0, in);
  GstBuffer* out = merge.buffers().at(0).get();
  EXPECT_EQ(GST_BUFFER_DTS(out), 40u);
  EXPECT_EQ(GST_BUFFER_DURATION(out), 5u);
  EXPECT_FALSE(GST_BUFFER_FLAG_IS_SET(out, GST_BUFFER_FLAG_MARKER));
}

TEST(TensorMerge, ReportsPadsThatDoNotFitWithBothShapes) {
  ManyInputs merge("tensor_merge option=0");
  merge.add(caps("2:3").c_str());
  merge.add(caps("2:4").c_str());
  merge.play();
  auto first = merge.push_later(0, Bytes(6), 0), second = merge.push_later(1, Bytes(8), 0);
  EXPECT_TRUE(first.get() == GST_FLOW_ERROR || second.get() == GST_FLOW_ERROR);
  const std::string error = merge.error();
  EXPECT_SAYS(error, "WEIR-2001");
  EXPECT_SAYS(error, "pad 1: uint8 2:4");
  EXPECT_SAYS(error, "pad 0: uint8 2:3");
  EXPECT_SAYS(error, "dimension 1 is 4, needed is 3");
}

TEST(TensorMerge, OptionsWithATypoStopTheStart) {
  const std::pair<const char*, const char*> lines[] = {{"tensor_merge option=16", "WEIR-1004"},
                                                       {"tensor_merge option=-1", "WEIR-1004"},
                                                       {"tensor_merge option=x", "WEIR-1004"},
                                                       {"tensor_merge mode=linaer", "WEIR-1005"}};
  for (const auto& [launch, code] : lines) {
    ManyInputs merge(launch);
    EXPECT_EQ(merge.play(), GST_STATE_CHANGE_FAILURE) << launch;
    EXPECT_SAYS(merge.error(), code) << launch;
  }
}

TEST(TensorMerge, AnUnknownSyncModeFallsBackToNosync) {
  ManyInputs merge("tensor_merge sync-mode=quick");
  merge.add(caps("1").c_str());
  merge.add(caps("1").c_str());
  merge.play();
  const std::string warning = merge.warning();
  EXPECT_SAYS(warning, "WEIR-1005: sync-mode is unknown; nosync is used");
  EXPECT_SAYS(warning, "fix: sync-mode=nosync");
  auto first = merge.push_later(0, Bytes{1}, 10);
  EXPECT_EQ(merge.push(1, Bytes{2}, 500), GST_FLOW_OK);
  first.get();
  EXPECT_EQ(merge.buffers().size(), 1u);
}

TEST(TensorMerge, RejectsABufferThatIsTooSmall) {
  ManyInputs merge("tensor_merge");
  merge.add(caps("4").c_str());
  merge.play();
  EXPECT_EQ(merge.push(0, Bytes{1, 2, 3}, 0), GST_FLOW_ERROR);
  const std::string error = merge.error();
  EXPECT_SAYS(error, "WEIR-2004");
  EXPECT_SAYS(error, "3 bytes in memory 0 on pad 0");
}

// A seek may begin on another thread at any time; here it does when the caps reach downstream.
TEST(TensorMerge, DropsAFrameIfAFlushBeginsDuringNegotiation) {
  ManyInputs merge("tensor_merge mode=linear option=0");
  merge.add(caps("2:3").c_str());
  merge.play();
  const auto flush = +[](GstPad*, GstPadProbeInfo* info, gpointer input) {
    if (GST_EVENT_TYPE(GST_PAD_PROBE_INFO_EVENT(info)) == GST_EVENT_CAPS)
      static_cast<ManyInputs*>(input)->event(0, gst_event_new_flush_start());
    return GST_PAD_PROBE_OK;
  };
  const gulong probe =
      gst_pad_add_probe(merge.sink(), GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM, flush, &merge, nullptr);
  EXPECT_EQ(merge.push(0, numbers(1), 40), GST_FLOW_FLUSHING);
  gst_pad_remove_probe(merge.sink(), probe);
  EXPECT_EQ(merge.stat("dropped-flush"), 1u);
  EXPECT_EQ(merge.stat("consumed"), 0u);
  merge.event(0, gst_event_new_flush_stop(TRUE));
  merge.event(0, time_segment());
  EXPECT_EQ(merge.push(0, numbers(1), 40), GST_FLOW_OK);
  ASSERT_EQ(merge.buffers().size(), 1u);
  EXPECT_EQ(read_memories(merge.buffers()[0].get()), std::vector<Bytes>{numbers(1)});
  EXPECT_EQ(merge.error(), "");
}

}  // namespace tensor_merge_test
}  // namespace weir::test
