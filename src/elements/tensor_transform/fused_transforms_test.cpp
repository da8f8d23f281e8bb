// Chained transforms: fused into one pass, with the same bits as separate passes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>

#include "elements/tensor_transform/transform_chain_test_support.hpp"

namespace fused_transforms_test {

using weir::chain_test::Chain;
using weir::chain_test::Frame;
using weir::chain_test::random_frame;
using weir::chain_test::read_frame;
using weir::chain_test::transform;

constexpr char kPixels[] = "other/tensor,dimension=(string)3:100,type=uint8,framerate=30/1";
constexpr char kCast[] = "mode=typecast option=float32";
constexpr char kScale[] = "mode=arithmetic option=add:-127.5,div:127.5";
constexpr char kLimit[] = "mode=clamp option=-0.5:0.5";
constexpr int kFrames = 3;

struct Case {
  std::vector<std::string> transforms;
  std::string caps = kPixels;
  std::vector<size_t> sizes{300};
};

std::string joined(const Case& c, const std::string& between) {
  std::string line;
  for (size_t i = 0; i < c.transforms.size(); ++i)
    line += (i > 0 ? between : "") +
            transform(std::string(1, static_cast<char>('a' + i)).c_str(), c.transforms[i]);
  return line;
}

// Compares the chain with the same one with an identity in between; returns how many frames element
// a deferred and the last element fused.
std::pair<uint64_t, uint64_t> deferred_and_fused(const Case& c) {
  SCOPED_TRACE(joined(c, " ! ") + " of " + c.caps);
  Chain direct(joined(c, " ! "), c.caps), apart(joined(c, " ! identity ! "), c.caps);
  const std::string last(1, static_cast<char>('a' + c.transforms.size() - 1));
  for (uint32_t i = 0; i < kFrames; ++i) {
    const auto in = random_frame(c.sizes, i);
    EXPECT_EQ(direct.result(in), apart.result(in)) << "frame " << i;
  }
  for (size_t i = 0; i < c.transforms.size(); ++i) {
    const std::string name(1, static_cast<char>('a' + i));
    for (const char* field : {"received", "consumed", "pushed"})
      EXPECT_EQ(direct.stat(name.c_str(), field), kFrames) << name << " " << field;
    for (const char* field : {"deferred-frames", "fused-frames"})
      EXPECT_EQ(apart.stat(name.c_str(), field), 0u) << name << " " << field;
  }
  EXPECT_EQ(direct.stat(last.c_str(), "deferred-frames"), 0u);
  return {direct.stat("a", "deferred-frames"), direct.stat(last.c_str(), "fused-frames")};
}
constexpr std::pair<uint64_t, uint64_t> kAll{kFrames, kFrames}, kNone{0, 0};

TEST(FusedTransforms, GiveTheSameBitsAsSeparateTransforms) {
  const std::string channels = "mode=arithmetic option=per-channel:true@0,add:1@0,mul:3@2";
  const std::string planes = "mode=arithmetic option=per-channel:true@1,add:1@0,mul:3@2";
  const std::string half = "mode=typecast option=float16";
  for (const auto& c :
       std::vector<Case>{{{kCast, kScale}},
                         {{kCast, kLimit}},
                         {{channels, kCast}},
                         {{kCast, planes}},
                         {{"mode=arithmetic option=add:7", "mode=clamp option=9:99"}},
                         {{half, "mode=arithmetic option=mul:3,add:.5"}},
                         {{half, "mode=typecast option=int16"}},
                         {{"mode=typecast option=uint8", kCast}}})
    EXPECT_EQ(deferred_and_fused(c), kAll);
}

TEST(FusedTransforms, ThreeAndFourAreOnePass) {
  const Case three{{kCast, kScale, kLimit}},
      four{{kCast, kScale, kLimit, "mode=typecast option=int8"}};
  EXPECT_EQ(deferred_and_fused(three), kAll);
  EXPECT_EQ(deferred_and_fused(four), kAll);
  Chain chain(joined(three, " ! "), kPixels);
  chain.result(random_frame({300}, 1));
  EXPECT_EQ(chain.stat("b", "fused-frames"), 1u);
  EXPECT_EQ(chain.stat("b", "deferred-frames"), 1u);
  EXPECT_EQ(chain.stat("b", "pool-allocated"), 0u);
}

TEST(FusedTransforms, SupportTheScalarPath) {
  for (const char* one : {"true", "false"})
    for (const char* two : {"true", "false"})
      EXPECT_EQ(deferred_and_fused({{std::string(kCast) + " acceleration=" + one,
                                     std::string(kScale) + " acceleration=" + two}}),
                kAll);
}

std::string many(size_t count) {
  std::string dimensions, types;
  for (size_t i = 0; i < count; ++i) {
    dimensions += (i > 0 ? "," : "") + std::string("3:") + std::to_string(i + 1);
    types += i > 0 ? ",uint8" : "uint8";
  }
  return "other/tensors,format=static,num_tensors=" + std::to_string(count) +
         ",dimensions=(string)\"" + dimensions + "\",types=(string)\"" + types +
         "\",framerate=30/1";
}

TEST(FusedTransforms, SixteenTensorsAreFusedSeventeenAreNot) {
  std::vector<size_t> sizes;
  for (size_t i = 0; i < 16; ++i) sizes.push_back(3 * (i + 1));
  EXPECT_EQ(deferred_and_fused({{kCast, kScale, kLimit}, many(16), sizes}), kAll);
  size_t total = 0;  // in one memory, as from a source that knows no tensors
  for (size_t i = 0; i < 17; ++i) total += 3 * (i + 1);
  EXPECT_EQ(deferred_and_fused({{kCast, kScale}, many(17), {total}}), kNone);
}

TEST(FusedTransforms, FramesInOneMemoryAreSplitFirst) {
  EXPECT_EQ(deferred_and_fused({{kCast, kScale}, many(2), {9}}), kNone);
}

TEST(FusedTransforms, AreNotUsedIfAWholeTensorIsNeeded) {
  for (const char* whole : {"mode=transpose option=1:0:2:3", "mode=stand option=default",
                            "mode=dimchg option=0:1", "mode=padding option=left:1"}) {
    EXPECT_EQ(deferred_and_fused({{kCast, whole}}), kNone);
    EXPECT_EQ(deferred_and_fused({{whole, kCast}}), kNone);
  }
  EXPECT_EQ(deferred_and_fused({{kCast, "mode=transpose option=1:0:2:3", kLimit}}), kNone);
}

TEST(FusedTransforms, AreNotUsedIfSomeTensorsAreNotTransformed) {
  const std::string some = std::string(kCast) + " apply=1";
  EXPECT_EQ(deferred_and_fused({{some, kLimit}, many(2), {3, 6}}), kNone);
  EXPECT_EQ(deferred_and_fused({{kCast, std::string(kLimit) + " apply=0"}, many(2), {3, 6}}),
            kNone);
}

TEST(FusedTransforms, AreNotUsedInFlexibleStreams) {
  const std::string flexible = " ! other/tensors,format=flexible ! ";
  const std::string line = transform("a", kCast) + flexible + transform("b", kLimit);
  Chain chain(line, kPixels),
      apart(transform("a", kCast) + flexible + "identity ! " + transform("b", kLimit), kPixels);
  const auto in = random_frame({300}, 1);
  EXPECT_EQ(chain.result(in), apart.result(in));
  EXPECT_EQ(chain.stat("a", "deferred-frames"), 0u);
}

TEST(FusedTransforms, RunSeparatelyIfPlansDoNotFitABlock) {
  // Channels that repeat after 6000 elements, followed by a clamp: no common block. The first frame
  // shows this, and later ones are not deferred.
  const std::string planes = "mode=arithmetic option=per-channel:true@1,add:1@0,mul:3@2";
  const std::string caps = "other/tensor,dimension=(string)2000:3,type=uint8,framerate=30/1";
  EXPECT_EQ(deferred_and_fused({{planes, "mode=clamp option=3:9"}, caps, {6000}}),
            (std::pair<uint64_t, uint64_t>{1, 0}));
}

TEST(FusedTransforms, CountDivisionsInTheElementThatRuns) {
  const std::string zero = "mode=arithmetic option=div:0";
  Chain chain(transform("a", zero) + " ! " + transform("b", zero), kPixels);
  const auto in = random_frame({300}, 1);
  EXPECT_EQ(chain.result(in), in);
  EXPECT_EQ(chain.stat("a", "integer-divisions-by-zero"), 0u);
  EXPECT_EQ(chain.stat("b", "integer-divisions-by-zero"), 600u);
}

TEST(FusedTransforms, RejectAFrameOfTheWrongSizeInTheFirstElement) {
  for (const size_t size : {299u, 3u}) {
    Chain chain(transform("a", kCast) + " ! " + transform("b", kScale), kPixels);
    chain.result(random_frame({300}, 1));
    EXPECT_EQ(chain.push(random_frame({size}, 1)), GST_FLOW_ERROR);
    const std::string error = chain.error();
    EXPECT_EQ(error.rfind("a: ", 0), 0u) << error;
    EXPECT_SAYS(error, std::to_string(size) + " bytes in memory 0");
    EXPECT_EQ(chain.stat("a", "received"), 2u);
    EXPECT_EQ(chain.stat("a", "consumed"), 1u);
    EXPECT_EQ(chain.stat("a", "dropped-error"), 1u);
    EXPECT_EQ(chain.stat("b", "received"), 1u);
  }
}

TEST(FusedTransforms, KeepTimeFlagsAndMetadata) {
  Chain chain(transform("a", kCast) + " ! " + transform("b", kScale), kPixels);
  GstBuffer* in = weir::chain_test::make_buffer(random_frame({300}, 1));
  GST_BUFFER_PTS(in) = 7;
  GST_BUFFER_DURATION(in) = 8;
  GST_BUFFER_FLAG_SET(in, GST_BUFFER_FLAG_MARKER);
  GstCaps* clock = gst_caps_new_empty_simple("timestamp/x-test");
  gst_buffer_add_reference_timestamp_meta(in, clock, 9, GST_CLOCK_TIME_NONE);
  ASSERT_EQ(gst_harness_push(chain.harness(), in), GST_FLOW_OK);
  const auto out = chain.pull();
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 7u);
  EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 8u);
  EXPECT_TRUE(GST_BUFFER_FLAG_IS_SET(out.get(), GST_BUFFER_FLAG_MARKER));
  const auto* meta = gst_buffer_get_reference_timestamp_meta(out.get(), clock);
  ASSERT_NE(meta, nullptr);
  EXPECT_EQ(meta->timestamp, 9u);
  gst_caps_unref(clock);
  EXPECT_EQ(chain.stat("b", "fused-frames"), 1u);
}

TEST(FusedTransforms, ReleaseTheInputAfterTheFrame) {
  Chain chain(transform("a", kCast) + " ! " + transform("b", kScale), kPixels);
  GstBuffer* in = weir::chain_test::make_buffer(random_frame({300}, 1));
  int gone = 0;
  gst_mini_object_weak_ref(
      GST_MINI_OBJECT_CAST(in), [](gpointer count, GstMiniObject*) { ++*static_cast<int*>(count); },
      &gone);
  ASSERT_EQ(gst_harness_push(chain.harness(), in), GST_FLOW_OK);
  EXPECT_EQ(gone, 1);
  EXPECT_TRUE(chain.pull());
}

constexpr char kAdd[] = "mode=arithmetic option=add:7";
constexpr char kMul[] = "mode=arithmetic option=mul:3";

Frame added_and_multiplied(Frame frame) {
  for (auto& bytes : frame)
    for (auto& byte : bytes) {
      const int sum = std::min(std::to_integer<int>(byte) + 7, 255);
      byte = static_cast<std::byte>(std::min(3 * sum, 255));
    }
  return frame;
}

gpointer address(GstBuffer* buffer, guint memory = 0) {
  return gst_buffer_peek_memory(buffer, memory);
}

// Fused frames of `b` that reuse the input's memory.
class FusedInPlace : public testing::Test {
 protected:
  const Frame in_ = random_frame({300}, 1);
  const Frame expected_ = added_and_multiplied(in_);
  Chain chain_{transform("a", kAdd) + " ! " + transform("b", kMul), kPixels};

  // The result for the buffer, whose ownership is passed on.
  weir::gst::Ref<GstBuffer> result(GstBuffer* in) {
    EXPECT_EQ(gst_harness_push(chain_.harness(), in), GST_FLOW_OK);
    EXPECT_EQ(chain_.stat("b", "fused-frames"), 1u);
    return chain_.pull();
  }
};

TEST_F(FusedInPlace, IfTheMemoryHasNoOtherOwner) {
  GstBuffer* in = weir::chain_test::make_buffer(in_);
  const gpointer memory = address(in);
  const auto out = result(in);
  EXPECT_EQ(address(out.get()), memory);
  EXPECT_EQ(read_frame(out.get()), expected_);
  EXPECT_EQ(chain_.stat("b", "pool-allocated"), 0u);
}

TEST_F(FusedInPlace, NotIfTheInputIsHeld) {
  const auto in = weir::gst::Ref<GstBuffer>::adopt(weir::chain_test::make_buffer(in_));
  const auto out = result(gst_buffer_ref(in.get()));
  EXPECT_NE(address(out.get()), address(in.get()));
  EXPECT_EQ(read_frame(out.get()), expected_);
  EXPECT_EQ(read_frame(in.get()), in_);
}

TEST_F(FusedInPlace, NotIfAnotherBufferSharesTheMemory) {
  const auto other = weir::gst::Ref<GstBuffer>::adopt(weir::chain_test::make_buffer(in_));
  const auto out = result(gst_buffer_copy(other.get()));
  EXPECT_EQ(read_frame(out.get()), expected_);
  EXPECT_EQ(read_frame(other.get()), in_);
}

TEST_F(FusedInPlace, NotInReadOnlyMemory) {
  static const std::vector<std::byte> bytes(300, std::byte{5});
  GstBuffer* in =
      gst_buffer_new_wrapped_full(GST_MEMORY_FLAG_READONLY, const_cast<std::byte*>(bytes.data()),
                                  300, 0, 300, nullptr, nullptr);
  EXPECT_EQ(read_frame(result(in).get()), (Frame{{300, std::byte{36}}}));
  EXPECT_EQ(bytes, (std::vector<std::byte>(300, std::byte{5})));
}

TEST_F(FusedInPlace, NotIfAProbeKeepsTheIntermediateFrame) {
  weir::gst::Ref<GstBuffer> kept;
  chain_.add_probe(
      "a", "src",
      [](GstPad*, GstPadProbeInfo* info, gpointer into) {
        *static_cast<weir::gst::Ref<GstBuffer>*>(into) =
            weir::gst::Ref<GstBuffer>::share(GST_PAD_PROBE_INFO_BUFFER(info));
        return GST_PAD_PROBE_OK;
      },
      &kept);
  const auto out = result(weir::chain_test::make_buffer(in_));
  EXPECT_EQ(read_frame(out.get()), expected_);
  for (size_t i = 0; i < 300; ++i)
    ASSERT_EQ(std::to_integer<int>(read_frame(kept.get())[0][i]),
              std::min(std::to_integer<int>(in_[0][i]) + 7, 255));
}

TEST_F(FusedInPlace, WithTheTimesAndMetadataOfTheIntermediateFrame) {
  GstBuffer* in = weir::chain_test::make_buffer(in_);
  GST_BUFFER_PTS(in) = 7;
  GstCaps* clock = gst_caps_new_empty_simple("timestamp/x-test");
  gst_buffer_add_reference_timestamp_meta(in, clock, 9, GST_CLOCK_TIME_NONE);
  chain_.add_probe(
      "a", "src",
      [](GstPad*, GstPadProbeInfo* info, gpointer) {
        GstBuffer* buffer = GST_PAD_PROBE_INFO_BUFFER(info);
        GST_BUFFER_PTS(buffer) = 70;
        gst_buffer_get_reference_timestamp_meta(buffer, nullptr)->timestamp = 90;
        return GST_PAD_PROBE_OK;
      },
      nullptr);
  const gpointer memory = address(in);
  const auto out = result(in);
  EXPECT_EQ(address(out.get()), memory);
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 70u);
  EXPECT_EQ(gst_buffer_get_n_meta(out.get(), GST_REFERENCE_TIMESTAMP_META_API_TYPE), 1u);
  EXPECT_EQ(gst_buffer_get_reference_timestamp_meta(out.get(), clock)->timestamp, 90u);
  gst_caps_unref(clock);
}

TEST(FusedTransforms, ASingleOneDoesNotChangeReadOnlyMemory) {
  static const std::vector<std::byte> bytes(300, std::byte{5});
  Chain chain(transform("a", kAdd), kPixels);
  GstBuffer* in =
      gst_buffer_new_wrapped_full(GST_MEMORY_FLAG_READONLY, const_cast<std::byte*>(bytes.data()),
                                  300, 0, 300, nullptr, nullptr);
  ASSERT_EQ(gst_harness_push(chain.harness(), in), GST_FLOW_OK);
  EXPECT_EQ(read_frame(chain.pull().get()), (Frame{{300, std::byte{12}}}));
  EXPECT_EQ(bytes, (std::vector<std::byte>(300, std::byte{5})));
}

TEST(FusedTransforms, SeveralTensorsAndStepsRunInPlace) {
  Chain chain(transform("a", kAdd) + " ! " + transform("b", kMul) + " ! " +
                  transform("c", "mode=clamp option=9:99"),
              many(3));
  const auto frame = random_frame({3, 6, 9}, 1);
  GstBuffer* in = weir::chain_test::make_buffer(frame);
  const gpointer memories[] = {address(in), address(in, 1), address(in, 2)};
  ASSERT_EQ(gst_harness_push(chain.harness(), in), GST_FLOW_OK);
  const auto out = chain.pull();
  auto expected = added_and_multiplied(frame);
  for (auto& bytes : expected)
    for (auto& byte : bytes)
      byte = static_cast<std::byte>(std::clamp(std::to_integer<int>(byte), 9, 99));
  EXPECT_EQ(read_frame(out.get()), expected);
  for (guint i = 0; i < 3; ++i) EXPECT_EQ(address(out.get(), i), memories[i]);
  EXPECT_EQ(chain.stat("c", "fused-frames"), 1u);
}

TEST(FusedTransforms, AChangeOfSizeIsNotInPlace) {
  Chain chain(transform("a", kAdd) + " ! " + transform("b", kCast), kPixels);
  GstBuffer* in = weir::chain_test::make_buffer(random_frame({300}, 1));
  ASSERT_EQ(gst_harness_push(chain.harness(), in), GST_FLOW_OK);
  EXPECT_EQ(gst_buffer_get_size(chain.pull().get()), 1200u);
  EXPECT_EQ(chain.stat("b", "pool-allocated"), 1u);
}

}  // namespace fused_transforms_test
