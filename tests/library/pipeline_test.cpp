// Tests of pipeline.hpp with the shared library: frames in and out, errors as values.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "weir/pipeline.hpp"

#include <gst/gst.h>
#include <gtest/gtest.h>

#include <array>
#include <future>
#include <thread>

#include "becomes.hpp"
#include "pipeline_test_support.hpp"
#include "says.hpp"
#include "weir/custom_condition.hpp"

namespace pipeline_test {

using namespace std::chrono_literals;
using namespace weir::pipeline_test;
using weir::Code;
using weir::Frame;
using weir::Pipeline;
using weir::PipelineState;
using weir::TensorShape;
using weir::TensorView;
using Values = std::vector<float>;

std::span<const float> span(const Values& values) {
  return values;
}

TEST(Pipeline, PushesThroughAModelAndPulls) {
  Pipeline p = started(
      "appsrc name=in ! tensor_filter framework=fake model=/proc/self/comm ! tensor_sink name=out");
  const Values x{1, 2, 3, 4};
  for (int i = 0; i < 3; ++i)
    ASSERT_TRUE(p.push("in", span(x), {.shape = {1, 4}, .pts = i * 10ms, .duration = 10ms}));
  for (int i = 0; i < 3; ++i) {
    const auto frame = p.pull<float>("out", kLong);
    ASSERT_TRUE(frame) << frame.error().message();
    ASSERT_TRUE(*frame);
    EXPECT_EQ((*frame)->pts(), i * 10ms);
    EXPECT_EQ((*frame)->duration(), 10ms);
    ASSERT_EQ((*frame)->size(), 1u);
    EXPECT_EQ((**frame)[0].info().type, WEIR_FLOAT32);
    EXPECT_EQ((**frame)[0].info().elements(), 4);
    const auto y = *(**frame)[0].as<float>();
    EXPECT_EQ(Values(y.begin(), y.end()), (Values{2, 3, 4, 5}));
  }
  EXPECT_FALSE(*p.ended("out"));
  ASSERT_TRUE(p.end("in"));
  const auto last = p.pull("out", kLong);
  ASSERT_TRUE(last) << last.error().message();
  EXPECT_FALSE(*last);
  EXPECT_TRUE(*p.ended("out"));
  const auto ended = p.wait(kLong);
  ASSERT_TRUE(ended) << ended.error().message();
  EXPECT_TRUE(*ended);
  EXPECT_REFUSED(p.push("in", span(x), {.shape = {1, 4}}), CANCELLED, "the stream has ended");
}

TEST(Pipeline, PushesFramesOfManyTensors) {
  for (const size_t count : {size_t{2}, size_t{16}, size_t{20}}) {
    Pipeline p = started("appsrc name=in ! tensor_sink name=out");
    std::vector<std::vector<int16_t>> data;
    for (size_t i = 0; i < count; ++i) data.emplace_back(i + 1, static_cast<int16_t>(i));
    std::vector<TensorView> views;
    for (const auto& one : data)
      views.emplace_back(one, TensorShape{static_cast<int64_t>(one.size())});
    ASSERT_TRUE(p.push("in", views));
    const auto frame = p.pull<int16_t>("out", kLong);
    ASSERT_TRUE(frame) << frame.error().message();
    ASSERT_EQ((*frame)->size(), count);
    for (size_t i = 0; i < count; ++i) {
      const auto got = *(**frame)[i].as<int16_t>();
      EXPECT_EQ(std::vector<int16_t>(got.begin(), got.end()), data[i]) << i << " of " << count;
    }
  }
}

TEST(Pipeline, PullsTheBytesOfSeveralMemoriesWithoutTensorCaps) {
  Pipeline p = started("appsrc name=in ! tensor_decoder mode=octet_stream ! appsink name=out");
  const std::array<uint8_t, 3> first{1, 2, 3};
  const std::array<uint8_t, 2> second{4, 5};
  std::vector<TensorView> views;
  views.emplace_back(first, TensorShape{3});
  views.emplace_back(second, TensorShape{2});
  ASSERT_TRUE(p.push("in", views));
  const auto frame = p.pull<uint8_t>("out", kLong);
  ASSERT_TRUE(frame) << frame.error().message();
  ASSERT_EQ((*frame)->size(), 1u);
  EXPECT_EQ((**frame)[0].info().shape, (TensorShape{5}));
  const auto bytes = *(**frame)[0].as<uint8_t>();
  EXPECT_EQ(std::vector<uint8_t>(bytes.begin(), bytes.end()),
            (std::vector<uint8_t>{1, 2, 3, 4, 5}));
}

TEST(Pipeline, WritesNewCapsWhenShapesChange) {
  Pipeline p = started("appsrc name=in ! tensor_sink name=out");
  const Values x{1, 2, 3, 4, 5, 6};
  ASSERT_TRUE(p.push("in", span(x), {.shape = {2, 3}}));
  ASSERT_TRUE(p.push("in", span(x), {.shape = {6}}));
  EXPECT_EQ((**p.pull("out", kLong))[0].info().shape, (TensorShape{2, 3}));
  EXPECT_EQ((**p.pull("out", kLong))[0].info().shape, (TensorShape{6}));
}

TEST(Pipeline, UsesTheShapeOfTheCapsInTheDescription) {
  Pipeline p = started(
      "appsrc name=in caps=other/tensors,format=static,num_tensors=1,dimensions=(string)2:1,"
      "types=float32,framerate=0/1 ! tensor_sink name=out");
  ASSERT_TRUE(p.push("in", span({7, 8})));
  EXPECT_EQ(pulled(p, "out"), (Values{7, 8}));
  EXPECT_REFUSED(p.push("in", span({7, 8, 9})), FRAME_SIZE, "offered: 12 bytes\n  needed: 8 bytes");
  EXPECT_REFUSED(p.push("in", span({7, 8, 9}), {.shape = {1, 3}}), SPEC_MISMATCH,
                 "tensor 0 does not match the caps of the appsrc");
  const std::array<int32_t, 2> integers{7, 8};
  EXPECT_REFUSED(p.push("in", std::span<const int32_t>(integers)), SPEC_MISMATCH,
                 "type is int32, needed is float32");
  const std::vector<TensorView> two{integers, integers};
  EXPECT_REFUSED(p.push("in", two), SPEC_MISMATCH, "number of tensors");
}

TEST(Pipeline, PushesFlexibleTensors) {
  Pipeline p = started(
      "appsrc name=in caps=other/tensors,format=flexible,framerate=0/1 ! tensor_sink name=out");
  ASSERT_TRUE(p.push("in", span({1, 2, 3}), {.shape = {3}}));
  ASSERT_TRUE(p.push("in", span({4}), {.shape = {1, 1}}));
  EXPECT_EQ(pulled(p, "out"), (Values{1, 2, 3}));
  EXPECT_EQ(pulled(p, "out"), (Values{4}));
}

TEST(Pipeline, PushesPicturesAndPullsBytes) {
  Pipeline p = started(
      "appsrc name=in caps=video/x-raw,format=GRAY8,width=4,height=2,framerate=30/1 ! "
      "tee name=t ! queue ! appsink name=raw t. ! queue ! tensor_converter ! tensor_sink name=out");
  const std::vector<uint8_t> picture{1, 2, 3, 4, 5, 6, 7, 8};
  ASSERT_TRUE(p.push("in", std::span<const uint8_t>(picture), {.pts = 0ns}));
  const auto raw = p.pull<uint8_t>("raw", kLong), out = p.pull<uint8_t>("out", kLong);
  ASSERT_TRUE(raw && *raw && out && *out);
  EXPECT_EQ((**raw)[0].info().shape, (TensorShape{8}));
  EXPECT_EQ((*raw)->caps().substr(0, 11), "video/x-raw");
  EXPECT_EQ((**out)[0].info().elements(), 8);
  const std::vector<uint8_t> half(4);
  EXPECT_REFUSED(p.push("in", std::span<const uint8_t>(half)), FRAME_SIZE,
                 "a picture's size does not match");
  ASSERT_TRUE(p.push("in", span({1, 2})));  // 8 bytes too
  EXPECT_EQ((**p.pull("out", kLong))[0].bytes().size(), 8u);
}

// A capsfilter after the appsrc states what is pushed, as NNStreamer's programs do it.
TEST(Pipeline, TakesTheCapsOfACapsfilter) {
  const std::string one =
      "other/tensors,format=static,num_tensors=1,dimensions=4:1:1:1,types=uint8";
  const std::vector<uint8_t> x{1, 2, 3, 4};
  const std::vector<std::pair<std::string, std::string>> cases{
      {"other/tensor,dimension=4:1:1:1,type=uint8,framerate=0/1", "framerate=(fraction)0/1"},
      {"other/tensor,dimension=4:1:1:1,type=uint8,framerate=30/1", "framerate=(fraction)30/1"},
      {(one + ",framerate=30/1"), "framerate=(fraction)30/1"},
      {one, "framerate=(fraction)0/1"},
      {"other/tensors,format=flexible,framerate=30/1", "framerate=(fraction)30/1"},
      {"other/tensors,format=flexible", "format=(string)flexible"},
      {"other/tensors,format=static,framerate=25/1", "framerate=(fraction)25/1"},
      {"application/octet-stream", "application/octet-stream"},
      {"other/tensor", "other/tensor,"},
      {"other/tensor,framerate=[1/1,60/1]", "framerate=(fraction)1/1"},
      {"text/x-raw,format=utf8", "text/x-raw"},
      {"video/x-raw,format=GRAY8,width=4,height=1,framerate=0/1", "video/x-raw"},
  };
  for (const auto& [caps, sent] : cases) {
    SCOPED_TRACE(caps);
    Pipeline p = started("appsrc name=in ! " + caps + " ! appsink name=out");
    for (int round = 0; round < 2; ++round) {
      ASSERT_TRUE(p.push("in", std::span<const uint8_t>(x), {.shape = {1, 1, 1, 4}}));
      const auto frame = p.pull<uint8_t>("out", kLong);
      ASSERT_TRUE(frame && *frame);
      EXPECT_SAYS((*frame)->caps(), sent);
      const auto got = *(**frame)[0].as<uint8_t>();
      EXPECT_EQ(std::vector<uint8_t>(got.begin(), got.end()), x);
      ASSERT_TRUE(p.stop() && p.start());
    }
  }
  Pipeline p = started("appsrc name=in ! " + one + " ! tensor_sink name=out");
  ASSERT_TRUE(p.push("in", span({1}), {.shape = {1, 1, 1, 1}})) << "types are not compared";
  EXPECT_REFUSED(p.push("in", span({1, 2}), {.shape = {1, 1, 1, 2}}), SPEC_MISMATCH,
                 "tensor 0 does not match the caps of the appsrc");
}

TEST(Pipeline, FollowsACapsfilterThatChanges) {
  const std::string caps =
      "other/tensors,format=static,num_tensors=1,types=uint8,dimensions=(string)";
  Pipeline p =
      started("appsrc name=in ! capsfilter name=cf caps=" + caps + "4:1 ! tensor_sink name=out");
  for (const size_t size : {4, 6}) {
    ASSERT_TRUE(p.set("cf", "caps", caps + std::to_string(size) + ":1"));
    const std::vector<uint8_t> x(size, 7);
    const auto pushed = p.push("in", std::span<const uint8_t>(x));
    ASSERT_TRUE(pushed) << pushed.error().message();
    EXPECT_EQ((**p.pull("out", kLong))[0].bytes().size(), size);
  }
}

TEST(Pipeline, PushesManyPartsOfMedia) {
  for (const size_t count : {16, 17}) {
    Pipeline p = started("appsrc name=in ! application/octet-stream ! appsink name=out");
    const std::vector<uint8_t> part{1, 2, 3, 4};
    const std::vector<TensorView> parts(count, TensorView(part, TensorShape{4}));
    ASSERT_TRUE(p.push("in", parts));
    EXPECT_EQ((**p.pull("out", kLong))[0].bytes().size(), 4 * count);
  }
}

// GStreamer pads each row of RGB to 4 bytes; programs have arrays without padding.
TEST(Pipeline, PushesPicturesWithoutPadding) {
  for (const auto& [format, bytes] :
       {std::pair{"RGB", 10 * 4 * 3}, {"GRAY8", 10 * 4}, {"I420", 10 * 4 + 2 * 5 * 2}}) {
    SCOPED_TRACE(format);
    Pipeline p = started(
        std::string("appsrc name=in caps=video/x-raw,width=10,height=4,framerate=0/1,format=") +
        format +
        " ! videoconvert ! video/x-raw,format=GRAY8 ! tensor_converter ! tensor_sink name=out");
    std::vector<uint8_t> picture(static_cast<size_t>(bytes), 128);
    std::fill_n(picture.begin(), format == std::string("RGB") ? 3 : 1, 255);
    ASSERT_TRUE(p.push("in", std::span<const uint8_t>(picture)));
    const auto frame = p.pull<uint8_t>("out", kLong);
    ASSERT_TRUE(frame && *frame);
    const auto gray = *(**frame)[0].as<uint8_t>();
    ASSERT_EQ(gray.size(), 40u);
    EXPECT_GT(gray[0], gray[1] + 50);
    for (size_t i = 2; i < 40; ++i) EXPECT_EQ(gray[i], gray[1]) << i;
    picture.pop_back();
    EXPECT_REFUSED(p.push("in", std::span<const uint8_t>(picture)), FRAME_SIZE,
                   "needed: " + std::to_string(bytes) + " bytes");
  }
}

TEST(Pipeline, FollowsTheCapsThatTheProgramSets) {
  const std::string caps = "video/x-raw,format=GRAY8,height=2,framerate=10/1,width=";
  Pipeline p =
      started("appsrc name=in caps=" + caps + "4 ! tensor_converter ! tensor_sink name=out");
  for (const size_t width : {4, 8, 12}) {
    ASSERT_TRUE(p.set("in", "caps", caps + std::to_string(width)));
    const std::vector<uint8_t> pixels(2 * width, 7), fewer(2 * width - 4);
    EXPECT_REFUSED(p.push("in", std::span<const uint8_t>(fewer)), FRAME_SIZE,
                   "needed: " + std::to_string(2 * width) + " bytes");
    ASSERT_TRUE(p.push("in", std::span<const uint8_t>(pixels)));
    const auto frame = p.pull("out", kLong);
    ASSERT_TRUE(frame && *frame);
    EXPECT_EQ((**frame)[0].bytes().size(), 2 * width);
  }
}

// Sparse frames cannot be pulled, and a tensor_sink queues 64.
TEST(Pipeline, DiscardsFramesUnread) {
  for (const char* sink : {"tensor_sink", "appsink sync=false"}) {
    auto p = Pipeline::parse(
        std::string("videotestsrc num-buffers=100 ! video/x-raw,format=GRAY8,width=8,height=8 ! "
                    "tensor_converter ! tensor_sparse_enc ! ") +
        sink + " name=out");
    ASSERT_TRUE(p) << p.error().message();
    ASSERT_TRUE(p->discard("out"));
    ASSERT_TRUE(p->start());
    const auto ended = p->wait(kLong);
    ASSERT_TRUE(ended) << ended.error().message();
    EXPECT_TRUE(*ended) << sink;
    EXPECT_REFUSED(p->discard("out"), OPTION_VALUE,
                   "fix: pipeline.discard(...) before pipeline.start()");
    ASSERT_TRUE(p->stop());
    EXPECT_REFUSED(p->discard("none"), OPTION_VALUE, "none");
  }
}

TEST(Pipeline, PassesEveryMessageOn) {
  ASSERT_TRUE(gst_init_check(nullptr, nullptr, nullptr));
  GstElement* made = gst_parse_launch("fakesrc num-buffers=2 ! fakesink name=out", nullptr);
  ASSERT_TRUE(made);
  auto p = Pipeline::adopt(made);
  ASSERT_TRUE(p) << p.error().message();
  GstBus* bus = gst_bus_new();
  ASSERT_TRUE(
      p->on_message([bus](GstMessage* message) { gst_bus_post(bus, gst_message_ref(message)); }));
  ASSERT_TRUE(p->start());
  EXPECT_REFUSED(p->on_message({}), OPTION_VALUE, "fix: weir_pipeline_stop(pipeline, NULL)");
  GstMessage* end = gst_bus_timed_pop_filtered(bus, GST_CLOCK_TIME_NONE, GST_MESSAGE_EOS);
  ASSERT_TRUE(end);
  gst_message_unref(end);
  ASSERT_TRUE(p->stop());
  ASSERT_TRUE(p->on_message({}));
  gst_bus_set_flushing(bus, TRUE);
  gst_bus_set_flushing(bus, FALSE);
  ASSERT_TRUE(p->start());
  ASSERT_TRUE(p->wait(kLong));
  EXPECT_FALSE(gst_bus_have_pending(bus));
  gst_object_unref(bus);
}

TEST(Pipeline, PassesMessagesOfTheProgramOn) {
  ASSERT_TRUE(gst_init_check(nullptr, nullptr, nullptr));
  GstElement* made = gst_parse_launch("fakesrc num-buffers=2 ! fakesink", nullptr);
  ASSERT_TRUE(made);
  auto p = Pipeline::adopt(made);
  ASSERT_TRUE(p) << p.error().message();
  std::string name;
  weir::Status inside = weir::ok();
  ASSERT_TRUE(p->on_message([&](GstMessage* message) {
    if (GST_MESSAGE_TYPE(message) != GST_MESSAGE_APPLICATION) return;
    name = gst_structure_get_name(gst_message_get_structure(message));
    inside = p->stop();
  }));
  gst_element_post_message(
      made, gst_message_new_application(GST_OBJECT(made), gst_structure_new_empty("mine")));
  EXPECT_EQ(name, "mine");
  EXPECT_REFUSED(inside, CANCELLED, "a callback cannot change the state of its own pipeline");
}

TEST(Pipeline, FollowsTheStateAndTheClockThatElementsAskFor) {
  ASSERT_TRUE(gst_init_check(nullptr, nullptr, nullptr));
  GstElement* made = gst_parse_launch("fakesrc is-live=true ! fakesink", nullptr);
  ASSERT_TRUE(made);
  auto p = Pipeline::adopt(made);
  ASSERT_TRUE(p) << p.error().message();
  const auto post = [made](GstMessage* message) { gst_element_post_message(made, message); };
  const auto comes_to = [made](GstState wanted) {
    const auto is_there = [made, wanted] {
      GstState state = GST_STATE_NULL, next = GST_STATE_VOID_PENDING;
      gst_element_get_state(made, &state, &next, 0);
      return state == wanted && next == GST_STATE_VOID_PENDING;
    };
    return becomes_true(is_there, gst_element_state_get_name(wanted));
  };
  ASSERT_TRUE(p->start());
  ASSERT_TRUE(comes_to(GST_STATE_PLAYING));
  post(gst_message_new_request_state(GST_OBJECT(made), GST_STATE_PAUSED));
  EXPECT_TRUE(comes_to(GST_STATE_PAUSED));
  post(gst_message_new_request_state(GST_OBJECT(made), GST_STATE_PLAYING));
  EXPECT_TRUE(comes_to(GST_STATE_PLAYING));
  const auto before = gst_element_get_base_time(made);
  post(gst_message_new_clock_lost(GST_OBJECT(made), GST_ELEMENT_CLOCK(made)));
  EXPECT_TRUE(
      becomes_true([&] { return gst_element_get_base_time(made) != before; }, "another base time"));
  EXPECT_TRUE(comes_to(GST_STATE_PLAYING));
  ASSERT_TRUE(p->stop());
  // Requests are followed on another thread, which holds a reference until it is done.
  const auto all_are_followed = [made] {
    return becomes_true([made] { return GST_OBJECT_REFCOUNT_VALUE(made) == 1; }, "one reference");
  };
  ASSERT_TRUE(all_are_followed());
  post(gst_message_new_request_state(GST_OBJECT(made), GST_STATE_PLAYING));
  ASSERT_TRUE(all_are_followed());
  EXPECT_EQ(GST_STATE(made), GST_STATE_NULL) << "a stopped pipeline stays stopped";
}

TEST(Pipeline, KeepsFramesUntilTheyArePulledAndLosesNone) {
  Pipeline p = started("appsrc name=in ! tensor_sink name=out");
  for (float i = 0; i < 200; ++i) ASSERT_TRUE(p.push("in", span({i}), {.shape = {1}}));
  ASSERT_TRUE(p.end("in"));
  const auto early = p.wait(20ms);
  ASSERT_TRUE(early) << early.error().message();
  EXPECT_FALSE(*early) << "the stream waits with frame 65";
  for (float i = 0; i < 200; ++i) ASSERT_EQ(pulled(p, "out"), (Values{i}));
  EXPECT_TRUE(*p.wait(kLong));
}

TEST(Pipeline, AppsinkDropsTheOldestIfConfigured) {
  Pipeline p = started("appsrc name=in ! appsink name=out max-buffers=2 drop=true");
  for (float i = 0; i < 10; ++i) ASSERT_TRUE(p.push("in", span({i}), {.shape = {1}}));
  ASSERT_TRUE(p.end("in"));
  EXPECT_TRUE(*p.wait(kLong));
  EXPECT_EQ(pulled(p, "out"), (Values{8}));
  EXPECT_EQ(pulled(p, "out"), (Values{9}));
  EXPECT_EQ(pulled(p, "out"), (Values{}));
}

TEST(Pipeline, PullReturnsWhenTheTimeHasPassed) {
  Pipeline p = started("appsrc name=in ! tensor_sink name=out");
  const auto nothing = p.pull("out", 1ms);
  ASSERT_TRUE(nothing) << nothing.error().message();
  EXPECT_FALSE(*nothing);
  EXPECT_FALSE(*p.ended("out"));
}

TEST(Pipeline, CallsAFunctionForEachFrame) {
  Pipeline p = parse("appsrc name=in ! tensor_sink name=out");
  std::vector<Frame> kept;
  ASSERT_TRUE(p.on_frame("out", [&](const Frame& frame) { kept.push_back(frame); }));
  ASSERT_TRUE(p.start());
  for (float i = 0; i < 100; ++i) ASSERT_TRUE(p.push("in", span({i}), {.shape = {1}}));
  ASSERT_TRUE(p.end("in"));
  ASSERT_TRUE(*p.wait(kLong));
  ASSERT_EQ(kept.size(), 100u);
  EXPECT_EQ((*kept[99][0].as<float>())[0], 99);
  EXPECT_REFUSED(p.on_frame("out", {}), OPTION_VALUE,
                 "can only be set while the pipeline is stopped");
  ASSERT_TRUE(p.stop());
  ASSERT_TRUE(p.on_frame("out", {}));
}

TEST(Pipeline, AFunctionThatThrowsEndsTheStreamWithItsMessage) {
  Pipeline p = parse("appsrc name=in ! tensor_sink name=out");
  ASSERT_TRUE(p.on_frame("out", [](const Frame&) { throw std::runtime_error("no more"); }));
  ASSERT_TRUE(p.start());
  ASSERT_TRUE(p.push("in", span({1}), {.shape = {1}}));
  EXPECT_REFUSED(p.wait(kLong), CALLBACK_FAILED, "out: the callback for frames failed: no more");
}

// Errors of other elements follow from one of Weir's, also where they come first.
TEST(Pipeline, FailsWithTheErrorThatHasACode) {
  ASSERT_TRUE(gst_init_check(nullptr, nullptr, nullptr));
  GstElement* made = gst_parse_launch("appsrc name=in ! tensor_sink name=out", nullptr);
  ASSERT_TRUE(made);
  GstElement* source = gst_bin_get_by_name(GST_BIN(made), "in");
  {
    auto p = Pipeline::adopt(made);
    ASSERT_TRUE(p) << p.error().message();
    ASSERT_TRUE(p->on_frame("out", [&](const Frame&) {
      GST_ELEMENT_ERROR(source, STREAM, FAILED, ("what follows"), (nullptr));
      throw std::runtime_error("the cause");
    }));
    ASSERT_TRUE(p->start());
    ASSERT_TRUE(p->push("in", span({1}), {.shape = {1}}));
    std::vector<std::string> posted;
    const auto come = [&] {
      while (const auto message = p->read_message()) posted.push_back(message->error.what);
      return posted.size() >= 2;
    };
    ASSERT_TRUE(becomes_true(come, "two errors"));
    EXPECT_EQ(posted[0], "in: what follows");
    EXPECT_REFUSED(p->wait(kLong), CALLBACK_FAILED,
                   "out: the callback for frames failed: the cause");
    ASSERT_TRUE(p->stop());
    EXPECT_TRUE(p->start()) << "no error is left";
  }
  gst_object_unref(source);
}

TEST(Pipeline, ReturnsWarningsAsMessages) {
  Pipeline p = started(
      "appsrc name=in ! tensor_filter name=nn framework=fake model=/proc/self/comm ! "
      "tensor_sink name=out");
  EXPECT_FALSE(p.read_message());
  ASSERT_TRUE(p.set("nn", "model", "/proc/self/stat"));
  const auto warning = p.read_message();
  ASSERT_TRUE(warning);
  EXPECT_FALSE(warning->is_error);
  EXPECT_EQ(warning->error.code, Code::OPTION_VALUE);
  EXPECT_SAYS(warning->error.what, "nn: the model takes effect at the next start");
  EXPECT_EQ(warning->error.offered, "model=/proc/self/stat");
  EXPECT_FALSE(p.read_message());
}

TEST(Pipeline, AValueThatARunningElementRejectsIsAnError) {
  Pipeline p = started(
      "appsrc name=in ! tensor_aggregator name=windows frames-out=2 frames-dim=1 ! tensor_filter "
      "name=nn framework=fake model=/proc/self/comm is-updatable=true ! tensor_sink name=out");
  EXPECT_REFUSED(p.set("nn", "model", "nope.onnx"), MODEL_NOT_FOUND, "nn: the model file");
  EXPECT_EQ(*p.get("nn", "model"), "/proc/self/comm");
  ASSERT_TRUE(p.push("in", span({1, 2, 3, 4}), {.shape = {1, 4}}));
  ASSERT_TRUE(p.push("in", span({1, 2, 3, 4}), {.shape = {1, 4}}));
  ASSERT_TRUE(p.pull("out", kLong));
  EXPECT_REFUSED(p.set("windows", "frames-dim", 9), OPTION_VALUE,
                 "windows: frames-dim is beyond the dimensions of the tensors: the value was "
                 "rejected, and the old one stays");
  EXPECT_EQ(*p.get<int>("windows", "frames-dim"), 1);
  EXPECT_FALSE(p.read_message()) << "the error is not a warning too";
}

TEST(Pipeline, KeepsTheNewestMessagesUntilTheyAreRead) {
  Pipeline p = started(
      "appsrc name=in ! tensor_filter name=nn framework=fake model=/proc/self/comm ! "
      "tensor_sink name=out");
  for (int i = 0; i < 70; ++i) ASSERT_TRUE(p.set("nn", "model", std::to_string(i)));
  ASSERT_TRUE(p.stop());
  for (int i = 6; i < 70; ++i) {
    const auto message = p.read_message();
    ASSERT_TRUE(message);
    EXPECT_EQ(message->error.offered, "model=" + std::to_string(i));
  }
  EXPECT_FALSE(p.read_message());
}

TEST(Pipeline, ReturnsAllErrorsAsMessages) {
  Pipeline p = started(
      "appsrc name=in ! tensor_filter name=nn framework=fake model=/proc/self/comm ! "
      "tensor_sink name=out");
  const Values x{1, 2, 3, 4, 5};
  ASSERT_TRUE(p.push("in", span(x), {.shape = {5}}));
  const auto ended = p.wait(kLong);
  ASSERT_FALSE(ended);
  const auto first = p.read_message();
  ASSERT_TRUE(first && first->is_error);
  EXPECT_EQ(first->error.message(), ended.error().message());
  EXPECT_SAYS(first->error.what, "nn: ");
  std::optional<weir::PipelineMessage> second;
  ASSERT_TRUE(becomes_true([&] { return (second = p.read_message()).has_value(); }, "a message"));
  EXPECT_TRUE(second->is_error);
  EXPECT_SAYS(second->error.what, "in: ");  // its stream ends with an error of its own
}

TEST(Pipeline, CanBeMovedAndDestroyedWhileFramesFlow) {
  std::atomic<int> calls = 0;
  {
    Pipeline p = parse("appsrc name=in ! tensor_sink name=out");
    ASSERT_TRUE(p.on_frame("out", [&](const Frame&) { ++calls; }));
    ASSERT_TRUE(p.start());
    for (float i = 0; i < 1000; ++i) ASSERT_TRUE(p.push("in", span({i}), {.shape = {1}}));
    Pipeline moved = std::move(p);
    p = started("appsrc name=in ! tensor_sink name=out");
    p = std::move(moved);
    ASSERT_TRUE(p.push("in", span({1}), {.shape = {1}}));
  }
  const int at_the_end = calls;
  EXPECT_LE(at_the_end, 1001);
  EXPECT_EQ(calls, at_the_end);
}

TEST(Pipeline, StopsDuringAPull) {
  Pipeline p = started("appsrc name=in ! tensor_sink name=out");
  std::promise<void> began;
  std::jthread puller([&] {
    began.set_value();
    EXPECT_REFUSED(p.pull("out"), CANCELLED, "is stopped and processes no frames");
  });
  began.get_future().wait();
  ASSERT_TRUE(p.stop());
}

// Threads that wait for space or for each other, or are about to push: none pushes into a stopped
// pipeline.
TEST(Pipeline, StopsWhileThreadsPush) {
  for (int i = 0; i < 100; ++i) {
    Pipeline p = started("appsrc name=in block=true max-buffers=1 ! tensor_sink name=out");
    std::vector<std::jthread> pushers;
    for (int thread = 0; thread < 4; ++thread)
      pushers.emplace_back([&] {
        while (p.push("in", span({1}), {.shape = {1}})) {
        }
      });
    pulled(p, "out");
    ASSERT_TRUE(p.stop());
  }
}

TEST(Pipeline, StartsAgainAfterAStop) {
  Pipeline p = parse("appsrc name=in ! tensor_sink name=out");
  EXPECT_EQ(p.state(), PipelineState::Stopped);
  for (float i = 0; i < 3; ++i) {
    ASSERT_TRUE(p.start());
    EXPECT_EQ(p.state(), PipelineState::Playing);
    ASSERT_TRUE(p.push("in", span({i}), {.shape = {1}}));
    EXPECT_EQ(pulled(p, "out"), (Values{i}));
    ASSERT_TRUE(p.pause());
    EXPECT_EQ(p.state(), PipelineState::Paused);
    ASSERT_TRUE(p.stop());
    EXPECT_EQ(p.state(), PipelineState::Stopped);
  }
  EXPECT_REFUSED(p.push("in", span({1}), {.shape = {1}}), CANCELLED, "fix: pipeline.start()");
  EXPECT_REFUSED(p.pull("out", 1ms), CANCELLED, "the pipeline is stopped and processes no frames");
}

// The plug-in and this program share one registry of conditions.
TEST(Pipeline, CallsAConditionThatTheProgramRegistered) {
  const weir::RegisteredCondition above("above-two", [](const weir_frame& frame) {
    return *static_cast<const float*>(frame.tensors[0].data) > 2;
  });
  Pipeline p = started(
      "appsrc name=in ! tensor_if name=i compared-value=CUSTOM compared-value-option=above-two "
      "then=PASSTHROUGH else=SKIP i.src_0 ! tensor_sink name=out");
  for (float i = 0; i < 5; ++i) ASSERT_TRUE(p.push("in", span({i}), {.shape = {1}}));
  EXPECT_EQ(pulled(p, "out"), (Values{3}));
  EXPECT_EQ(pulled(p, "out"), (Values{4}));
}

}  // namespace pipeline_test
