// tensor_converter with text.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/converter_test_support.hpp"

namespace text_test {

using namespace weir::testing_tensor_converter;

constexpr char kText[] = "text/x-raw,format=utf8";
constexpr char kTimedText[] = "text/x-raw,format=utf8,framerate=2/1";

GstBuffer* text(const std::string& words) {
  return frame(Bytes(words.begin(), words.end()));
}
std::string words(GstBuffer* buffer) {
  const Bytes bytes = content(buffer);
  return {bytes.begin(), bytes.end()};
}

TEST(ConverterText, IsATensorOfBytesWithoutACopy) {
  auto h = harness("input-dim=5", kTimedText);
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), text("words")));
  EXPECT_EQ(words(out.get()), "words");
  EXPECT_SAYS(caps_text(h), "dimensions=(string)5:1,");
  EXPECT_SAYS(caps_text(h), "types=(string)uint8");
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)2/1");
  EXPECT_EQ(stat(h, "bytes-copied"), 0u);
}

TEST(ConverterText, IsPaddedWithZerosAndKeepsItsTime) {
  auto h = harness("input-dim=6:1", kText);
  GstBuffer* in = text("ab");
  GST_BUFFER_PTS(in) = 7;
  GST_BUFFER_DURATION(in) = 3;
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  EXPECT_EQ(words(out.get()), std::string("ab\0\0\0\0", 6));
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 7u);
  EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 3u);
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)0/1");
  EXPECT_EQ(stat(h, "bytes-copied"), 2u);
}

TEST(ConverterText, IsCutAndKeepsItsTimeAndTheFirstCutIsReported) {
  auto h = harness("input-dim=4", kText);
  Errors errors(h);
  for (int i = 0; i < 2; ++i) {
    GstBuffer* in = text("too long");
    GST_BUFFER_PTS(in) = 7;
    GST_BUFFER_DURATION(in) = 3;
    auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
    EXPECT_EQ(words(out.get()), "too ");
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), 7u);
    EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 3u);
  }
  const auto warning = errors.next_warning();
  EXPECT_SAYS(warning, "WEIR-2004: a text is longer than input-dim and is truncated");
  EXPECT_SAYS(warning, "fix: tensor_converter input-dim=8");
  EXPECT_EQ(errors.next_warning(), "");
  EXPECT_EQ(stat(h, "bytes-copied"), 0u);
}

TEST(ConverterText, GathersTextsOfAnySize) {
  auto h = harness("input-dim=3 frames-per-tensor=3", kTimedText);
  for (const char* word : {"a", "abcd", "abc", "x"})
    ASSERT_EQ(gst_harness_push(h.get(), text(word)), GST_FLOW_OK);
  auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(words(out.get()), std::string("a\0\0abcabc", 9));
  EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 3 * GST_SECOND / 2);
  EXPECT_SAYS(caps_text(h), "dimensions=(string)3:3,");
  EXPECT_EQ(stat(h, "held"), 1u);
}

TEST(ConverterText, OfSeveralMemoriesIsOne) {
  auto h = harness("input-dim=4", kText);
  auto out = Ref<GstBuffer>::adopt(
      gst_harness_push_and_pull(h.get(), gst_buffer_append(text("ab"), text("cd"))));
  EXPECT_EQ(words(out.get()), "abcd");
  EXPECT_EQ(gst_buffer_n_memory(out.get()), 1u);
  EXPECT_EQ(stat(h, "bytes-copied"), 4u);
}

TEST(ConverterText, NeedsASize) {
  for (const char* properties : {"", "input-type=uint8", "input-dim=3,4"}) {
    const auto error = caps_error(properties, kText);
    EXPECT_SAYS(error, "WEIR-1004: the size of a text is unknown");
    EXPECT_SAYS(error, "fix: tensor_converter input-dim=300");
  }
  EXPECT_SAYS(caps_error("input-dim=0", kText), "WEIR-1002");
  EXPECT_SAYS(caps_error("input-dim=3 input-type=int8", kText), "type is uint8, needed is int8");
}

TEST(ConverterText, OfNoBytesIsRefused) {
  auto h = harness("input-dim=4", kText);
  EXPECT_SAYS(get_error(h, gst_buffer_new()), "WEIR-2004: a buffer is empty");
  EXPECT_EQ(stat(h, "dropped-error"), 1u);
}

TEST(ConverterText, FollowsOtherCapsInTheMiddleOfAStream) {
  auto h = harness("input-dim=4 frames-per-tensor=2", kText);
  ASSERT_EQ(gst_harness_push(h.get(), text("ab")), GST_FLOW_OK);
  EXPECT_EQ(change_caps(h, kTimedText), "");
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), text("cd")));
  EXPECT_EQ(words(out.get()), std::string("ab\0\0cd\0\0", 8));
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)2/1");
}

}  // namespace text_test
