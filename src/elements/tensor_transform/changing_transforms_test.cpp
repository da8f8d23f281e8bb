// Chained transforms while the stream changes: probes, other caps, other elements, flushes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/app/gstappsink.h>

#include <algorithm>

#include "core/tensor/tensor_header.hpp"
#include "elements/tensor_transform/transform_chain_test_support.hpp"

namespace changing_transforms_test {

using weir::chain_test::Bytes;
using weir::chain_test::Chain;
using weir::chain_test::Frame;
using weir::chain_test::random_frame;
using weir::chain_test::read_frame;
using weir::chain_test::transform;
using weir::gst::MappedMemory;
using weir::gst::Ref;

constexpr char kPixels[] = "other/tensor,dimension=(string)3:100,type=uint8,framerate=30/1";
constexpr char kCast[] = "mode=typecast option=float32";
constexpr char kScale[] = "mode=arithmetic option=add:-127.5,div:127.5";
constexpr char kAdd[] = "mode=arithmetic option=add:7";
constexpr char kLimit[] = "mode=clamp option=9:99";

const std::string kCastAndScale = transform("a", kCast) + " ! " + transform("b", kScale);
const std::string kAddAndLimit = transform("a", kAdd) + " ! " + transform("b", kLimit);

// The same, computed by the test.
Frame scaled(const Frame& in) {
  Frame out;
  for (const auto& bytes : in) {
    std::vector<float> values;
    for (const auto byte : bytes) values.push_back((static_cast<float>(byte) - 127.5f) / 127.5f);
    const auto raw = std::as_bytes(std::span(values));
    out.emplace_back(raw.begin(), raw.end());
  }
  return out;
}
Bytes added(const Bytes& in) {
  Bytes out;
  for (const auto byte : in)
    out.push_back(std::byte(std::min(std::to_integer<int>(byte) + 7, 255)));
  return out;
}
Bytes limited(const Bytes& in) {
  Bytes out;
  for (const auto byte : in)
    out.push_back(std::byte(std::clamp(std::to_integer<int>(byte), 9, 99)));
  return out;
}

GstBuffer* buffer_in(GstPadProbeInfo* info) {
  return GST_PAD_PROBE_INFO_BUFFER(info);
}

TEST(ChangingTransforms, AProbeBetweenGetsTheResultOfTheFirst) {
  Chain chain(kAddAndLimit, kPixels);
  std::vector<Frame> seen;
  chain.add_probe(
      "a", "src",
      [](GstPad*, GstPadProbeInfo* info, gpointer into) {
        static_cast<std::vector<Frame>*>(into)->push_back(read_frame(buffer_in(info)));
        return GST_PAD_PROBE_OK;
      },
      &seen);
  for (uint32_t i = 0; i < 3; ++i) {
    const auto in = random_frame({300}, i);
    EXPECT_EQ(chain.result(in)[0], limited(added(in[0])));
    EXPECT_EQ(seen.back()[0], added(in[0]));
  }
  EXPECT_EQ(seen.size(), 3u);
  EXPECT_EQ(chain.stat("a", "deferred-frames"), 1u)
      << "the first frame shows that deferring does not help";
  EXPECT_EQ(chain.stat("b", "fused-frames"), 0u);
}

TEST(ChangingTransforms, TheSecondReadsWhatAProbeWrites) {
  Chain chain(kAddAndLimit, kPixels);
  chain.add_probe(
      "b", "sink",
      [](GstPad*, GstPadProbeInfo* info, gpointer) {
        GstBuffer* buffer = gst_buffer_make_writable(buffer_in(info));
        GST_PAD_PROBE_INFO_DATA(info) = buffer;
        gst_buffer_memset(buffer, 10, 42, 5);
        return GST_PAD_PROBE_OK;
      },
      nullptr);
  for (uint32_t i = 0; i < 3; ++i) {
    const auto in = random_frame({300}, i);
    auto expected = added(in[0]);
    std::fill_n(expected.begin() + 10, 5, std::byte{42});
    EXPECT_EQ(chain.result(in)[0], limited(expected));
  }
}

TEST(ChangingTransforms, TheSecondRejectsAFrameThatAProbeTruncates) {
  Chain chain(kAddAndLimit, kPixels);
  chain.add_probe(
      "a", "src",
      [](GstPad*, GstPadProbeInfo* info, gpointer) {
        gst_buffer_resize(buffer_in(info), 1, 200);
        return GST_PAD_PROBE_OK;
      },
      nullptr);
  EXPECT_EQ(chain.push(random_frame({300}, 1)), GST_FLOW_ERROR);
  const std::string error = chain.error();
  EXPECT_EQ(error.rfind("b: ", 0), 0u) << error;
  EXPECT_SAYS(error, "200 bytes in memory 0");
  EXPECT_EQ(chain.stat("b", "dropped-error"), 1u);
}

TEST(ChangingTransforms, DivisionsInAMappedFrameCountAtTheFirst) {
  Chain chain(transform("a", "mode=arithmetic option=div:0") + " ! " + transform("b", kLimit),
              kPixels);
  chain.add_probe(
      "a", "src",
      [](GstPad*, GstPadProbeInfo* info, gpointer) {
        read_frame(buffer_in(info));
        return GST_PAD_PROBE_OK;
      },
      nullptr);
  for (uint32_t i = 0; i < 2; ++i) chain.result(random_frame({300}, i));
  EXPECT_EQ(chain.stat("a", "integer-divisions-by-zero"), 600u);
  EXPECT_EQ(chain.stat("b", "integer-divisions-by-zero"), 0u);
}

TEST(ChangingTransforms, OtherCapsAreFusedAgain) {
  Chain chain(kCastAndScale, kPixels);
  for (uint32_t i = 0; i < 3; ++i) {
    chain.caps("other/tensor,dimension=(string)3:" + std::to_string(10 + i) +
               ",type=uint8,framerate=30/1");
    const auto in = random_frame({3 * (10 + i)}, i);
    EXPECT_EQ(chain.result(in), scaled(in));
  }
  chain.caps(
      "other/tensors,format=static,num_tensors=2,dimensions=(string)\"3:2,5\","
      "types=(string)\"uint8,uint8\",framerate=30/1");
  const auto two = random_frame({6, 5}, 1);
  EXPECT_EQ(chain.result(two), scaled(two));
  EXPECT_EQ(chain.stat("a", "deferred-frames"), 4u);
  EXPECT_EQ(chain.stat("b", "fused-frames"), 4u);
}

TEST(ChangingTransforms, AFlexibleInputMidStreamEndsTheFusion) {
  Chain chain(kAddAndLimit, kPixels);
  const auto in = random_frame({300}, 1);
  EXPECT_EQ(chain.result(in)[0], limited(added(in[0])));
  chain.caps("other/tensors,format=flexible,framerate=30/1");
  Frame flexible = in;
  weir::TensorHeader header;
  header.spec = {weir::ElementType::UInt8, {3, 100}, ""};
  flexible[0].insert(flexible[0].begin(), weir::kTensorHeaderBytes, std::byte{0});
  weir::write_tensor_header(header, std::span(flexible[0]).first<weir::kTensorHeaderBytes>());
  auto out = chain.result(flexible)[0];
  out.erase(out.begin(), out.begin() + weir::kTensorHeaderBytes);
  EXPECT_EQ(out, limited(added(in[0])));
  chain.caps(kPixels);
  EXPECT_EQ(chain.result(in)[0], limited(added(in[0])));
  EXPECT_EQ(chain.stat("a", "deferred-frames"), 2u);
}

TEST(ChangingTransforms, ADownstreamThatNeedsHeadersEndsTheFusion) {
  // With the longer spelling of the dimension, the caps between the two stayed the same.
  for (const std::string dimension : {"3:100", "3:100:1:1"}) {
    Chain chain(kAddAndLimit,
                "other/tensor,dimension=(string)" + dimension + ",type=uint8,framerate=30/1");
    const auto in = random_frame({300}, 1);
    EXPECT_EQ(chain.result(in)[0], limited(added(in[0])));
    gst_harness_set_sink_caps_str(chain.harness(), "other/tensors,format=flexible,framerate=30/1");
    for (int i = 0; i < 3; ++i) {
      auto out = chain.result(in)[0];
      ASSERT_EQ(out.size(), 300 + weir::kTensorHeaderBytes);
      out.erase(out.begin(), out.begin() + weir::kTensorHeaderBytes);
      EXPECT_EQ(out, limited(added(in[0])));
    }
    EXPECT_EQ(chain.stat("a", "deferred-frames"), 1u);
    EXPECT_EQ(chain.stat("b", "fused-frames"), 1u);
  }
}

// Removes the elements between "a" and "z" from the chain.
void take_out(const Chain& chain, const char* name) {
  const auto a = chain.element("a"), z = chain.element("z"), gone = chain.element(name);
  gst_element_unlink_many(a.get(), gone.get(), z.get(), nullptr);
  gst_element_set_state(gone.get(), GST_STATE_NULL);
  gst_bin_remove(GST_BIN(chain.harness()->element), gone.get());
}
void put_in(const Chain& chain, GstElement* next,
            GstPadLinkCheck checks = GST_PAD_LINK_CHECK_DEFAULT) {
  const auto a = chain.element("a"), z = chain.element("z");
  ASSERT_TRUE(gst_bin_add(GST_BIN(chain.harness()->element), next));
  ASSERT_TRUE(gst_element_link_pads_full(a.get(), "src", next, "sink", checks));
  ASSERT_TRUE(gst_element_link(next, z.get()));
  ASSERT_TRUE(gst_element_sync_state_with_parent(next));
}

TEST(ChangingTransforms, AnElementThatReplacesTheSecondGetsTheResultOfTheFirst) {
  Chain chain(kAddAndLimit + " ! identity name=z", kPixels);
  const auto in = random_frame({300}, 1);
  EXPECT_EQ(chain.result(in)[0], limited(added(in[0])));
  take_out(chain, "b");
  put_in(chain, gst_element_factory_make("identity", "c"));
  EXPECT_EQ(chain.result(in)[0], added(in[0]));
  EXPECT_EQ(chain.stat("a", "deferred-frames"), 1u);
}

TEST(ChangingTransforms, AnUnnoticedReplacementGetsTheResultOfTheFirst) {
  Chain chain(kAddAndLimit + " ! identity name=z", kPixels);
  const auto in = random_frame({300}, 1);
  EXPECT_EQ(chain.result(in)[0], limited(added(in[0])));
  take_out(chain, "b");
  put_in(chain, gst_element_factory_make("identity", "c"), GST_PAD_LINK_CHECK_NO_RECONFIGURE);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(chain.result(in)[0], added(in[0]));
  EXPECT_EQ(chain.stat("a", "deferred-frames"), 2u) << "one that was not used";
}

TEST(ChangingTransforms, AnInsertedTeeGivesBothBranchesTheResult) {
  Chain chain(kAddAndLimit, kPixels);
  const auto in = random_frame({300}, 1);
  EXPECT_EQ(chain.result(in)[0], limited(added(in[0])));
  const auto a = chain.element("a"), b = chain.element("b");
  GstElement *tee = gst_element_factory_make("tee", "t"),
             *branch = gst_element_factory_make("appsink", "sink");
  g_object_set(branch, "sync", FALSE, "async", FALSE, nullptr);
  gst_bin_add_many(GST_BIN(chain.harness()->element), tee, branch, nullptr);
  gst_element_unlink(a.get(), b.get());
  ASSERT_TRUE(gst_element_link_many(a.get(), tee, b.get(), nullptr));
  ASSERT_TRUE(gst_element_link(tee, branch));
  ASSERT_TRUE(gst_element_sync_state_with_parent(branch));
  ASSERT_TRUE(gst_element_sync_state_with_parent(tee));
  EXPECT_EQ(chain.result(in)[0], limited(added(in[0])));
  GstSample* sample = gst_app_sink_pull_sample(GST_APP_SINK(branch));
  EXPECT_EQ(read_frame(gst_sample_get_buffer(sample))[0], added(in[0]));
  gst_sample_unref(sample);
  EXPECT_EQ(chain.stat("a", "deferred-frames"), 1u);
}

TEST(ChangingTransforms, ATransformThatReplacesTheSecondIsFused) {
  Chain chain(kAddAndLimit + " ! identity name=z", kPixels);
  const auto in = random_frame({300}, 1);
  EXPECT_EQ(chain.result(in)[0], limited(added(in[0])));
  take_out(chain, "b");
  EXPECT_EQ(chain.push(in), GST_FLOW_NOT_LINKED);
  EXPECT_EQ(chain.stat("a", "pushed"), 2u) << "pushed without a peer";
  GstElement* next = gst_element_factory_make("tensor_transform", "c");
  gst_util_set_object_arg(G_OBJECT(next), "mode", "arithmetic");
  gst_util_set_object_arg(G_OBJECT(next), "option", "add:7");
  put_in(chain, next);
  EXPECT_EQ(chain.result(in)[0], added(added(in[0])));
  EXPECT_EQ(chain.stat("c", "fused-frames"), 1u);
}

TEST(ChangingTransforms, ContinueAfterAFlush) {
  Chain chain(kAddAndLimit, kPixels);
  const auto in = random_frame({300}, 1);
  chain.result(in);
  GstHarness* h = chain.harness();
  EXPECT_TRUE(gst_harness_push_event(h, gst_event_new_flush_start()));
  EXPECT_EQ(chain.push(in), GST_FLOW_FLUSHING);
  EXPECT_TRUE(gst_harness_push_event(h, gst_event_new_flush_stop(TRUE)));
  gst_harness_push_event(h, weir::test::time_segment());
  EXPECT_EQ(chain.result(in)[0], limited(added(in[0])));
  for (const char* name : {"a", "b"}) {
    const uint64_t received = chain.stat(name, "received");
    EXPECT_EQ(received, chain.stat(name, "consumed") + chain.stat(name, "dropped")) << name;
    EXPECT_EQ(chain.stat(name, "held"), 0u) << name;
  }
  EXPECT_EQ(chain.stat("b", "fused-frames"), 2u);
}

TEST(ChangingTransforms, AFrameThatAProbeKeptOutlivesTheElements) {
  const auto in = random_frame({300}, 1);
  Ref<GstBuffer> kept;
  {
    Chain chain(kAddAndLimit, kPixels);
    chain.add_probe(
        "a", "src",
        [](GstPad*, GstPadProbeInfo* info, gpointer into) {
          *static_cast<Ref<GstBuffer>*>(into) = Ref<GstBuffer>::share(buffer_in(info));
          return GST_PAD_PROBE_REMOVE;
        },
        &kept);
    EXPECT_EQ(chain.result(in)[0], limited(added(in[0])));
    EXPECT_EQ(chain.stat("b", "fused-frames"), 1u);
  }
  EXPECT_EQ(read_frame(kept.get())[0], added(in[0]));
}

// A whole pipeline with an appsink "sink".
class Pipeline {
 public:
  explicit Pipeline(const std::string& line) : top_(weir::test::lone_element(line)) {}
  ~Pipeline() { gst_element_set_state(top_.get(), GST_STATE_NULL); }
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;

  Ref<GstElement> element(const char* name) const {
    return Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(top_.get()), name));
  }
  GstElement* top() const { return top_.get(); }
  std::vector<Frame> play() {
    EXPECT_NE(gst_element_set_state(top_.get(), GST_STATE_PLAYING), GST_STATE_CHANGE_FAILURE);
    const auto sink = element("sink");
    std::vector<Frame> frames;
    while (GstSample* sample = gst_app_sink_pull_sample(GST_APP_SINK(sink.get()))) {
      frames.push_back(read_frame(gst_sample_get_buffer(sample)));
      gst_sample_unref(sample);
    }
    return frames;
  }

 private:
  Ref<GstElement> top_;
};

TEST(ChangingTransforms, ATransformThatReplacesTheSecondWhilePausedIsFused) {
  Pipeline pipeline(
      "videotestsrc num-buffers=3 pattern=solid-color foreground-color=0xfff0f0f0 ! "
      "video/x-raw,format=RGB,width=8,height=8 ! tensor_converter ! " +
      kAddAndLimit + " ! appsink name=sink sync=false " + transform("c", kAdd));
  const auto a = pipeline.element("a"), b = pipeline.element("b"), c = pipeline.element("c"),
             sink = pipeline.element("sink");
  gst_element_set_state(pipeline.top(), GST_STATE_PAUSED);
  ASSERT_EQ(gst_element_get_state(pipeline.top(), nullptr, nullptr, GST_CLOCK_TIME_NONE),
            GST_STATE_CHANGE_SUCCESS);
  gst_element_unlink_many(a.get(), b.get(), sink.get(), nullptr);
  ASSERT_TRUE(gst_element_link_many(a.get(), c.get(), sink.get(), nullptr));
  const Frame first{Bytes(192, std::byte{99})}, later{Bytes(192, std::byte{240 + 7 + 7})};
  EXPECT_EQ(pipeline.play(), (std::vector<Frame>{first, later, later}));
  EXPECT_EQ(weir::test::stat(c.get(), "fused-frames"), 2u);
  EXPECT_EQ(weir::test::stat(a.get(), "deferred-frames"), 3u);
}

TEST(ChangingTransforms, WholePipelinesGiveTheSameFramesWithQueuesBetween) {
  const auto line = [](const std::string& between) {
    return "videotestsrc pattern=snow num-buffers=4 ! video/x-raw,format=RGB,width=70,height=50 ! "
           "tensor_converter ! " +
           transform("a", kCast) + between + transform("b", kScale) + between +
           transform("c", "mode=clamp option=-0.5:0.5") + " ! appsink name=sink sync=false";
  };
  const auto fused = Pipeline(line(" ! ")).play();
  ASSERT_EQ(fused.size(), 4u);
  EXPECT_EQ(fused, Pipeline(line(" ! queue ! ")).play());
  EXPECT_EQ(fused, Pipeline(line(" ! tee ! ")).play());
}

}  // namespace changing_transforms_test
