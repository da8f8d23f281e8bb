// Tests of tensor_filter framework=custom with shared objects of NNStreamer's interface.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <unistd.h>

#include <cmath>

#include "elements/tests/pipeline_test_support.hpp"
#include "filter_lines_test_support.hpp"

namespace custom_filter_test {

using namespace weir::test;
using Floats = std::vector<float>;
using Numbers = std::vector<uint64_t>;

const std::string kFour = tensors("float32", "4");

std::string file(const std::string& name) {
  return filter_file(name);
}
std::string line(const std::string& name, const std::string& more = "") {
  return "tensor_filter framework=custom model=" + file(name) + " " + more;
}
std::string fault(const std::string& name) {
  return start_error(line("unruly0", "custom=" + name));
}

TEST(CompatCustomFilter, RunsWithTheDocumentedLayout) {
  auto h = make_harness(line("by_hand", "custom=2.5"), kFour);
  EXPECT_EQ(pushed<float>(h, {1, 2, -4, 0}), (Floats{2.5, 5, -10, 0}));
  EXPECT_SAYS(caps_text(h), "dimension=(string)4");
  EXPECT_EQ(stat(h, "tensor_filter", "bytes-copied"), 0u);
}

TEST(CompatCustomFilter, IsChosenByTheFilesName) {
  auto h = make_harness("tensor_filter model=" + file("by_hand"), kFour);
  EXPECT_EQ(pushed<float>(h, {1, 2, 3, 4}), (Floats{1, 2, 3, 4}));
}

TEST(CompatCustomFilter, AboveZeroDropsAndBelowFails) {
  auto h = make_harness(line("by_hand", "custom=1"), kFour);
  EXPECT_EQ(pushed<float>(h, {101, 0, 0, 0}), Floats{});
  EXPECT_EQ(pushed<float>(h, {3, 0, 0, 0}), (Floats{3, 0, 0, 0}));
  const auto message = frame_error<float>(h, {-101, 0, 0, 0});
  EXPECT_SAYS(message, "by_hand.so failed on a frame");
  EXPECT_SAYS(message, "-22 (Invalid argument)");
  EXPECT_EQ(stat(h, "tensor_filter", "dropped-error"), 1u);
}

TEST(CompatCustomFilter, FollowsTheStreamsSizes) {
  auto h = make_harness(line("passthrough"), tensors("uint8,int16", "3:2,5"));
  EXPECT_SAYS(caps_text(h), "");
  GstBuffer* two = frame<uint8_t>({1, 2, 3, 4, 5, 6});
  gst_buffer_append(two, frame<int16_t>({7, 8, 9, 10, -11}));
  ASSERT_EQ(gst_harness_push(h.get(), two), GST_FLOW_OK);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(content(out.get()), (Bytes{1, 2, 3, 4, 5, 6, 7, 0, 8, 0, 9, 0, 10, 0, 0xF5, 0xFF}));
  EXPECT_SAYS(caps_text(h), "dimensions=(string)\"3:2\\,5\"");
}

// docs/compatibility/filter.md 4.3: an error for every framework. setInputDim reports the outputs
// once caps arrive.
TEST(CompatCustomFilter, RejectsOutputPropertiesThatContradictTheModel) {
  const auto caps = tensors("uint8", "3:2");
  for (const char* wrong : {"output=3:3", "outputtype=int8", "output=3:2 outputtype=float32"})
    EXPECT_SAYS(start_error(line("passthrough", wrong), caps),
                "WEIR-2001: output contradicts the model")
        << wrong;
  EXPECT_SAYS(start_error(line("passthrough", "output=3:2,1"), caps), "differ in number");
  auto h = make_harness(line("passthrough", "output=3:2:1 outputtype=uint8"), caps);
  EXPECT_EQ(pushed<uint8_t>(h, {1, 2, 3, 4, 5, 6}), (Bytes{1, 2, 3, 4, 5, 6}));
}

TEST(CompatCustomFilter, CallsTheLibraryWithoutLinkingIt) {
  auto h = make_harness(line("average"), tensors("uint8", "2:3:1"));
  ASSERT_EQ(gst_harness_push(h.get(), frame<uint8_t>({1, 10, 2, 20, 6, 60})), GST_FLOW_OK);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(values<float>(out.get()), (Floats{3, 30}));
  EXPECT_SAYS(caps_text(h), "dimension=(string)2:1:1");
}

TEST(CompatCustomFilter, CallsTheLibraryThatItLinks) {
  auto h = make_harness(line("scaler", "custom=2x1"), tensors("uint8", "1:4:2"));
  EXPECT_EQ(pushed<uint8_t>(h, {1, 2, 3, 4, 5, 6, 7, 8}), (Bytes{1, 3}));
}

TEST(CompatCustomFilter, AllocatedOutputsAreForwardedWithoutACopy) {
  long freed = 0;
  const auto address = "custom=" + std::to_string(reinterpret_cast<uintptr_t>(&freed));
  auto h = make_harness(line("allocating", address), tensors("uint64", "2"));
  ASSERT_EQ(gst_harness_push(h.get(), frame<uint64_t>({0, 0})), GST_FLOW_OK);
  auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  {
    const Mapped map(out.get(), GST_MAP_READ);
    const auto read = map.as<const uint64_t>();
    EXPECT_EQ(read[0], reinterpret_cast<uintptr_t>(read.data()));
  }
  EXPECT_EQ(stat(h, "tensor_filter", "bytes-copied"), 0u);
  EXPECT_EQ(freed, 0);
  h.reset();
  EXPECT_EQ(freed, 0) << "a frame outlives its filter";
  out = {};
  EXPECT_EQ(freed, 1);
}

TEST(CompatCustomFilter, MissingAllocatedOutputsAreReported) {
  long freed = 0;
  const auto address = "custom=" + std::to_string(reinterpret_cast<uintptr_t>(&freed));
  {
    auto h = make_harness(line("allocating", address), tensors("uint64", "2"));
    EXPECT_EQ(pushed<uint64_t>(h, {1, 0}), Numbers{}) << "dropped";
    EXPECT_SAYS(frame_error<uint64_t>(h, {2, 0}),
                "must allocate its outputs, but returned no memory");
  }
  auto h = make_harness(line("allocating", address), tensors("uint64", "2"));
  const auto message = frame_error<uint64_t>(h, {3, 0});
  EXPECT_SAYS(message, "returned an output of a different size");
  EXPECT_SAYS(message, "output 0: 17 bytes");
  EXPECT_EQ(freed, 1);
}

TEST(CompatCustomFilter, IncompleteTablesAreRejected) {
  const std::pair<int, const char*> faults[] = {
      {1, "no initfunc"},
      {2, "setInputDim together with getInputDim or getOutputDim"},
      {3, "only one of getInputDim and getOutputDim"},
      {4, "no function that declares the tensors"},
      {5, "both invoke and allocate_invoke"},
      {6, "no invoke"},
      {7, "NNStreamer_custom is NULL"},
      {8, "nnstreamer_no_such_function"}};
  for (const auto& [number, words] : faults) {
    const auto message = start_error(line("unruly" + std::to_string(number)));
    EXPECT_SAYS(message, "WEIR-3007");
    EXPECT_SAYS(message, words);
    EXPECT_SAYS(message, "fix:");
  }
}

TEST(CompatCustomFilter, ImpossibleSizesAreRejected) {
  const std::pair<const char*, const char*> faults[] = {
      {"no-tensor", "0 outputs"},
      {"257-tensors", "257 outputs"},
      {"17-without-extra", "output 16 without a description"},
      {"no-dimension", "output 0 with the dimension 0"},
      {"hole", "output 0 with the dimension 4:0:3"},
      {"4-gib", "less than 4 GiB"},
      {"overflow", "less than 4 GiB"},
      {"type", "output 0 with type 11"},
      {"negative-type", "output 0 with type -1"}};
  for (const auto& [name, words] : faults) {
    const auto message = fault(name);
    EXPECT_SAYS(message, "WEIR-5003");
    EXPECT_SAYS(message, "unruly0.so declares an invalid tensor");
    EXPECT_SAYS(message, words);
  }
  EXPECT_SAYS(fault("input-fails"), "getInputDim returned -5 (Input/output error)");
}

TEST(CompatCustomFilter, ExceptionsEndAtTheElement) {
  EXPECT_SAYS(fault("throw-in-init"),
              "threw an exception in initfunc\n  offered: the device is gone");
  EXPECT_SAYS(fault("throw-in-input"),
              "threw an exception in getInputDim\n  offered: not a std::exc");
  auto h = make_harness(line("unruly0", "custom=throw-in-invoke"), kFour);
  EXPECT_SAYS(frame_error<float>(h, {1, 2, 3, 4}), "threw an exception in invoke");
  h = make_harness(line("unruly0", "custom=throw-a-number"), kFour);
  EXPECT_SAYS(frame_error<float>(h, {1, 2, 3, 4}), "not a std::exception");
  h = make_harness(line("unruly0", "custom=throw-in-exit"), kFour);
  EXPECT_EQ(pushed<float>(h, {1, 2, 3, 4}), (Floats{1, 2, 3, 4}));
}

TEST(CompatCustomFilter, OutputAddressesMustNotChange) {
  for (const char* name : {"other-memory", "smaller"}) {
    auto h = make_harness(line("unruly0", std::string("custom=") + name), kFour);
    EXPECT_SAYS(frame_error<float>(h, {1, 2, 3, 4}), "changed the address or size of its output")
        << name;
  }
}

TEST(CompatCustomFilter, IsOneRegularFile) {
  EXPECT_SAYS(start_error(line("by_hand").substr(0, line("by_hand").size() - 1) + ",second.so"),
              "second.so");
  EXPECT_SAYS(start_error(line("missing")), "WEIR-3003");
  const std::string link = testing::TempDir() + "weir_compat_link.so";
  std::remove(link.c_str());
  ASSERT_EQ(symlink(file("by_hand").c_str(), link.c_str()), 0);
  EXPECT_SAYS(start_error("tensor_filter framework=custom model=" + link),
              "must not be a symbolic link");
  std::remove(link.c_str());
  EXPECT_SAYS(start_error("tensor_filter framework=cpp model=X," + file("by_hand")),
              "framework=custom model=");
}

TEST(CompatCustomFilter, RunsInItsOwnProcess) {
  auto h = make_harness(line("by_hand", "custom=3 isolate=process"), kFour);
  EXPECT_EQ(pushed<float>(h, {1, 2, 3, 4}), (Floats{3, 6, 9, 12}));
}

// Sends white pictures (235) into a cell with a feedback loop; returns its outputs per frame.
std::vector<Floats> played_cell(const std::string& kind, int states) {
  const std::string one = "other/tensor,dimension=(string)4,type=(string)float32,framerate=30/1";
  const std::string two =
      "other/tensors,format=static,num_tensors=2,dimensions=(string)\"4,4\","
      "types=(string)\"float32,float32\",framerate=30/1";
  PlayedPipeline p(
      "videotestsrc pattern=white num-buffers=50 ! "
      "video/x-raw,format=GRAY8,width=4,height=1,framerate=30/1 ! tensor_converter ! "
      "other/tensor,dimension=(string)1:4:1:1 ! tensor_transform apply=0 mode=transpose "
      "option=1:0:2:3 ! "
      "mux.sink_0 tensor_reposrc slot-index=0 caps=" +
      (states == 1 ? one : two) + " ! mux.sink_1 tensor_mux name=mux sync-mode=nosync ! " +
      line("cells", "custom=" + kind) + " ! tensor_demux name=d tensorpick=0," +
      (states == 1 ? "1" : "1:2") +
      " d.src_0 ! tensor_sink name=out d.src_1 ! tensor_reposink slot-index=0");
  p.watch("out");
  EXPECT_EQ(p.plays_to_its_end(), "");
  return p.seen<float>("out");
}
float sigmoid(float x) {
  return 1 / (1 + std::exp(-x));
}

TEST(CompatCustomFilter, RnnCellInALoop) {
  const auto seen = played_cell("rnn", 1);
  ASSERT_EQ(seen.size(), 50u);
  float h = 0;
  for (const auto& frame : seen) {
    h = std::tanh(2.35f - 0.5f * h);
    for (const float y : frame) EXPECT_NEAR(y, 2 * h, 1e-5);
  }
}

TEST(CompatCustomFilter, LstmCellInALoop) {
  const auto seen = played_cell("lstm", 2);
  ASSERT_EQ(seen.size(), 50u);
  float h = 0, c = 0;
  for (const auto& frame : seen) {
    const float gate = 2.35f - 0.5f * h;
    c = sigmoid(gate) * c + sigmoid(-gate) * std::tanh(gate);
    h = sigmoid(gate) * std::tanh(c);
    for (const float y : frame) EXPECT_NEAR(y, 2 * h, 1e-5);
  }
}

}  // namespace custom_filter_test
