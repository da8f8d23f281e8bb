// tensor_decoder in a harness with the decoders of this build; each decoder has its own tests.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fstream>

#include "elements/tensor_decoder/decoder_test_support.hpp"
#include "gstcpp/element/property_file.hpp"

namespace weir::testing_tensor_decoder {
namespace tensor_decoder_test {

std::string label_file(const std::string& text, const char* name = "weir-labels.txt") {
  const std::string path = testing::TempDir() + name;
  std::ofstream(path, std::ios::binary) << text;
  return path;
}
std::string labeling(const std::string& labels) {
  return "mode=image_labeling option1=" + label_file(labels);
}
Bytes text(const std::string& label) {
  Bytes out(label.begin(), label.end());
  out.push_back(0);
  return out;
}

TEST(TensorDecoder, GivesTheLabelOfTheHighestScore) {
  auto h = harness(labeling("cat\ndog\nfish\n"), tensor("uint8", "3:1"));
  EXPECT_EQ(decoded(h, frame(Bytes{1, 200, 3})), text("dog"));
  EXPECT_EQ(decoded(h, frame(Bytes{7, 7, 3})), text("cat")) << "the first of equals";
  EXPECT_SAYS(caps_text(h), "text/x-raw");
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)30/1");
  EXPECT_EQ(stat(h, "consumed"), 2u);
}

TEST(TensorDecoder, NeedsALabelFile) {
  EXPECT_SAYS(get_error("mode=image_labeling"), "mode=image_labeling has no label file");
  EXPECT_SAYS(get_error("mode=image_labeling option1=/nowhere/labels.txt"), "WEIR-4001");
  EXPECT_SAYS(get_error("mode=image_labeling option1=/nowhere/labels.txt"), "/nowhere/labels.txt");
}

TEST(TensorDecoder, RefusesOtherShapes) {
  for (const char* shape : {"3:2", "1:3", "3:1:2"}) {
    const std::string message = get_error(labeling("a\nb\nc"), tensor("uint8", shape), Bytes(6));
    EXPECT_SAYS(message, "WEIR-2001");
    EXPECT_SAYS(message, "one score for each class");
    EXPECT_SAYS(message, std::string("uint8 ") + shape);
  }
}

TEST(TensorDecoder, ChoosesTheFormatByTheChannels) {
  const std::pair<const char*, const char*> defaults[] = {
      {"1:4:2", "GRAY8"}, {"3:4:2", "RGB"}, {"4:4:2", "BGRx"}};
  for (const auto& [shape, format] : defaults) {
    auto h = harness("mode=direct_video", tensor("uint8", shape));
    const Bytes pixels(static_cast<size_t>(shape[0] - '0') * 8, 5);
    EXPECT_EQ(decoded(h, frame(pixels)), pixels);
    EXPECT_SAYS(caps_text(h), std::string("format=(string)") + format);
    EXPECT_SAYS(caps_text(h), "width=(int)4, height=(int)2");
    EXPECT_EQ(stat(h, "bytes-copied"), 0u);
  }
}

TEST(TensorDecoder, PadsRowsToFourBytes) {
  auto h = harness("mode=direct_video", tensor("uint8", "3:3:2"));
  Bytes pixels(18);
  for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<uint8_t>(i);
  const Bytes out = decoded(h, frame(pixels));
  ASSERT_EQ(out.size(), 24u);
  EXPECT_EQ(Bytes(out.begin(), out.begin() + 9), Bytes(pixels.begin(), pixels.begin() + 9));
  EXPECT_EQ(Bytes(out.begin() + 12, out.begin() + 21), Bytes(pixels.begin() + 9, pixels.end()));
}

TEST(TensorDecoder, RefusesWhatIsNoPicture) {
  for (const auto& caps : {tensor("uint8", "2:4:2"), tensor("float32", "3:4:2"),
                           tensor("uint16", "3:4:2"), tensor("uint8", "3:4:2:2")}) {
    const std::string message = get_error("mode=direct_video", caps, Bytes(96));
    EXPECT_SAYS(message, "WEIR-2001");
    EXPECT_SAYS(message, "needs one picture");
  }
}

// A query must not post an error, which would stop the pipeline.
TEST(TensorDecoder, PostsNoErrorForAQuery) {
  auto h = harness("mode=direct_video", "");
  Errors errors(h);
  const auto element = find_element(h, "tensor_decoder");
  const auto sink = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "sink"));
  const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(tensor("float32", "3:4:2").c_str()));
  Ref<GstCaps>::adopt(gst_pad_query_caps(sink.get(), caps.get()));
  gst_pad_query_accept_caps(sink.get(), caps.get());
  EXPECT_EQ(errors.next(), "");
  gst_pad_send_event(sink.get(), gst_event_new_stream_start("test"));
  EXPECT_FALSE(gst_pad_send_event(sink.get(), gst_event_new_caps(caps.get())));
  EXPECT_SAYS(errors.next(), "needs one picture") << "caps do post it";
  EXPECT_EQ(errors.next(), "");
}

TEST(TensorDecoder, CountsAFrameThatMeetsAFlushAsFlushed) {
  auto h = harness("mode=octet_stream", tensor("uint8", "4"));
  gst_buffer_unref(gst_harness_push_and_pull(h.get(), frame(Bytes(4))));
  const auto source = Ref<GstPad>::adopt(
      gst_element_get_static_pad(find_element(h, "tensor_decoder").get(), "src"));
  gst_harness_set_sink_caps_str(h.get(), "video/x-raw");  // the next buffer fails to negotiate
  gst_pad_push_event(source.get(), gst_event_new_flush_start());
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes(4))), GST_FLOW_FLUSHING);
  EXPECT_EQ(stat(h, "dropped-flush"), 1u);
  EXPECT_EQ(stat(h, "dropped-error"), 0u);
}

TEST(TensorDecoder, NeedsAStaticStream) {
  const std::string message =
      get_error("mode=direct_video", "other/tensors,format=flexible,framerate=30/1", Bytes(128));
  EXPECT_SAYS(message, "WEIR-2002");
  EXPECT_SAYS(message, "fix: tensor_converter ! tensor_decoder");
}

TEST(TensorDecoder, GivesTheBytesOfEachTensor) {
  auto h = harness("mode=octet_stream",
                   "other/"
                   "tensors,format=static,num_tensors=2,dimensions=(string)\"2,3\",types=(string)"
                   "\"uint8,uint8\",framerate=30/1");
  GstBuffer* in = frame(Bytes{1, 2});
  gst_buffer_append_memory(in, gst_memory_ref(gst_buffer_peek_memory(
                                   Ref<GstBuffer>::adopt(frame(Bytes{3, 4, 5})).get(), 0)));
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  EXPECT_EQ(gst_buffer_n_memory(out.get()), 2u);
  EXPECT_EQ(content(out.get()), (Bytes{1, 2, 3, 4, 5}));
  EXPECT_SAYS(caps_text(h), "application/octet-stream");
  EXPECT_EQ(stat(h, "bytes-copied"), 0u);
}

TEST(TensorDecoder, TakesTheHeadersOffFlexibleTensors) {
  const Unique<GstElement, gst_object_unref> pipeline(gst_parse_launch(
      "videotestsrc num-buffers=1 pattern=white ! video/x-raw,format=GRAY8,width=4,height=2 ! "
      "tensor_converter ! "
      "other/tensors,format=flexible ! tensor_decoder mode=octet_stream ! appsink name=out",
      nullptr));
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  const auto sink = Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline.get()), "out"));
  GstSample* raw = nullptr;
  g_signal_emit_by_name(sink.get(), "pull-sample", &raw);
  const Unique<GstSample, gst_sample_unref> sample(raw);
  ASSERT_TRUE(sample);
  EXPECT_EQ(content(gst_sample_get_buffer(sample.get())), Bytes(8, 235));
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
}

TEST(TensorDecoder, NeedsAMode) {
  const std::string message = get_error("");
  EXPECT_SAYS(message, "no mode is set");
  EXPECT_SAYS(message,
              "bounding_boxes, classification, coco, depth, detection, direct_video, erring, ");
}

TEST(TensorDecoder, GuessesTheModeThatWasMeant) {
  const std::string message = get_error("mode=image_labelling");
  EXPECT_SAYS(message, "WEIR-3010");
  EXPECT_SAYS(message, "did you mean image_labeling?");
  EXPECT_SAYS(get_error("mode=../octet_stream"), "WEIR-3010");
  EXPECT_SAYS(get_error("mode=Octet_Stream"), "WEIR-3010");
}

TEST(TensorDecoder, RefusesAFrameOfTheWrongSize) {
  EXPECT_SAYS(get_error("mode=octet_stream", tensor("uint8", "4"), Bytes(3)), "WEIR-2004");
}

std::string property_file(const std::string& text) {
  return "config-file=" + label_file(text, "weir-tensor-decoder.conf");
}
std::string property(const Harness& h, const char* name) {
  const auto e = Ref<GstElement>::adopt(gst_harness_find_element(h.get(), "tensor_decoder"));
  GValue value = G_VALUE_INIT;
  g_object_get_property(G_OBJECT(e.get()), name, &value);
  const weir::gst::UniqueText text{gst_value_serialize(&value)};
  g_value_unset(&value);
  return text ? text.get() : "NULL";
}

TEST(TensorDecoder, ReadsItsPropertiesFromAFile) {
  auto h = harness(property_file("mode = direct_video\n option1=BGR\nsilent=FALSE\nno-such=1\n"
                                 "sub-plugins=none\nconfig-file=/nowhere\na remark\n"),
                   tensor("uint8", "3:4:2"));
  EXPECT_EQ(decoded(h, frame(Bytes(24, 1))).size(), 24u);
  EXPECT_SAYS(caps_text(h), "format=(string)BGR");
  EXPECT_EQ(property(h, "silent"), "false");
  EXPECT_EQ(property(h, "option2"), "NULL");
}

TEST(TensorDecoder, WarnsOfUnknownPropertiesInAPropertyFile) {
  const auto element = lone_element("tensor_decoder " +
                                    property_file("mode=octet_stream\noptoin1=BGR\nqqqqqqqqqq=1\n"
                                                  "sub-plugins=none\nconfig-file=/nowhere\n"));
  Errors errors(element.get());
  gst_element_set_state(element.get(), GST_STATE_PAUSED);
  gst_element_set_state(element.get(), GST_STATE_NULL);
  std::vector<std::string> warnings;
  for (std::string text; !(text = errors.next_warning()).empty();) warnings.push_back(text);
  ASSERT_EQ(warnings.size(), 3u);
  EXPECT_SAYS(warnings[0], "WEIR-1004: config-file sets an unknown property");
  EXPECT_SAYS(warnings[0], "offered: optoin1");
  EXPECT_SAYS(warnings[0], "did you mean option1?");
  EXPECT_SAYS(warnings[1], "offered: qqqqqqqqqq");
  EXPECT_SAYS(warnings[2], "config-file sets a property that cannot be written; it is ignored");
  EXPECT_SAYS(warnings[2], "offered: sub-plugins");
}

TEST(TensorDecoder, LetsWhatIsSetLaterWin) {
  auto later = harness(property_file("mode=direct_video\noption1=BGR\n") + " option1=RGB",
                       tensor("uint8", "3:4:2"));
  EXPECT_EQ(property(later, "option1"), "RGB");
  auto earlier = harness("option1=RGB " + property_file("mode=direct_video\noption1=BGR\n"),
                         tensor("uint8", "3:4:2"));
  EXPECT_EQ(property(earlier, "option1"), "BGR");
}

TEST(PropertyFile, SetsEachTypeByItsOwnRule) {
  const auto get_value = [](GstElement* element, const char* name) {
    GValue value = G_VALUE_INIT;
    g_object_get_property(G_OBJECT(element), name, &value);
    const weir::gst::UniqueText text{gst_value_serialize(&value)};
    g_value_unset(&value);
    return std::string(text.get());
  };
  const std::string path = label_file(
      "max-size-buffers=7 frames\nmax-size-time=5000000000\nsilent=True\nflush-on-eos=yes\n"
      "leaky=downstream\nerror-after=-1x\ndrop-probability=0.25\n",
      "weir-properties.conf");
  const auto make = [](const char* name) {
    return Ref<GstElement>::adopt(
        GST_ELEMENT(gst_object_ref_sink(gst_element_factory_make(name, nullptr))));
  };
  const auto queue = make("queue"), identity = make("identity");
  ASSERT_TRUE(weir::gst::set_properties_from_file(G_OBJECT(queue.get()), path));
  ASSERT_TRUE(weir::gst::set_properties_from_file(G_OBJECT(identity.get()), path));
  EXPECT_EQ(get_value(queue.get(), "max-size-buffers"), "7");
  EXPECT_EQ(get_value(queue.get(), "max-size-time"), "5000000000");
  EXPECT_EQ(get_value(queue.get(), "silent"), "true");
  EXPECT_EQ(get_value(queue.get(), "flush-on-eos"), "false") << "only true is true";
  EXPECT_EQ(get_value(queue.get(), "leaky"), "downstream");
  EXPECT_EQ(get_value(identity.get(), "error-after"), "-1");
  EXPECT_EQ(get_value(identity.get(), "drop-probability"), "0.25");
}

TEST(TensorDecoder, NamesTheMissingPropertyFile) {
  const std::string message = get_error("mode=octet_stream config-file=/nowhere/weir.conf");
  EXPECT_SAYS(message, "WEIR-4001: the property file cannot be read");
  EXPECT_SAYS(message, "config-file=/nowhere/weir.conf");
  EXPECT_SAYS(message, "lines of property=value");
}

TEST(TensorDecoder, ListsItsDecoders) {
  auto h = harness("mode=octet_stream", tensor("uint8", "4"));
  const auto e = Ref<GstElement>::adopt(gst_harness_find_element(h.get(), "tensor_decoder"));
  gchar* raw = nullptr;
  g_object_get(e.get(), "sub-plugins", &raw, nullptr);
  const weir::gst::UniqueText list{raw};
  // Those of libraries that a build may lack are left out.
  for (const char* name :
       {"bounding_boxes", "direct_video", "erring", "image_labeling", "image_segment",
        "octet_stream", "pose_estimation", "python3", "tensor_region"})
    EXPECT_SAYS("," + std::string(list.get()) + ",", "," + std::string(name) + ",");
}

TEST(TensorDecoder, FollowsNewCaps) {
  auto h = harness("mode=direct_video", tensor("uint8", "3:4:2"));
  EXPECT_EQ(decoded(h, frame(Bytes(24, 1))).size(), 24u);
  gst_harness_set_src_caps_str(h.get(), tensor("uint8", "1:8:2").c_str());
  EXPECT_EQ(decoded(h, frame(Bytes(16, 1))).size(), 16u);
  EXPECT_SAYS(caps_text(h), "GRAY8");
}

TEST(TensorDecoder, GoesOnAfterAFlush) {
  auto h = harness("mode=octet_stream", tensor("uint8", "2"));
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{1, 2})), GST_FLOW_OK);
  gst_harness_push_event(h.get(), gst_event_new_flush_start());
  gst_harness_push_event(h.get(), gst_event_new_flush_stop(TRUE));
  gst_harness_push_event(h.get(), time_segment());
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{3, 4})), GST_FLOW_OK);
  EXPECT_EQ(stat(h, "received"), 2u);
  EXPECT_EQ(stat(h, "pushed"), 2u);
}

}  // namespace tensor_decoder_test
}  // namespace weir::testing_tensor_decoder
