// Unsupported formats: the error gives them and the element that converts them, however the
// pipeline requests them; convertible formats never lead to that error.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/converter_test_support.hpp"
#include "elements/tests/pipeline_test_support.hpp"

namespace refused_test {

using namespace weir::testing_tensor_converter;

// The first error of a pipeline; "" if it reaches EOS.
class RefusedVideo : public testing::TestWithParam<const char*> {};

TEST_P(RefusedVideo, NamesTheLineThatConvertsIt) {
  const std::string format = GetParam();
  for (const std::string& text :
       {caps_error("", video(format, 64, 48)),
        error_of_pipeline("videotestsrc num-buffers=2 ! video/x-raw,format=" + format +
                          ",width=64,height=48 ! tensor_converter ! fakesink")}) {
    EXPECT_SAYS(text, "WEIR-2002: this video format cannot be a tensor");
    EXPECT_SAYS(text, "offered: " + format);
    EXPECT_SAYS(text, "fix: videoconvert ! video/x-raw,format=RGB ! tensor_converter");
  }
}
INSTANTIATE_TEST_SUITE_P(All, RefusedVideo,
                         testing::Values("NV12", "I420", "YUY2", "UYVY", "Y42B", "AYUV64", "v308",
                                         "RGB16", "GRAY10_LE32", "NV12_64Z32"));

TEST(ConverterRefuses, NothingThatCanBeConvertedBefore) {
  const std::string source = "videotestsrc num-buffers=2 ! video/x-raw,format=";
  for (const char* format : {"NV12", "I420", "YUY2"}) {
    EXPECT_EQ(error_of_pipeline(source + format + " ! videoconvert ! tensor_converter ! fakesink"),
              "");
    EXPECT_EQ(error_of_pipeline(source + format +
                                " ! videoconvert ! queue ! tensor_converter ! fakesink"),
              "");
  }
  EXPECT_EQ(error_of_pipeline("videotestsrc num-buffers=2 ! tensor_converter ! fakesink"), "");
  EXPECT_EQ(error_of_pipeline("videotestsrc num-buffers=2 ! queue ! tensor_converter ! fakesink"),
            "");
  const auto text = error_of_pipeline(source + "I420 ! queue ! tensor_converter ! fakesink");
  EXPECT_SAYS(text, "fix: videoconvert ! video/x-raw,format=RGB ! tensor_converter");
}

TEST(ConverterRefuses, InterlacedVideoAndCapsThatSayTooLittle) {
  const auto interlaced = caps_error("",
                                     "video/x-raw,format=RGB,width=8,height=2,framerate=10/1,"
                                     "interlace-mode=interleaved");
  EXPECT_SAYS(interlaced, "WEIR-2002: interlaced video is not supported");
  EXPECT_SAYS(interlaced, "fix: deinterlace ! tensor_converter");
  for (const char* caps :
       {"video/x-raw", "video/x-raw,format=RGB", "video/x-raw,format=RGB,width=8",

        "video/x-raw,format=RGB,width=2147483647,height=2147483647",
        "video/x-raw,format=NOTHING,width=8,height=2"}) {
    const auto text = caps_error("", caps);
    EXPECT_SAYS(text, "WEIR-2002: ") << caps;
    EXPECT_SAYS(text, "fix: videoconvert") << caps;
  }
}

TEST(ConverterRefuses, PicturesWithoutPixels) {
  EXPECT_SAYS(caps_error("", "video/x-raw,format=RGB,width=0,height=2"),
              "WEIR-2006: a video frame is too big or empty");
}

TEST(ConverterRefuses, AudioThatIsNotInterleavedOrHasAnotherFormat) {
  const std::string caps = "audio/x-raw,rate=8000,channels=1,";
  const auto format = caps_error("", caps + "format=S24LE,layout=interleaved");
  EXPECT_SAYS(format, "WEIR-2002: this audio format cannot be a tensor");
  EXPECT_SAYS(format, "fix: audioconvert ! audio/x-raw,format=S16LE");
  const auto layout = caps_error("", caps + "format=S16LE,layout=non-interleaved");
  EXPECT_SAYS(layout, "WEIR-2002: the channels of this audio are not interleaved");
  EXPECT_SAYS(layout, "fix: audioconvert ! audio/x-raw,layout=interleaved");
  for (const char* text : {"audio/x-raw", "audio/x-raw,format=S16LE,layout=interleaved",
                           "audio/x-raw,format=S16LE,layout=interleaved,rate=0,channels=1",
                           "audio/x-raw,format=S16LE,layout=interleaved,rate=8000,channels=-1"})
    EXPECT_SAYS(caps_error("", text), "WEIR-2002: the audio caps cannot be read") << text;
}

TEST(ConverterRefuses, TextThatIsNotUtf8) {
  for (const char* caps : {"text/x-raw", "text/x-raw,format=pango-markup"}) {
    const auto text = caps_error("input-dim=8", caps);
    EXPECT_SAYS(text, "WEIR-2002: this text format cannot be a tensor");
    EXPECT_SAYS(text, "fix: text/x-raw,format=utf8 ! tensor_converter");
  }
}

TEST(ConverterRefuses, TensorsThatAreStaticOrSparse) {
  for (const char* caps : {"other/tensors,format=static,num_tensors=1,dimensions=(string)2,"
                           "types=uint8,framerate=1/1",
                           "other/tensors,format=sparse,framerate=1/1", "other/tensors"}) {
    const auto text = caps_error("", caps);
    EXPECT_SAYS(text, "WEIR-2002: these tensors need no tensor_converter") << caps;
    EXPECT_SAYS(text, "fix: remove tensor_converter from the pipeline") << caps;
  }
}

// A capsfilter rejects caps without an error message.
TEST(ConverterRefuses, StaysSilentWhenDownstreamRejects) {
  const std::string source =
      "videotestsrc num-buffers=2 ! video/x-raw,format=RGB,width=8,height=4 ! tensor_converter ! ";
  for (const char* between : {"", "queue ! ", "identity ! "}) {
    const auto text = error_of_pipeline(source + between +
                                        "other/tensors,format=static,num_tensors=1,dimensions="
                                        "(string)3:8:5:1,types=(string)uint8 ! fakesink");
    EXPECT_SAYS(text,
                "WEIR-2001: the element downstream of tensor_converter does not accept its output");
    EXPECT_SAYS(text, "offered: 1 tensor: uint8 3:8:4:1");
    EXPECT_SAYS(text, "dimensions=(string)3:8:5:1");
    EXPECT_SAYS(text, "first difference: tensor 0: dimension is 3:8:4:1, needed is 3:8:5:1");
    EXPECT_SAYS(text, "fix: other/tensors,format=static,dimensions=(string)\"3:8:4:1\"");
  }
  const auto theirs =
      error_of_pipeline(source + "tensor_transform mode=transpose option=9:9 ! fakesink");
  EXPECT_EQ(theirs.find("downstream of tensor_converter"), std::string::npos) << "says it better";
}

TEST(ConverterRefuses, OtherStreamsAsPadsDo) {
  EXPECT_EQ(caps_error("", "image/jpeg"), "");
  const std::string size = ",format=RGBA,width=8,height=2";
  EXPECT_EQ(caps_error("", "video/x-raw(memory:D3D11Memory)" + size), "");
  EXPECT_EQ(caps_error("", "video/x-raw(meta:GstVideoOverlayComposition)" + size), "");
  EXPECT_EQ(caps_error("", "video/x-raw(memory:GLMemory,meta:GstVideoOverlayComposition)" + size),
            "");
}

TEST(ConverterRefuses, PicturesInTheMemoryOfADevice) {
  const std::pair<const char*, const char*> cases[] = {
      {"memory:GLMemory", "fix: glcolorconvert ! gldownload ! tensor_converter"},
      {"memory:DMABuf", "fix: glupload ! glcolorconvert ! gldownload ! tensor_converter"},
      {"memory:VAMemory", "fix: vapostproc ! tensor_converter"},
      {"memory:CUDAMemory", "fix: cudadownload ! tensor_converter"},
      {"memory:NVMM", "fix: nvvideoconvert ! tensor_converter"}};
  for (const auto& [memory, fix] : cases) {
    const std::string caps =
        std::string("video/x-raw(") + memory + "),format=RGBA,width=8,height=2,framerate=10/1";
    const auto text = caps_error("", caps);
    EXPECT_SAYS(text, "WEIR-2002: the video is in device memory");
    EXPECT_SAYS(text, std::string("offered: ") + memory);
    EXPECT_SAYS(text, "needed: memory:SystemMemory");
    EXPECT_SAYS(text, fix);
    const auto h = harness("", video("RGBA", 8, 2));
    EXPECT_EQ(change_caps(h, caps), text);
  }
}

TEST(ConverterRefuses, NoMemoryOfADeviceWhereTheSystemsIsOffered) {
  const auto element = lone_element("tensor_converter");
  const auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "sink"));
  const auto sink_caps = [&](const char* filter) {
    const auto given = Ref<GstCaps>::adopt(gst_caps_from_string(filter));
    const auto caps = Ref<GstCaps>::adopt(gst_pad_query_caps(pad.get(), given.get()));
    return std::string(weir::gst::UniqueText(gst_caps_to_string(caps.get())).get());
  };
  const auto both = sink_caps(
      "video/x-raw(memory:GLMemory),format=RGBA,width=8,height=2;"
      "video/x-raw,format=RGBA,width=8,height=2");
  EXPECT_LACKS(both, "GLMemory");
  EXPECT_SAYS(both, "format=(string)RGBA");
  EXPECT_SAYS(sink_caps("video/x-raw(memory:GLMemory),format=RGBA"), "GLMemory");
}

TEST(ConverterRefuses, NoStreamWhenAModeIsSet) {
  auto h = harness("mode=custom-code:any", "image/jpeg");
  EXPECT_SAYS(caps_text(h), "dimensions=(string)1:1:1:1, types=(string)uint8");
  EXPECT_SAYS(get_error(h, frame({1})), "WEIR-3011: no function is registered");
}

TEST(ConverterRefuses, NoLinkToWhatOneOfSeveralOffersBecomes) {
  const auto pipeline = Ref<GstElement>::adopt(gst_parse_launch(
      "appsrc ! video/x-raw,format=RGB,width=4,height=4,framerate=0/1;"
      "video/x-raw,format=GRAY8,width=(int)[1,8],height=4 ! tensor_converter name=c",
      nullptr));
  ASSERT_TRUE(pipeline);
  gst_element_set_state(pipeline.get(), GST_STATE_PAUSED);
  const auto converter = Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline.get()), "c"));
  const auto source = Ref<GstPad>::adopt(gst_element_get_static_pad(converter.get(), "src"));
  const auto caps = Ref<GstCaps>::adopt(gst_pad_query_caps(source.get(), nullptr));
  const auto gray =
      Ref<GstCaps>::adopt(gst_caps_from_string("other/tensor,dimension=(string)1:4:4:1"));
  EXPECT_TRUE(gst_caps_can_intersect(caps.get(), gray.get()));
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
}

}  // namespace refused_test
