// Errors of tensor_overlay and their texts.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_overlay/overlay_test_support.hpp"
#include "elements/tests/invalid_video_meta_test_support.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir::overlay_test {
namespace overlay_errors_test {

TEST(OverlayRejects, ResultsOfAnotherLayout) {
  for (const std::string& caps :
       {tensors("uint8", "6:2"), tensors("float32", "3:2"), tensors("float32", "7:2"),
        tensors("float32", "6:2:2"), tensors("float32,float32", "6:2,6:2"),
        tensors("float32", "4000:1")}) {
    const Both b("", video("RGB", 8, 6), "");
    Errors errors(b.element.get());
    gst_harness_set_src_caps_str(b.results.get(), caps.c_str());
    const auto text = errors.next();
    EXPECT_SAYS(text, "WEIR-2001: the stream of results does not contain boxes");
    EXPECT_SAYS(text, "rows of x1, y1, x2, y2, then score, class");
  }
}

TEST(OverlayRejects, FlexibleFramesOfSeveralTensors) {
  const Both b("", video("RGB", 8, 6), "other/tensors,format=flexible,framerate=10/1");
  Errors errors(b.element.get());
  EXPECT_EQ(gst_harness_push(b.results.get(), frame(Bytes(5), 0)), GST_FLOW_ERROR);
  EXPECT_SAYS(errors.next(), "WEIR-2005");
  EXPECT_EQ(b.stat("results-refused"), 1u);
  b.expect_results_balance();
}

TEST(OverlayRejects, ResultsThatAreTooShort) {
  const Both b("");
  Errors errors(b.element.get());
  EXPECT_EQ(b.push({1, 2, 3}, 0), GST_FLOW_ERROR);
  EXPECT_SAYS(errors.next(), "WEIR-2004");
  EXPECT_EQ(b.stat("results-refused"), 1u);
  EXPECT_EQ(b.picture(kSmall, 0), Bytes(kSmall));
}

TEST(OverlayRejects, ResultsBeforeTheirCaps) {
  const auto element = lone_element("tensor_overlay show-scores=false");
  Errors errors(element.get());
  gst_element_set_state(element.get(), GST_STATE_PLAYING);
  const auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "results"));
  gst_pad_send_event(pad.get(), gst_event_new_stream_start("test"));
  gst_pad_send_event(pad.get(), time_segment());
  EXPECT_EQ(gst_pad_chain(pad.get(), frame<float>({0, 0, 1, 1}, 0)), GST_FLOW_ERROR);
  const auto text = errors.next();
  EXPECT_SAYS(text, "WEIR-2003: a buffer arrived before caps");
  gst_element_set_state(element.get(), GST_STATE_NULL);
}

TEST(OverlayRejects, ResultsWithoutASourceMap) {
  const Both b("coordinates=tensor", video("RGB", 8, 6), floats(6, 2));
  Errors errors(b.element.get());
  EXPECT_EQ(b.push(std::vector<float>(12), 0), GST_FLOW_ERROR);
  auto text = errors.next();
  EXPECT_SAYS(text, "the results have no source map to the picture");
  EXPECT_SAYS(text, "fix: tensor_overlay coordinates=picture");
  GstBuffer* three = frame<float>(std::vector<float>(12), 0);
  gst::set_source_maps(three, std::vector<SourceMap>(3), gst::MapsOf::Regions);
  EXPECT_EQ(gst_harness_push(b.results.get(), three), GST_FLOW_ERROR);
  text = errors.next();
  EXPECT_SAYS(text, "number of source maps differs from the number of rows");
  EXPECT_SAYS(text, "3 source maps");
}

TEST(OverlayRejects, AFormatItCannotDrawInto) {
  const Both b("", "");
  Errors errors(b.element.get());
  gst_harness_set_src_caps_str(b.pictures.get(), video("Y42B", 8, 6).c_str());
  EXPECT_EQ(gst_harness_push(b.pictures.get(), frame(Bytes(96))), GST_FLOW_NOT_NEGOTIATED);
  const auto text = errors.next();
  EXPECT_SAYS(text, "WEIR-2002: tensor_overlay cannot draw into pictures of this format");
  EXPECT_SAYS(text, "offered: Y42B");
  EXPECT_SAYS(text, "GRAY8, NV12, NV21, I420");
  EXPECT_SAYS(text, "fix: videoconvert ! tensor_overlay");
  EXPECT_EQ(b.stat("received"), b.stat("dropped"));
}

TEST(OverlayRejects, APictureThatIsTooShort) {
  const Both b("");
  b.push({1, 1, 7, 6, 1, 0}, 0);
  Errors errors(b.element.get());
  EXPECT_TRUE(b.picture(kSmall - 1, 0).empty());
  EXPECT_SAYS(errors.next(), "WEIR-2004: a video buffer is smaller than its caps require");
  EXPECT_EQ(b.stat("dropped-error"), 1u);
  EXPECT_EQ(b.picture(kSmall, 0), small_with({{1, 1, 7, 6}}));
}

TEST(OverlayRejects, InvalidMetadata) {
  for (const auto& meta : invalid_video_metas(8, 6)) {
    const Both b("");
    b.push({1, 1, 7, 6, 1, 0}, 0);
    Errors errors(b.element.get());
    GstBuffer* in = with_invalid_meta(timed(frame(Bytes(kSmall)), 0), 8, 6, meta);
    EXPECT_EQ(gst_harness_push(b.pictures.get(), in), GST_FLOW_ERROR);
    EXPECT_SAYS(errors.next(), meta.message);
    EXPECT_EQ(b.stat("dropped-error"), 1u);
    b.expect_results_balance();
  }
}

TEST(OverlayRejects, InvalidLabelFiles) {
  const auto missing = start_error("tensor_overlay labels=/nonexistent.txt");
  EXPECT_SAYS(missing, "WEIR-4001: the label file cannot be read");
  EXPECT_SAYS(missing, "labels=/nonexistent.txt");
  EXPECT_SAYS(start_error("tensor_overlay labels=/proc/self/exe"), "WEIR-4002");
}

}  // namespace overlay_errors_test
}  // namespace weir::overlay_test
