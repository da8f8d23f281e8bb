// Python scripts in pipelines, in this process and in others. Skipped without Python or NumPy.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <thread>

#include "elements/tests/element_test_support.hpp"

namespace python_filter_test {

using namespace weir::test;

std::string example(const std::string& name) {
  return std::string(std::getenv("WEIR_SCRIPTS")) + "/" + name + ".py";
}
std::string filter(const std::string& script, const std::string& properties = "") {
  return "tensor_filter framework=python3 model=" + script + " " + properties;
}

class PythonFilter : public testing::Test {
 protected:
  void SetUp() override {
    const auto error = start_error(filter(example("passthrough")));
    if (error.find("WEIR-3002") != std::string::npos) GTEST_SKIP() << error;
    ASSERT_EQ(error, "");
  }
  static std::string script(const std::string& name, const std::string& lines,
                            const std::string& head = "") {
    const std::string path = testing::TempDir() + "weir_" + name + ".py";
    std::ofstream(path) << "import numpy as np, os, time\n"
                        << head
                        << "class CustomFilter:\n  def setInputDim(self, dims): return dims\n"
                           "  def invoke(self, input_array):\n    "
                        << lines << "\n";
    return path;
  }
};

Ref<GstBuffer> pushed(const Harness& h, GstBuffer* in) {
  return Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
}

TEST_F(PythonFilter, PassesFramesOfAnyKind) {
  for (const char* where : {"", "isolate=process"}) {
    auto h = make_harness(filter(example("passthrough"), where), tensors("uint8", "3:4:2:1"));
    const auto out = pushed(h, frame(ramp(24), GST_SECOND, GST_MSECOND));
    ASSERT_TRUE(out);
    EXPECT_EQ(content(out.get()), ramp(24));
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), GST_SECOND);
    EXPECT_SAYS(caps_text(h), "3:4:2:1");
  }
}

// docs/compatibility/filter.md 4.3: an error for every framework, even if the outputs are known
// only when the stream is negotiated.
TEST_F(PythonFilter, RejectsOutputPropertiesThatContradictTheModel) {
  const auto caps = tensors("uint8", "3:4:2:1");
  for (const char* where : {"", " isolate=process"})
    for (const char* wrong :
         {"output=3:4:3", "outputtype=int8", "output=3:4:2 outputtype=float32", "output=3:4:2,1"}) {
      const auto text =
          start_error(filter(example("passthrough"), std::string(wrong) + where), caps);
      EXPECT_SAYS(text, "WEIR-2001: output") << wrong << where;
    }
}

TEST_F(PythonFilter, AcceptsOutputPropertiesThatMatchTheModel) {
  for (const char* right : {"output=3:4:2", "output=3:4:2:1:1", "outputtype=uint8",
                            "output=3:4:2:1 outputtype=uint8"}) {
    auto h = make_harness(filter(example("passthrough"), right), tensors("uint8", "3:4:2:1"));
    const auto out = pushed(h, frame(ramp(24)));
    ASSERT_TRUE(out) << right;
    EXPECT_SAYS(caps_text(h), "3:4:2:1") << right;
  }
}

// Bytes after a header; docs/compatibility/types-and-caps.md 1.7.
Bytes flexible(uint32_t count) {
  Bytes out(128 + count);
  const auto put = [&](size_t word, uint32_t value) { std::memcpy(&out[4 * word], &value, 4); };
  put(0, 0xfeedcced);
  put(1, 0xDE001000);
  put(2, 5);  // uint8
  put(3, count);
  put(20, 4);  // of a tensor
  return out;
}

constexpr char kFlexible[] = "other/tensors,format=flexible,framerate=30/1";

// Outputs that are known only with each frame are flexible tensors.
TEST_F(PythonFilter, OutputsFlexibleTensorsForFlexibleInput) {
  auto h = make_harness(filter(example("passthrough")), kFlexible);
  for (const uint32_t count : {4u, 5u}) {
    const auto out = pushed(h, frame(flexible(count)));
    ASSERT_TRUE(out);
    EXPECT_EQ(content(out.get()), flexible(count));
  }
  EXPECT_SAYS(caps_text(h), "other/tensors, format=(string)flexible");
}

// docs/compatibility/filter.md 4.3: the framework is queried with the input that the user set.
TEST_F(PythonFilter, NegotiatesOutputsForADeclaredFlexibleStream) {
  auto h = make_harness(filter(example("passthrough"), "input=4:1 inputtype=uint8"), kFlexible);
  const auto out = pushed(h, frame(flexible(4)));
  ASSERT_TRUE(out);
  EXPECT_EQ(content(out.get()), Bytes(4));
  EXPECT_SAYS(caps_text(h), "other/tensor, dimension=(string)4:1, type=(string)uint8");
  Errors errors(h);
  EXPECT_NE(gst_harness_push(h.get(), frame(flexible(5))), GST_FLOW_OK);
  EXPECT_SAYS(errors.next(), "the stream does not fit the model");
}

TEST_F(PythonFilter, RejectsAFlexibleFrameWithAnUndeclaredOutput) {
  auto h = make_harness(filter(example("passthrough"), "output=4 outputtype=uint8"), kFlexible);
  Errors errors(h);
  EXPECT_EQ(gst_harness_push(h.get(), frame(flexible(4))), GST_FLOW_OK) << errors.next();
  EXPECT_NE(gst_harness_push(h.get(), frame(flexible(5))), GST_FLOW_OK);
  EXPECT_SAYS(errors.next(), "output contradicts the model");
}

TEST_F(PythonFilter, IsFoundByTheFileExtension) {
  auto h = make_harness("tensor_filter model=" + example("passthrough"), tensors("int16", "2:1"));
  const auto out = pushed(h, frame<int16_t>({-3, 4}));
  ASSERT_TRUE(out);
  EXPECT_EQ(values<int16_t>(out.get()), (std::vector<int16_t>{-3, 4}));
}

TEST_F(PythonFilter, Scales) {
  auto h = make_harness(filter(example("scaler"), "custom=\"2 1\""), tensors("uint8", "3:4:2:1"));
  const auto out = pushed(h, frame(ramp(24)));
  ASSERT_TRUE(out);
  EXPECT_EQ(content(out.get()), (Bytes{0, 1, 2, 6, 7, 8}));
  EXPECT_SAYS(caps_text(h), "3:2:1:1");
}

TEST_F(PythonFilter, Averages) {
  auto h =
      make_harness(filter(example("average"), "custom=\"3 4 2\""), tensors("uint8", "3:4:2:1"));
  const auto out = pushed(h, frame(ramp(24)));
  ASSERT_TRUE(out);
  EXPECT_EQ(values<float>(out.get()), (std::vector<float>{10.5, 11.5, 12.5}));
  EXPECT_SAYS(
      start_error(filter(example("average"), "custom=\"3 4 2\""), tensors("uint8", "3:5:2:1")),
      "dimension 1 is 5, needed is 4");
}

// Memory that a script keeps is not changed; if it would have to be, the script is stopped.
TEST_F(PythonFilter, CanKeepItsInput) {
  const auto path =
      script("delays",
             "before, self.before = getattr(self, 'before', None), input_array[0][1:]\n"
             "    return [input_array[0] if before is None else np.append(before, before[0])]");
  for (const char* line : {"tensor_filter", "queue ! tensor_filter",
                           "tensor_transform mode=arithmetic option=add:0 ! tensor_filter"}) {
    auto h = make_harness(std::string(line) + " framework=python3 model=" + path,
                          tensors("uint8", "10000"));
    for (uint8_t i = 1; i < 20; ++i) {
      const auto out = pushed(h, frame(Bytes(10000, i)));
      ASSERT_TRUE(out);
      EXPECT_EQ(content(out.get()), Bytes(10000, i == 1 ? 1 : i - 1)) << line;
    }
  }
  const auto element = lone_element(filter(path, "isolate=process"));
  auto h = Harness{gst_harness_new_with_element(element.get(), "sink", "src")};
  Errors errors(element.get());
  gst_harness_set_src_caps_str(h.get(), tensors("uint8", "4").c_str());
  EXPECT_EQ(gst_harness_push(h.get(), frame<uint8_t>({1, 2, 3, 4})), GST_FLOW_ERROR);
  EXPECT_SAYS(errors.next(), "the script keeps an array of its input");
}

// Frames can be read, and freed on another thread, after the element and its script were destroyed.
TEST_F(PythonFilter, FramesOutliveTheScript) {
  const auto path = script("fresh", "return [input_array[0] + np.uint8(1)]");
  std::vector<Ref<GstBuffer>> frames;
  {
    auto h = make_harness(filter(path), tensors("uint8", "100000"));
    for (int i = 0; i < 3; ++i) frames.push_back(pushed(h, frame(Bytes(100000, uint8_t(i)))));
  }
  for (uint8_t i = 0; i < 3; ++i)
    EXPECT_EQ(content(frames[i].get()), Bytes(100000, uint8_t(i + 1)));
  std::thread([&] { frames.clear(); }).join();
}

TEST_F(PythonFilter, GetsItsArgumentsUnchanged) {
  const auto path =
      script("words", "return input_array",
             "class Words:\n  def __init__(self, *words): raise ValueError(repr(words))\n");
  std::ofstream(path, std::ios::app) << "class CustomFilter(Words): pass\n";
  for (const char* where : {"", " isolate=process"})
    EXPECT_SAYS(start_error(filter(path, std::string("custom=\"a, b:c  d:\"") + where)),
                "ValueError: ('a,', 'b:c', '', 'd:')");
}

TEST_F(PythonFilter, ReportsExceptionsWithTheirPlace) {
  const auto path = script("raises", "raise ValueError('no such frame')");
  const auto element = lone_element(filter(path));
  auto h = Harness{gst_harness_new_with_element(element.get(), "sink", "src")};
  Errors errors(element.get());
  gst_harness_set_src_caps_str(h.get(), tensors("uint8", "2:1").c_str());
  EXPECT_EQ(gst_harness_push(h.get(), frame<uint8_t>({1, 2})), GST_FLOW_ERROR);
  const auto text = errors.next();
  EXPECT_SAYS(text, "WEIR-3006: the script failed: ValueError: no such frame");
  EXPECT_SAYS(text, "weir_raises.py:5 in invoke: raise ValueError('no such frame')");
}

// Four processes, each with its own Python lock, and frames of different duration in order.
TEST_F(PythonFilter, RunsInSeveralProcessesInOrder) {
  const auto path = script("slow",
                           "time.sleep(0.002 * (input_array[0][0] % 3))\n"
                           "    return [np.array([input_array[0][0], os.getpid()], np.int32)]");
  auto h = make_harness(filter(path, "isolate=process workers=4"), tensors("int32", "2:1"));
  for (int32_t i = 0; i < 60; ++i)
    ASSERT_EQ(gst_harness_push(h.get(), frame<int32_t>({i, 0})), GST_FLOW_OK);
  std::vector<int32_t> processes;
  for (int32_t i = 0; i < 60; ++i) {
    const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    ASSERT_TRUE(out);
    const auto got = values<int32_t>(out.get());
    EXPECT_EQ(got[0], i);
    processes.push_back(got[1]);
  }
  std::sort(processes.begin(), processes.end());
  processes.erase(std::unique(processes.begin(), processes.end()), processes.end());
  EXPECT_EQ(processes.size(), 4u);
}

TEST_F(PythonFilter, IsEndedIfItNeverReturns) {
  const auto path = script("endless", "while True: pass");
  const auto element =
      lone_element(filter(path, "isolate=process isolate-timeout=50 on-crash=error"));
  auto h = Harness{gst_harness_new_with_element(element.get(), "sink", "src")};
  Errors errors(element.get());
  gst_harness_set_src_caps_str(h.get(), tensors("uint8", "2:1").c_str());
  EXPECT_EQ(gst_harness_push(h.get(), frame<uint8_t>({1, 2})), GST_FLOW_ERROR);
  EXPECT_SAYS(errors.next(), "WEIR-3015");
}

TEST_F(PythonFilter, EndsItsOwnProcessOnly) {
  const auto path =
      script("leaves", "os._exit(3) if input_array[0][0] == 7 else None\n    return input_array");
  const auto element = lone_element(filter(path, "isolate=process on-crash=error"));
  auto h = Harness{gst_harness_new_with_element(element.get(), "sink", "src")};
  Errors errors(element.get());
  gst_harness_set_src_caps_str(h.get(), tensors("uint8", "2:1").c_str());
  EXPECT_EQ(gst_harness_push(h.get(), frame<uint8_t>({1, 2})), GST_FLOW_OK);
  EXPECT_EQ(gst_harness_push(h.get(), frame<uint8_t>({7, 2})), GST_FLOW_ERROR);
  EXPECT_SAYS(errors.next(), "exit(3)");
}

}  // namespace python_filter_test
