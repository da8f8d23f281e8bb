// Tests of pausing, stopping and freeing a pipeline: with a full queue, in callbacks, on other
// threads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <cstring>
#include <future>
#include <optional>
#include <thread>

#include "becomes.hpp"
#include "pipeline_test_support.hpp"
#include "says.hpp"
#include "weir/custom_filter.hpp"
#include "weir/model.h"
#include "weir/pipeline.hpp"

namespace pipeline_stop_test {

using namespace std::chrono_literals;
using namespace weir::pipeline_test;
using weir::Frame;
using weir::Pipeline;
using weir::PipelineState;
using Values = std::vector<float>;

weir::Status push(Pipeline& p, float value) {
  const Values values{value};
  return p.push("in", std::span<const float>(values), {.shape = {1}});
}
float pulled(Pipeline& p) {
  const auto frame = p.pull<float>("out", kLong);
  if (!frame) throw std::runtime_error(frame.error().message());
  return *frame ? (*(**frame)[0].as<float>())[0] : -1;
}

// Runs `call` on a thread. When it does not return: false, after emptying the pipeline's queue.
template <class Call>
bool returns(Pipeline& p, Call call) {
  auto result = std::async(std::launch::async, call);
  if (result.wait_for(kLong) == std::future_status::ready) {
    const auto status = result.get();
    EXPECT_TRUE(status) << status.error().message();
    return status.has_value();
  }
  ADD_FAILURE() << "the call does not return";
  while (result.wait_for(0s) != std::future_status::ready) (void)p.pull("out", 1ms);
  return false;
}

// An endless source; its queue holds `room` frames.
struct FullQueue {
  const char* sink;
  int room;
};
class PipelineFull : public ::testing::TestWithParam<FullQueue> {
 protected:
  // A pipeline whose streaming thread waits for space.
  Pipeline full() const {
    Pipeline p = started(std::string("videotestsrc ! video/x-raw,format=GRAY8,width=8,height=8 ! "
                                     "tensor_converter name=c ! ") +
                         GetParam().sink);
    const std::string all =
        R"(received\=\(guint64\))" + std::to_string(GetParam().room + 1) + "\\,";
    const auto is_full = [&] { return p.get("c", "stats")->find(all) != std::string::npos; };
    EXPECT_TRUE(becomes_true(is_full, [&] { return all + " in " + *p.get("c", "stats"); }));
    return p;
  }
};

TEST_P(PipelineFull, Pauses) {
  Pipeline p = full();
  ASSERT_TRUE(returns(p, [&] { return p.pause(); }));
  EXPECT_EQ(p.state(), PipelineState::Paused);
}

TEST_P(PipelineFull, PausesAndStopsFromTwoThreads) {
  for (int i = 0; i < 10; ++i) {
    Pipeline p = full();
    std::jthread pauser([&] { (void)p.pause(); });
    ASSERT_TRUE(returns(p, [&] { return p.stop(); }));
  }
}

TEST_P(PipelineFull, StartsAgainAfterAPause) {
  Pipeline p = full();
  ASSERT_TRUE(returns(p, [&] { return p.pause(); }));
  ASSERT_TRUE(returns(p, [&] { return p.start(); }));
  for (int i = 0; i < 3 * GetParam().room; ++i) ASSERT_TRUE(*p.pull("out", kLong));
  EXPECT_EQ(p.state(), PipelineState::Playing);
}

INSTANTIATE_TEST_SUITE_P(
    Sinks, PipelineFull,
    ::testing::Values(FullQueue{"tensor_sink name=out", 64},
                      FullQueue{"appsink name=out sync=false max-buffers=4", 4}),
    [](const auto& info) { return info.index == 0 ? "TensorSink" : "AppSink"; });

TEST(PipelineFullQueue, LosesNoFrameInAPause) {
  Pipeline p = started("appsrc name=in ! tensor_sink name=out");
  for (float i = 0; i < 100; ++i) ASSERT_TRUE(push(p, i));
  EXPECT_EQ(pulled(p), 0);
  ASSERT_TRUE(returns(p, [&] { return p.pause(); }));
  ASSERT_TRUE(p.start());
  for (float i = 1; i < 100; ++i) ASSERT_EQ(pulled(p), i);
}

// Gets a reference to the next tensor_sink that starts streaming, which the API does not expose.
void hook_next_sink(std::promise<GstElement*>* seen) {
  const auto see = [](GSignalInvocationHint*, guint, const GValue* values,
                      gpointer to) -> gboolean {
    static_cast<std::promise<GstElement*>*>(to)->set_value(GST_ELEMENT(g_value_dup_object(values)));
    return FALSE;  // remove the hook
  };
  const GType type = g_type_from_name("WeirTensorSink");
  g_signal_add_emission_hook(g_signal_lookup("stream-start", type), 0, see, seen, nullptr);
}

// A frame that waits for space does not block a flush.
TEST(PipelineFullQueue, LetsAFlushThrough) {
  Pipeline p = parse("appsrc name=in ! tensor_sink name=out");
  std::promise<GstElement*> seen;
  hook_next_sink(&seen);
  ASSERT_TRUE(p.start());
  for (float i = 0; i < 70; ++i) ASSERT_TRUE(push(p, i));
  GstElement* sink = seen.get_future().get();
  EXPECT_EQ(pulled(p), 0);
  // 1 was pulled, 64 are queued, 1 waits for space.
  const auto is_full = [&] { return *p.get<int>("in", "current-level-buffers") == 4; };
  ASSERT_TRUE(becomes_true(is_full, "a full queue"));
  GstPad* pad = gst_element_get_static_pad(sink, "sink");
  EXPECT_TRUE(returns(p, [&]() -> weir::Status {
    gst_pad_send_event(pad, gst_event_new_flush_start());
    // As each source does: the flush ends when the streaming thread has left the pad. Earlier,
    // another frame of that thread could still come.
    GST_PAD_STREAM_LOCK(pad);
    GST_PAD_STREAM_UNLOCK(pad);
    gst_pad_send_event(pad, gst_event_new_flush_stop(TRUE));
    return weir::ok();
  }));
  gst_object_unref(pad);
  gst_object_unref(sink);
}

thread_local bool is_poster = false;

// A pipeline is freed while a thread, for which no state change waits, may be in a callback.
TEST(PipelineFree, WaitsForAStateCallbackOfAnotherThread) {
  weir_pipeline* p = nullptr;
  ASSERT_EQ(weir_pipeline_parse("videotestsrc ! video/x-raw,format=GRAY8,width=8,height=8 ! "
                                "tensor_converter ! tensor_sink name=out",
                                &p, nullptr),
            WEIR_OK);
  struct Callback {
    std::promise<void> entered, freed;
    std::atomic<bool> is_playing = false, was_freed_inside = false;
  } callback;
  const auto on_state = [](int state, void* data) {
    auto* to = static_cast<Callback*>(data);
    if (state == WEIR_PIPELINE_PLAYING) to->is_playing = true;
    if (!is_poster) return;
    to->entered.set_value();
    to->was_freed_inside = to->freed.get_future().wait_for(100ms) == std::future_status::ready;
  };
  ASSERT_EQ(weir_pipeline_on_state(p, on_state, &callback, nullptr), WEIR_OK);
  std::promise<GstElement*> seen;
  hook_next_sink(&seen);
  ASSERT_EQ(weir_pipeline_start(p, nullptr), WEIR_OK);
  GstElement* sink = seen.get_future().get();
  auto* top = GST_ELEMENT(gst_object_get_parent(GST_OBJECT(sink)));
  EXPECT_TRUE(becomes_true([&] { return callback.is_playing.load(); }, "the state"));
  std::jthread poster([&] {
    is_poster = true;
    gst_element_post_message(
        top, gst_message_new_state_changed(GST_OBJECT(top), GST_STATE_PLAYING, GST_STATE_PAUSED,
                                           GST_STATE_VOID_PENDING));
  });
  callback.entered.get_future().wait();
  weir_pipeline_free(p);
  callback.freed.set_value();
  poster.join();
  EXPECT_FALSE(callback.was_freed_inside);
  gst_object_unref(top);
  gst_object_unref(sink);
}

TEST(PipelineWait, EndsWhenThePipelineIsStopped) {
  Pipeline p = started("appsrc name=in ! tensor_sink name=out");
  std::promise<void> began;
  auto waits = std::async(std::launch::async, [&] {
    began.set_value();
    return p.wait();
  });
  began.get_future().wait();
  // The other thread may not wait yet: each stop only ends current waits.
  while (waits.wait_for(1ms) != std::future_status::ready) {
    ASSERT_TRUE(p.stop());
    ASSERT_TRUE(p.start());
  }
  EXPECT_REFUSED(waits.get(), CANCELLED, "the pipeline is stopped and processes no frames");
}

constexpr char kOwn[] = "a callback cannot change the state of its own pipeline";

TEST(PipelineCallback, CannotChangeTheState) {
  Pipeline p = parse("appsrc name=in ! tensor_sink name=out");
  std::promise<void> called;
  ASSERT_TRUE(p.on_frame("out", [&](const Frame&) {
    EXPECT_REFUSED(p.stop(), CANCELLED, kOwn);
    EXPECT_REFUSED(p.stop(), CANCELLED, "needed: a call on another thread");
    EXPECT_REFUSED(p.pause(), CANCELLED, kOwn);
    EXPECT_REFUSED(p.start(), CANCELLED, kOwn);
    EXPECT_REFUSED(p.wait(), CANCELLED, kOwn);
    EXPECT_REFUSED(p.on_frame("out", {}), OPTION_VALUE,
                   "can only be set while the pipeline is stopped");
    EXPECT_FALSE(*p.wait(0ns)) << "this one does not wait";
    called.set_value();
  }));
  ASSERT_TRUE(p.start());
  ASSERT_TRUE(push(p, 1));
  called.get_future().wait();
  EXPECT_EQ(p.state(), PipelineState::Playing);
  EXPECT_TRUE(p.stop());
}

TEST(PipelineCallback, OfAStateCannotChangeIt) {
  weir_pipeline* p = nullptr;
  ASSERT_EQ(weir_pipeline_parse("appsrc ! tensor_sink async=false", &p, nullptr), WEIR_OK);
  struct Seen {
    weir_pipeline* pipeline;
    std::vector<int> results;
  } seen{p, {}};
  const auto on_state = [](int, void* data) {
    auto* to = static_cast<Seen*>(data);
    for (const auto call : {weir_pipeline_start, weir_pipeline_pause, weir_pipeline_stop})
      to->results.push_back(call(to->pipeline, nullptr));
    to->results.push_back(weir_pipeline_wait(to->pipeline, -1, nullptr));
    to->results.push_back(weir_pipeline_on_state(to->pipeline, nullptr, nullptr, nullptr));
  };
  ASSERT_EQ(weir_pipeline_on_state(p, on_state, &seen, nullptr), WEIR_OK);
  ASSERT_EQ(weir_pipeline_pause(p, nullptr), WEIR_OK);
  ASSERT_EQ(weir_pipeline_stop(p, nullptr), WEIR_OK);
  weir_pipeline_free(p);
  ASSERT_FALSE(seen.results.empty());
  for (size_t i = 0; i < seen.results.size(); ++i)
    EXPECT_EQ(seen.results[i], i % 5 == 4 ? -WEIR_OPTION_VALUE : -WEIR_CANCELLED) << i;
}

// A filter of the program, destroyed with the last element that uses it.
class Witness {
 public:
  explicit Witness(const std::string& name, std::function<void()> each = {}) {
    auto token = std::make_shared<int>();
    gone_ = token;
    const auto x = weir::tensor_info("x", WEIR_FLOAT32, {1});
    filter_.emplace(name, weir::FilterDescription{.inputs = {x}, .outputs = {x}},
                    [token, each](std::span<const weir_tensor> in, std::span<weir_tensor> out) {
                      if (each) each();
                      std::memcpy(out[0].data, in[0].data, out[0].bytes);
                    });
  }
  // Frees the name; elements keep the filter.
  void unregister() { filter_.reset(); }
  [[nodiscard]] bool is_gone() const {
    return becomes_true([&] { return gone_.expired(); }, "the end of the pipeline");
  }

 private:
  std::weak_ptr<int> gone_;
  std::optional<weir::RegisteredFilter> filter_;
};

TEST(PipelineCallback, OfACustomFilterCannotStopItsPipeline) {
  std::optional<Pipeline> p;
  std::promise<weir::Status> stopped;
  Witness filter("stopping", [&] { stopped.set_value(p->stop()); });
  p = parse(
      "appsrc name=in ! tensor_filter framework=custom-easy model=stopping ! queue ! "
      "tensor_sink name=out");
  ASSERT_TRUE(p->start());
  ASSERT_TRUE(push(*p, 1));
  EXPECT_REFUSED(stopped.get_future().get(), CANCELLED, kOwn);
  EXPECT_EQ(pulled(*p), 1);
  EXPECT_TRUE(p->stop());
}

TEST(PipelineCallback, CanDestroyThePipeline) {
  for (int i = 0; i < 10; ++i) {
    Witness filter("witness");
    std::optional<Pipeline> p = parse(
        "appsrc name=in ! tensor_filter framework=custom-easy model=witness ! "
        "tensor_sink name=out");
    std::atomic<int> calls = 0;
    std::promise<void> pushed, called;
    ASSERT_TRUE(p->on_frame("out", [&, kept = std::make_shared<int>(7)](const Frame&) {
      if (++calls > 1) return;
      pushed.get_future().wait();
      p.reset();
      EXPECT_EQ(*kept, 7) << "the function lives until it has returned";
      called.set_value();
    }));
    ASSERT_TRUE(p->start());
    filter.unregister();
    for (float value = 0; value < 10; ++value) ASSERT_TRUE(push(*p, value));
    pushed.set_value();
    called.get_future().wait();
    EXPECT_TRUE(filter.is_gone());
    EXPECT_EQ(calls, 1) << "no call comes after the pipeline was freed";
  }
}

TEST(PipelineCallback, OfACustomFilterCanFreeThePipeline) {
  weir_pipeline* p = nullptr;
  std::promise<void> pushed, freed;
  Witness filter("freeing", [&] {
    pushed.get_future().wait();
    weir_pipeline_free(p);
    freed.set_value();
  });
  ASSERT_EQ(
      weir_pipeline_parse("appsrc name=in ! tensor_filter framework=custom-easy model=freeing "
                          "! tensor_sink name=out",
                          &p, nullptr),
      WEIR_OK);
  ASSERT_EQ(weir_pipeline_start(p, nullptr), WEIR_OK);
  filter.unregister();
  const float value = 1;
  weir_tensor tensor = weir_tensor_of(&value, sizeof value, WEIR_FLOAT32);
  tensor.info.rank = 1;
  tensor.info.shape[0] = 1;
  ASSERT_EQ(weir_pipeline_push(p, "in", &tensor, 1, -1, -1, nullptr), WEIR_OK);
  pushed.set_value();
  freed.get_future().wait();
  EXPECT_TRUE(filter.is_gone());
}

}  // namespace pipeline_stop_test
