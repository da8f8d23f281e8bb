// Tests of modes json and webvtt in pipelines: caps fields, times, flushes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdio>
#include <fstream>

#include "elements/tensor_decoder/decoder_test_support.hpp"
#include "gstcpp/element/result_events.hpp"

namespace weir::testing_tensor_decoder {
namespace records_test {

std::string results(const std::string& columns, const std::string& dimensions) {
  return tensor("float32", dimensions) + ",weir-columns=(string)\"" + columns +
         "\",weir-source=(string)yolo";
}
const std::vector<float> kRow{1, 2, 3, 4, 0.5f, 1};

std::string decode_text(const Harness& h, GstBuffer* in) {
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  if (!out) return "(nothing)";
  const Bytes bytes = content(out.get());
  return {bytes.begin(), bytes.end()};
}

TEST(TensorDecoderRecords, JsonHasTheFieldsOfTheCapsAndTheRunningTime) {
  const auto h = harness("mode=json", results("x1,y1,x2,y2,score,class", "6:1"));
  EXPECT_EQ(decode_text(h, test::frame(kRow, 2 * GST_SECOND)),
            R"({"version":1,"time":2,"source":"yolo","detections":[{"box":[1,2,3,4],"score":0.5,)"
            R"("index":1,"label":"1"}]})"
            "\n");
  EXPECT_SAYS(caps_text(h), "application/x-json");
}

TEST(TensorDecoderRecords, TimeIsOfTheRunAndNotOfTheSegment) {
  const auto h = harness("mode=json", results("score,class", "2:1"));
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  segment.start = segment.time = 10 * GST_SECOND;
  gst_harness_push_event(h.get(), gst_event_new_segment(&segment));
  EXPECT_SAYS(decode_text(h, test::frame<float>({1, 1}, 10 * GST_SECOND + 5)),
              "\"time\":0.000000005");
  EXPECT_LACKS(decode_text(h, test::frame<float>({1, 1})), "\"time\"");
}

TEST(TensorDecoderRecords, UtcIsThatOfReferenceTimestamps) {
  const auto h = harness("mode=json", results("score,class", "2:1"));
  const auto with = [&](const char* media_type, GstClockTime time) {
    GstBuffer* buffer = test::frame<float>({1, 1}, 0);
    const auto caps = Ref<GstCaps>::adopt(gst_caps_new_empty_simple(media_type));
    gst_buffer_add_reference_timestamp_meta(buffer, caps.get(), time, GST_CLOCK_TIME_NONE);
    return decode_text(h, buffer);
  };
  // date -u -d @1709208000 says 2024-02-29 12:00:00; NTP counts from 1900-01-01.
  EXPECT_SAYS(with("timestamp/x-unix", 1709208000 * GST_SECOND),
              "\"utc\":\"2024-02-29T12:00:00Z\"");
  EXPECT_SAYS(with("timestamp/x-ntp", (1709208000 + 2208988800) * GST_SECOND + GST_SECOND / 2),
              "\"utc\":\"2024-02-29T12:00:00.5Z\"");
  EXPECT_LACKS(with("timestamp/x-ntp", GST_SECOND), "utc");
  EXPECT_LACKS(with("timestamp/x-drifted", 5), "utc");
}

TEST(TensorDecoderRecords, AFlushBeginsTheTextAgain) {
  const auto h = harness("mode=webvtt", results("score,class", "2:1"));
  const auto cue = [&] { return decode_text(h, test::frame<float>({1, 1}, 0, 40 * GST_MSECOND)); };
  EXPECT_EQ(cue(), "WEBVTT\n\n00:00:00.000 --> 00:00:00.040\n1 100 %\n\n");
  EXPECT_EQ(cue(), "00:00:00.000 --> 00:00:00.040\n1 100 %\n\n");
  gst_harness_push_event(h.get(), gst_event_new_flush_start());
  gst_harness_push_event(h.get(), gst_event_new_flush_stop(TRUE));
  gst_harness_push_event(h.get(), time_segment());
  EXPECT_SAYS(cue(), "WEBVTT");
}

TEST(TensorDecoderRecords, FramesWithoutLinesAreCountedAsDropped) {
  const auto h = harness("mode=mot", results("x1,y1,x2,y2,score,class", "6:1"));
  EXPECT_EQ(gst_harness_push(h.get(), test::frame(std::vector<float>(6), 0)), GST_FLOW_OK);
  EXPECT_EQ(decode_text(h, test::frame(kRow, 1)), "2,-1,2,3,2,2,0.5,2,1\n");
  EXPECT_EQ(stat(h, "received"), 2u);
  EXPECT_EQ(stat(h, "dropped"), 1u);
}

TEST(TensorDecoderRecords, LabelsComeWithTheStreamBetweenAnyFrames) {
  const auto h = harness("mode=json", results("score,class", "2:1"));
  const auto label = [&] {
    const std::string text = decode_text(h, test::frame<float>({1, 1}));
    const size_t at = text.find("\"label\":");
    return at == std::string::npos ? text : text.substr(at, text.find('}') - at);
  };
  const auto send = [&](const gst::LabelsOfSource& labels) {
    EXPECT_TRUE(gst_harness_push_event(h.get(), gst::make_labels_event(labels).release()));
  };
  EXPECT_EQ(label(), "\"label\":\"1\"");
  send({"another", {"red", "blue"}});
  EXPECT_EQ(label(), "\"label\":\"1\"") << "the labels of another source";
  send({"yolo", {"cat", "dog"}});
  EXPECT_EQ(label(), "\"label\":\"dog\"");
  send({"yolo", {"cat"}});
  EXPECT_EQ(label(), "\"label\":\"1\"") << "fewer labels than classes";
}

TEST(TensorDecoderRecords, LabelsOfTheUserCountMoreThanThoseOfTheStream) {
  const std::string path = testing::TempDir() + "weir-record-labels.txt";
  std::ofstream(path) << "un\ndeux\n";
  const auto h = harness("mode=json labels=" + path, results("score,class", "2:1"));
  gst_harness_push_event(h.get(), gst::make_labels_event({"yolo", {"cat", "dog"}}).release());
  EXPECT_SAYS(decode_text(h, test::frame<float>({1, 1})), "\"label\":\"deux\"");
  std::remove(path.c_str());
}

TEST(TensorDecoderRecords, RefusesColumnsThatTheTensorsDoNotHave) {
  const std::string error = get_error("mode=json", results("x1,y1,x2,y2,score,class", "5:1"));
  EXPECT_SAYS(error, "WEIR-2001: a tensor of results does not match weir-columns");
  EXPECT_SAYS(error, "needed: float32 6:N");
}

}  // namespace records_test
}  // namespace weir::testing_tensor_decoder
