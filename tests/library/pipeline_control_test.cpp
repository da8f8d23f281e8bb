// Tests of valves, selectors and properties, and of requests for things that do not exist.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <future>

#include "pipeline_test_support.hpp"
#include "says.hpp"
#include "weir/pipeline.hpp"

namespace pipeline_control_test {

using namespace std::chrono_literals;
using namespace weir::pipeline_test;
using weir::Pipeline;
using Values = std::vector<float>;

weir::Status push(Pipeline& p, const std::string& name, float value) {
  const Values values{value};
  return p.push(name, std::span<const float>(values), {.shape = {1}});
}
float pulled(Pipeline& p, const std::string& name) {
  const auto frame = p.pull<float>(name, kLong);
  if (!frame) ADD_FAILURE() << frame.error().message();
  return frame && *frame ? (*(**frame)[0].as<float>())[0] : NAN;
}

TEST(PipelineControl, AValveDropsWhileItIsClosed) {
  Pipeline p =
      parse("appsrc name=in ! valve name=v drop-mode=forward-sticky-events ! tensor_sink name=out");
  auto valve = p.valve("v");
  ASSERT_TRUE(p.start());
  ASSERT_TRUE(push(p, "in", 1));
  EXPECT_EQ(pulled(p, "out"), 1);
  ASSERT_TRUE(valve.close());
  EXPECT_TRUE(*p.get<bool>("v", "drop"));
  ASSERT_TRUE(push(p, "in", 2));
  ASSERT_TRUE(p.end("in"));
  EXPECT_TRUE(std::isnan(pulled(p, "out"))) << "frame 2 is gone, the end is not";
  ASSERT_TRUE(valve.open());
  EXPECT_FALSE(*p.get<bool>("v", "drop"));
}

TEST(PipelineControl, ElementsOfOneNameInTwoBinsCannotBeChosen) {
  Pipeline p = parse(
      "bin.( appsrc name=in ! tensor_sink name=out ) bin.( appsrc name=in ! tensor_sink name=out "
      ")");
  constexpr char kTwo[] = "2 elements of the pipeline have this name\n  offered: name=";
  EXPECT_REFUSED(push(p, "in", 1), OPTION_VALUE, kTwo);
  EXPECT_REFUSED(p.pull<float>("out", kLong), OPTION_VALUE, kTwo);
  EXPECT_REFUSED(p.on_frame("out", [](const weir::Frame&) {}), OPTION_VALUE, kTwo);
  EXPECT_REFUSED(p.on_frame("out", [](const weir::Frame&) {}), OPTION_VALUE,
                 "fix: name=out2 for one of them");
}

TEST(PipelineControl, AnElementOfThePipelineIsChosenBeforeThoseOfItsBins) {
  const std::string bin = "bin.( appsrc name=in block=true ! tensor_sink name=out async=false ) ";
  Pipeline p = parse(bin + "appsrc name=in ! tensor_sink name=out " + bin);
  EXPECT_FALSE(*p.get<bool>("in", "block"));
  ASSERT_TRUE(p.start());
  ASSERT_TRUE(push(p, "in", 1));
  EXPECT_EQ(pulled(p, "out"), 1);
}

TEST(PipelineControl, DiscardsTheFramesOfAllSinksOfOneName) {
  const std::string branch =
      "bin.( videotestsrc num-buffers=100 ! video/x-raw,format=GRAY8,width=4,height=2 ! "
      "tensor_converter ! appsink name=out sync=false max-buffers=1 ) ";
  Pipeline p = parse(branch + branch);
  ASSERT_TRUE(p.discard("out"));
  ASSERT_TRUE(p.start());
  const auto ended = p.wait(kLong);
  ASSERT_TRUE(ended) << ended.error().message();
  EXPECT_TRUE(*ended);
}

TEST(PipelineControl, ASelectorForwardsTheChosenInput) {
  Pipeline p = parse(
      "input-selector name=s sync-streams=false ! tensor_sink name=out "
      "appsrc name=a ! s.sink_0 appsrc name=b ! s.sink_1");
  ASSERT_TRUE(p.selector("s").select("sink_1"));
  ASSERT_TRUE(p.start());
  ASSERT_TRUE(push(p, "a", 1));
  ASSERT_TRUE(push(p, "b", 2));
  EXPECT_EQ(pulled(p, "out"), 2);
}

TEST(PipelineControl, ASelectorSendsToTheChosenOutput) {
  Pipeline p = parse(
      "appsrc name=in ! output-selector name=s pad-negotiation-mode=active "
      "s.src_0 ! tensor_sink name=a async=false s.src_1 ! tensor_sink name=b async=false");
  ASSERT_TRUE(p.selector("s").select("src_1"));
  ASSERT_TRUE(p.start());
  ASSERT_TRUE(push(p, "in", 5));
  EXPECT_EQ(pulled(p, "b"), 5);
  EXPECT_REFUSED(p.selector("s").select("src_7"), OPTION_VALUE, "needed: one of: src_0, src_1");
  EXPECT_REFUSED(p.selector("a").select("src_0"), OPTION_VALUE,
                 "a is not an element that this call is for\n  offered: tensor_sink\n"
                 "  needed: input-selector or output-selector");
}

// GStreamer's output-selector would send a frame in flight to the new pad without caps.
TEST(PipelineControl, AnOutputIsChosenBetweenTwoFrames) {
  Pipeline p = parse(
      "appsrc name=in ! output-selector name=s "
      "s.src_0 ! tensor_sink name=a async=false s.src_1 ! tensor_sink name=b async=false");
  const auto active = [&p] {
    const auto text = p.get("s", "active-pad");
    return text ? *text : text.error().message();
  };
  std::promise<void> arrived, go_on;
  ASSERT_TRUE(p.on_frame("a", [&](const weir::Frame&) {
    arrived.set_value();
    go_on.get_future().wait();
  }));
  ASSERT_TRUE(p.start());
  ASSERT_TRUE(push(p, "in", 1));
  arrived.get_future().wait();
  ASSERT_TRUE(p.selector("s").select("src_1"));
  EXPECT_SAYS(active(), "src_0") << "a frame is on its way";
  go_on.set_value();
  ASSERT_TRUE(push(p, "in", 2));
  EXPECT_EQ(pulled(p, "b"), 2);
  EXPECT_SAYS(active(), "src_1");
}

TEST(PipelineControl, PropertiesAsTextAndTyped) {
  Pipeline p = parse("videotestsrc name=v ! tensor_converter name=c ! tensor_sink name=out");
  ASSERT_TRUE(p.set("v", "pattern", "ball"));
  EXPECT_EQ(*p.get("v", "pattern"), "ball");
  ASSERT_TRUE(p.set("v", "num-buffers", 7));
  EXPECT_EQ(*p.get<int>("v", "num-buffers"), 7);
  ASSERT_TRUE(p.set("v", "is-live", true));
  EXPECT_TRUE(*p.get<bool>("v", "is-live"));
  ASSERT_TRUE(p.set("out", "max-bitrate", uint64_t{1} << 40));
  EXPECT_EQ(*p.get<uint64_t>("out", "max-bitrate"), uint64_t{1} << 40);
  EXPECT_SAYS(*p.get("c", "stats"), "received");
  EXPECT_EQ(*p.get("v", "name"), "v");
}

TEST(PipelineControl, DoublesGoThroughTextUnchanged) {
  Pipeline p = parse("identity name=i ! fakesink");
  for (const float value : {0.1f, 1.0f / 3, 0.0f, 1.0f}) {
    ASSERT_TRUE(p.set("i", "drop-probability", value));
    EXPECT_EQ(*p.get<float>("i", "drop-probability"), value);
  }
}

TEST(PipelineControl, RejectsPropertiesAndValues) {
  Pipeline p = parse("videotestsrc name=v ! tensor_converter name=c ! tensor_sink name=out");
  EXPECT_REFUSED(p.set("v", "patern", "ball"), OPTION_VALUE, "did you mean pattern?");
  EXPECT_REFUSED(p.set("v", "pattern", "football-and-more"), OPTION_VALUE,
                 "videotestsrc does not accept this value for pattern");
  EXPECT_REFUSED(p.set("v", "pattern", "bal"), OPTION_VALUE, "did you mean ball?");
  EXPECT_REFUSED(p.set("v", "horizontal-speed", "fast"), OPTION_VALUE,
                 "needed: a whole number from -2147483648 to 2147483647");
  EXPECT_REFUSED(p.set("out", "signal-rate", 501), OPTION_VALUE,
                 "a value in its range, such as 500");
  EXPECT_REFUSED(p.set("c", "stats", "x"), OPTION_VALUE, "it is read-only");
  EXPECT_REFUSED(p.get<int>("v", "pattern"), OPTION_VALUE, "does not have the requested type");
  EXPECT_REFUSED(p.get("v", "nothing-like-it"), OPTION_VALUE, "videotestsrc has no such property");
  EXPECT_REFUSED(p.get("w", "pattern"), OPTION_VALUE,
                 "no element of the pipeline has this name\n  offered: w\n  needed: one of: ");
}

TEST(PipelineControl, RejectsElementsOfADifferentKind) {
  Pipeline p = parse("appsrc name=in ! tensor_sink name=out");
  ASSERT_TRUE(p.start());
  EXPECT_REFUSED(push(p, "out", 1), OPTION_VALUE, "needed: appsrc");
  EXPECT_REFUSED(push(p, "inn", 1), OPTION_VALUE, "did you mean in?");
  EXPECT_REFUSED(p.pull("in", 1ms), OPTION_VALUE, "needed: tensor_sink or appsink");
  EXPECT_REFUSED(p.end("out"), OPTION_VALUE, "needed: appsrc");
  EXPECT_REFUSED(p.ended("in"), OPTION_VALUE, "needed: tensor_sink or appsink");
  EXPECT_REFUSED(p.valve("in").open(), OPTION_VALUE, "needed: valve");
  EXPECT_REFUSED(p.on_frame("in", [](const weir::Frame&) {}), OPTION_VALUE,
                 "tensor_sink or appsink");
}

TEST(PipelineControl, RejectsInvalidDescriptions) {
  EXPECT_REFUSED(Pipeline::parse("tensor_filtre ! fakesink"), OPTION_VALUE,
                 "first difference: did you mean tensor_filter?");
  EXPECT_REFUSED(Pipeline::parse("videotestsrc ! tensor_filter"), OPTION_SYNTAX,
                 "fix: weir run 'videotestsrc ! tensor_filter'");
  EXPECT_REFUSED(Pipeline::parse("fakesrc ! "), OPTION_SYNTAX,
                 "a description that gst-launch-1.0 accepts");
  EXPECT_REFUSED(Pipeline::parse(""), OPTION_SYNTAX, "a description that gst-launch-1.0 accepts");
  EXPECT_REFUSED(Pipeline::parse("fakesrc nothing=1 ! fakesink"), OPTION_VALUE,
                 "fakesrc has no such property\n  offered: nothing");
  EXPECT_REFUSED(Pipeline::parse("videotestsrc patern=ball ! fakesink"), OPTION_VALUE,
                 "did you mean pattern?");
  EXPECT_REFUSED(Pipeline::parse("fakesrc ! queue leaky=upstraem ! fakesink"), OPTION_VALUE,
                 "queue does not accept this value for leaky\n  offered: upstraem\n"
                 "  needed: one of: no, upstream, downstream\n"
                 "  first difference: did you mean upstream?");
  EXPECT_REFUSED(Pipeline::parse("fakesrc ! ! fakesink"), OPTION_SYNTAX,
                 "a description that gst-launch-1.0 accepts");
}

TEST(PipelineControl, RejectsIncompleteFrames) {
  Pipeline p = parse("appsrc name=in ! tensor_sink name=out");
  ASSERT_TRUE(p.start());
  const Values x{1, 2};
  EXPECT_REFUSED(p.push("in", std::span<const float>(x)), SPEC_MISMATCH,
                 "tensor 0 has no shape, and the caps of the appsrc do not define it");
  EXPECT_REFUSED(p.push("in", std::span<const float>(x), {.shape = {3}}), FRAME_SIZE,
                 "offered: 8 bytes\n  needed: 12 bytes: float32 3");
  EXPECT_REFUSED(p.push("in", std::span<const float>(x), {.shape = {2, -1}}), SPEC_MISMATCH,
                 "an extent of -1");
  EXPECT_REFUSED(p.push("in", std::span<const weir::TensorView>()), LIMIT_EXCEEDED, "1 to 256");
  const std::vector<weir::TensorView> odd{weir::TensorView(x.data(), 8, 77, {2})};
  EXPECT_REFUSED(p.push("in", odd), TYPE_SYNTAX, "an unknown type");
}

TEST(PipelineControl, ErrorsOfElementsFailEveryCallUntilStop) {
  Pipeline p = parse(
      "appsrc name=in ! tensor_filter framework=fake model=/proc/self/comm name=f ! tensor_sink "
      "name=out");
  ASSERT_TRUE(p.start());
  const Values x{1, 2, 3};
  ASSERT_TRUE(p.push("in", std::span<const float>(x), {.shape = {1, 3}}));
  EXPECT_REFUSED(p.pull<float>("out", kLong), SPEC_MISMATCH,
                 "WEIR-2001: f: the stream does not fit");
  EXPECT_REFUSED(p.wait(kLong), SPEC_MISMATCH, "needed: 1 tensor: float32 4:?");
  EXPECT_REFUSED(push(p, "in", 1), SPEC_MISMATCH, "f: the stream does not fit");
  EXPECT_REFUSED(p.start(), SPEC_MISMATCH, "f: the stream does not fit");
  ASSERT_TRUE(p.stop());
  ASSERT_TRUE(p.start());
  const Values four{1, 2, 3, 4};
  const auto again = p.push("in", std::span<const float>(four), {.shape = {1, 4}});
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(pulled(p, "out"), 2);
}

TEST(PipelineControl, ErrorsOfForeignElementsHaveACode) {
  Pipeline p = parse("filesrc name=f ! fakesink");
  EXPECT_REFUSED(p.start(), FILE_NOT_FOUND, "f: No file name specified for reading");
}

TEST(PipelineControl, ErrorsAboutFilesNameTheFileAndASimilarOne) {
  const std::string folder = testing::TempDir();
  std::ofstream(folder + "street.raw") << "x";
  Pipeline p = parse("filesrc name=f location=" + folder + "stret.raw ! fakesink");
  EXPECT_REFUSED(p.start(), FILE_NOT_FOUND,
                 "f: the file does not exist\n  offered: location=" + folder +
                     "stret.raw\n  needed: the path of a file\n"
                     "  first difference: did you mean street.raw?\n  fix: location=" +
                     folder + "street.raw");
  Pipeline sink = parse("fakesrc num-buffers=1 ! filesink name=f location=" + folder + "none/out");
  EXPECT_REFUSED(sink.start(), FILE_NOT_WRITTEN, "f: the folder of the file does not exist");
}

TEST(PipelineControl, RejectsReadingAFrameAsADifferentType) {
  Pipeline p = parse("appsrc name=in ! tensor_sink name=out");
  ASSERT_TRUE(p.start());
  ASSERT_TRUE(push(p, "in", 1));
  EXPECT_REFUSED(p.pull<uint8_t>("out", kLong), SPEC_MISMATCH, "the tensor has a different type");
}

TEST(PipelineControl, SparseFramesNameTheElementThatIsMissing) {
  Pipeline p = parse("appsrc name=in ! tensor_sparse_enc ! tensor_sink name=out");
  ASSERT_TRUE(p.start());
  ASSERT_TRUE(push(p, "in", 1));
  EXPECT_REFUSED(p.pull<float>("out", kLong), FORMAT_UNSUPPORTED,
                 "fix: tensor_sparse_dec before the sink");
}

TEST(PipelineControl, NullPointersAreErrors) {
  weir_pipeline* p = nullptr;
  EXPECT_EQ(weir_pipeline_parse(nullptr, &p, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_pipeline_parse("fakesrc ! fakesink", nullptr, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_pipeline_start(nullptr, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_pipeline_get_state(nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_pipeline_wait(nullptr, 0, nullptr), -WEIR_OPTION_VALUE);
  ASSERT_EQ(weir_pipeline_parse("appsrc name=in ! fakesink", &p, nullptr), WEIR_OK);
  weir_pulled* frame = nullptr;
  char* text = nullptr;
  EXPECT_EQ(weir_pipeline_push(p, "in", nullptr, 1, -1, -1, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_pipeline_pull(p, nullptr, 0, &frame, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_pipeline_pull(p, "in", 0, nullptr, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_pipeline_set(p, "in", "blocksize", nullptr, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_pipeline_get(p, "in", nullptr, &text, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_pipeline_get(p, nullptr, "blocksize", &text, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_pipeline_select(p, "in", nullptr, nullptr), -WEIR_OPTION_VALUE);
  EXPECT_EQ(weir_pipeline_set_valve(p, nullptr, 1, nullptr), -WEIR_OPTION_VALUE);
  weir_pipeline_free(p);
  weir_pipeline_free(nullptr);
  weir_pulled_free(nullptr);
  weir_pipeline_text_free(nullptr);
}

}  // namespace pipeline_control_test
