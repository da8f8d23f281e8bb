// tensor_converter with raw audio.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/converter_test_support.hpp"
#include "elements/tests/pipeline_test_support.hpp"

namespace audio_test {

using namespace weir::testing_tensor_converter;

std::string audio(const std::string& format, int channels = 2, int rate = 48000) {
  return "audio/x-raw,format=" + format + ",rate=" + std::to_string(rate) +
         ",channels=" + std::to_string(channels) + ",channel-mask=(bitmask)0x0,layout=interleaved";
}

class AudioFormat : public testing::TestWithParam<std::tuple<const char*, const char*, size_t>> {};

TEST_P(AudioFormat, BecomesATensorWithoutACopy) {
  const auto [format, type, bytes] = GetParam();
  auto h = harness("frames-per-tensor=5", audio(format));
  const Bytes in = ramp(2 * 5 * bytes);
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(in)));
  ASSERT_TRUE(out);
  EXPECT_SAYS(caps_text(h), std::string("types=(string)") + type);
  EXPECT_SAYS(caps_text(h), "dimensions=(string)2:5,");
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)48000/1");
  EXPECT_EQ(content(out.get()), in);
  EXPECT_EQ(stat(h, "bytes-copied"), 0u);
}
INSTANTIATE_TEST_SUITE_P(
    All, AudioFormat,
    testing::Values(std::tuple{"S8", "int8", 1u}, std::tuple{"U8", "uint8", 1u},
                    std::tuple{"S16LE", "int16", 2u}, std::tuple{"U16LE", "uint16", 2u},
                    std::tuple{"S32LE", "int32", 4u}, std::tuple{"U32LE", "uint32", 4u},
                    std::tuple{"F32LE", "float32", 4u}, std::tuple{"F64LE", "float64", 8u}));

// Buffers of 1024, 1000 and 7 frames in turn, tensors of 480: each sample appears once, in order,
// with its time.
TEST(ConverterAudio, CutsAndGathersFramesAtTheirTime) {
  auto h = harness("frames-per-tensor=480", audio("S16LE", 1, 44100));
  constexpr size_t kSizes[] = {1024, 1000, 7};
  std::vector<int16_t> samples(1'000'000);
  std::iota(samples.begin(), samples.end(), int16_t{0});
  size_t at = 0, tensors = 0;
  const auto time_at = [](uint64_t sample) { return sample * 10'000'000 / 441; };
  for (size_t i = 0; at < samples.size(); ++i) {
    const size_t count = std::min(kSizes[i % 3], samples.size() - at);
    GstBuffer* b = gst_buffer_new_allocate(nullptr, 2 * count, nullptr);
    gst_buffer_fill(b, 0, samples.data() + at, 2 * count);
    ASSERT_EQ(gst_harness_push(h.get(), b), GST_FLOW_OK);
    at += count;
    while (GstBuffer* raw = gst_harness_try_pull(h.get())) {
      const auto out = Ref<GstBuffer>::adopt(raw);
      const size_t first = 480 * tensors++;
      const Mapped map(raw, GST_MAP_READ);
      const auto got = map.as<const int16_t>();
      ASSERT_TRUE(std::equal(got.begin(), got.end(), samples.begin() + long(first),
                             samples.begin() + long(first) + 480));
      // Rounded down once each: the timestamp of the buffer that holds its first frame, and its
      // frames in it.
      ASSERT_LE(time_at(first) - GST_BUFFER_PTS(raw), 1u) << first;
    }
  }
  EXPECT_EQ(tensors, samples.size() / 480);
  EXPECT_EQ(stat(h, "held"), 1u);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  EXPECT_EQ(stat(h, "dropped-eos"), 1u);
}

TEST(ConverterAudio, OfOtherFormatsIsRefusedWithALineToPaste) {
  for (const char* format : {"S16BE", "F32BE"}) {
    const auto text = caps_error("", audio(format));
    EXPECT_SAYS(text, "WEIR-2002: this audio format cannot be a tensor");
    EXPECT_SAYS(text, std::string("offered: ") + format);
    EXPECT_SAYS(text,
                "fix: audioconvert ! audio/x-raw,format=S16LE,layout=interleaved ! "
                "tensor_converter");
  }
}

TEST(ConverterAudio, IsComparedWithTheProperties) {
  const auto text = caps_error("input-dim=1:1 input-type=int16", audio("S16LE"));
  EXPECT_SAYS(text, "WEIR-2001: the audio does not match input-dim and input-type");
  EXPECT_SAYS(text, "dimension is 2:1, needed is 1:1");
  auto h = harness("input-dim=2 input-type=int16", audio("S16LE"));
  EXPECT_EQ(get_error(h, frame(Bytes(4))), "");
}

TEST(ConverterAudio, OfPartsOfAFrameIsRefused) {
  auto h = harness("", audio("S16LE"));
  for (const size_t size : {1, 3, 5, 4095}) {
    const auto text = get_error(h, frame(Bytes(size)));
    EXPECT_SAYS(text, "WEIR-2004: a buffer does not hold whole frames");
    EXPECT_SAYS(text, "a multiple of 4 bytes for 1 tensor: int16 2:1");
  }
  EXPECT_SAYS(get_error(h, gst_buffer_new()), "WEIR-2004: a buffer is empty");
  EXPECT_EQ(stat(h, "dropped-error"), 5u);
}

TEST(ConverterAudio, TakesOtherCapsInTheMiddleOfAStream) {
  auto h = harness("frames-per-tensor=4", audio("S16LE"));
  ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes(8))), GST_FLOW_OK);
  EXPECT_EQ(change_caps(h, audio("F32LE", 1)), "");
  EXPECT_EQ(stat(h, "dropped-flush"), 1u);
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(ramp(16))));
  EXPECT_EQ(content(out.get()), ramp(16));
  EXPECT_SAYS(caps_text(h), "types=(string)float32");
  EXPECT_SAYS(change_caps(h, audio("F32BE", 1)), "this audio format cannot be a tensor");
}

TEST(ConverterAudio, OfAnotherRateIsNotAppendedToHeldSamples) {
  const std::string caps = "audio/x-raw,format=S16LE,layout=interleaved,channels=1,rate=";
  auto h = harness("frames-per-tensor=160", caps + "16000");
  ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes(1000))), GST_FLOW_OK);  // 20 samples wait
  for (int i = 0; i < 3; ++i) gst_buffer_unref(gst_harness_pull(h.get()));
  EXPECT_EQ(change_caps(h, caps + "8000"), "");
  EXPECT_EQ(stat(h, "dropped-flush"), 1u) << "the buffer of which a part waited";
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(ramp(320))));
  EXPECT_EQ(content(out.get()), ramp(320));
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 500 * GST_SECOND / 16000) << "after the 500 samples";
  EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 20 * GST_MSECOND);
}

TEST(ConverterAudio, WarnsAboutMoreThan64Channels) {
  auto h = harness("", audio("S16LE", 64));
  const auto warning_for = [&h](int channels) {
    Errors messages(h);
    const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(audio("S16LE", channels).c_str()));
    EXPECT_TRUE(gst_harness_push_event(h.get(), gst_event_new_caps(caps.get())));
    return messages.next_warning();
  };
  EXPECT_EQ(warning_for(63), "");
  const auto warning = warning_for(65);
  EXPECT_SAYS(
      warning,
      "WEIR-2001: the audio has 65 channels, so each tensor has one sample of every channel");
  EXPECT_SAYS(warning, "offered: channels=65");
  EXPECT_SAYS(warning, "fix: audio/x-raw,channels=1 ! tensor_converter frames-per-tensor=65");
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(ramp(130))));
  EXPECT_EQ(content(out.get()), ramp(130)) << "the stream goes on";
}

// GStreamer logs criticals, which end this program, when audioconvert makes so many channels.
TEST(ConverterAudio, IsNotConvertedToThousandsOfChannels) {
  const std::string source = "audiotestsrc num-buffers=40 ! audioconvert ! audioresample ! ",
                    row =
                        " ! other/tensors,format=static,num_tensors=1,types=float32,"
                        "dimensions=(string)16000 ! tensor_sink name=out";
  PlayedPipeline refused(source + "tensor_converter" + row);
  EXPECT_FALSE(refused.reaches(GST_STATE_PLAYING));
  const auto text = refused.outcome();
  EXPECT_SAYS(text, "WEIR-2001: the downstream element needs 16000 consecutive samples");
  const std::string fix =
      "audio/x-raw,format=F32LE,channels=1 ! tensor_converter frames-per-tensor=16000 ! "
      "tensor_transform mode=transpose option=1:0:2:3";
  EXPECT_SAYS(text, "fix: audioconvert ! audioresample ! " + fix);
  PlayedPipeline mended(source + fix + row);
  mended.watch("out");
  EXPECT_TRUE(mended.reaches(GST_STATE_PLAYING));
  EXPECT_EQ(mended.outcome(), "");
  ASSERT_EQ(mended.seen<float>("out").size(), 40u * 1024 / 16000);
  EXPECT_EQ(mended.seen<float>("out")[0].size(), 16000u);
}

TEST(ConverterAudio, FollowsTheCapsOfDownstream) {
  Harness h{gst_harness_new_parse("tensor_converter")};
  gst_harness_set_sink_caps_str(
      h.get(), "other/tensor,dimension=(string)2:160,type=(string)int16,framerate=16000/1");
  const std::string any =
      "audio/x-raw,format={F32LE,S16LE},channels=[1,8],rate=[1,96000],"
      "layout=interleaved";
  const std::string fits =
      "audio/x-raw, format=(string)S16LE, channels=(int)2, "
      "rate=(int)16000, layout=(string)interleaved";
  EXPECT_EQ(accepted(h, any), fits);
  // What does not fit is taken, so that the element that rejects it can post why.
  EXPECT_SAYS(accepted(h, "audio/x-raw,format=S16LE,channels=1,rate=8000"), "channels=(int)1");
  gst_harness_set_sink_caps_str(
      h.get(), "other/tensor,dimension=(string)2:160,type=(string)float16,framerate=16000/1");
  EXPECT_SAYS(accepted(h, any), "format=(string){ F32LE, S16LE }");
  gst_harness_set_sink_caps_str(h.get(), "other/tensor,dimension=(string)2:160");
  const std::string channels = "audio/x-raw, format=(string){ F32LE, S16LE }, channels=(int)2, ";
  EXPECT_EQ(accepted(h, any).substr(0, channels.size()), channels) << "of any type";
}

}  // namespace audio_test
