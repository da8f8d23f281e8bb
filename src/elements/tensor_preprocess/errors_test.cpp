// Errors of tensor_preprocess and their texts; valid and invalid model cards.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdio>
#include <fstream>

#include "elements/tensor_preprocess/preprocess_test_support.hpp"
#include "elements/tests/invalid_video_meta_test_support.hpp"
#include "elements/tests/pipeline_test_support.hpp"

namespace weir::preprocess_test {
namespace tensor_preprocess_errors_test {

TEST(TensorPreprocess, RejectsACropBeyondThePicture) {
  auto h = harness("width=2 height=1", video("GRAY8", 4, 3));
  const auto text = get_error(h, [&] {
    GstBuffer* in = frame(ramp(12));
    crop(in, 3, 0, 2, 1);
    EXPECT_EQ(gst_harness_push(h.get(), in), GST_FLOW_ERROR);
  });
  EXPECT_SAYS(text, "the crop exceeds the picture");
  EXPECT_SAYS(text, "2x1 at 3,0");
  EXPECT_EQ(stat(h, "dropped-error"), 1u);
}

TEST(TensorPreprocess, RejectsAFrameThatIsTooShort) {
  auto h = harness("width=2 height=1", video("RGB", 4, 3));
  const auto text =
      get_error(h, [&] { EXPECT_EQ(gst_harness_push(h.get(), frame(ramp(35))), GST_FLOW_ERROR); });
  EXPECT_SAYS(text, "WEIR-2004");
  EXPECT_SAYS(text, "offered: 35 bytes");
  EXPECT_EQ(stat(h, "received"), 1u);
  EXPECT_EQ(stat(h, "dropped-error"), 1u);
  EXPECT_EQ(stat(h, "held"), 0u);
}

TEST(TensorPreprocess, RejectsInvalidMetadata) {
  for (const auto& meta : invalid_video_metas(4, 3)) {
    auto h = harness("width=2 height=3", video("RGB", 4, 3));
    const auto text = get_error(h, [&] {
      EXPECT_EQ(gst_harness_push(h.get(), with_invalid_meta(frame(ramp(36)), 4, 3, meta)),
                GST_FLOW_ERROR);
    });
    EXPECT_SAYS(text, meta.message);
  }
}

TEST(TensorPreprocess, RejectsVideoThatIsNotAProgressivePicture) {
  const auto error_text = [](const std::string& caps) {
    return error_with_caps("width=4 height=4", "video/x-raw,framerate=10/1," + caps);
  };
  for (const char* size : {"width=0,height=2", "width=2,height=0", "width=65537,height=1",
                           "width=1,height=2147483647", "width=-3,height=2"}) {
    const auto text = error_text(std::string("format=RGB,") + size);
    EXPECT_SAYS(text, "WEIR-2006: a picture is too big or has no pixels");
    EXPECT_SAYS(text, "needed: 1x1 to 65536x65536");
    EXPECT_SAYS(text, "fix: put videoscale or videocrop upstream");
  }
  const auto interlaced = error_text("format=NV12,width=8,height=2,interlace-mode=interleaved");
  EXPECT_SAYS(interlaced, "WEIR-2002: interlaced video is not supported");
  EXPECT_SAYS(interlaced, "offered: interleaved");
  EXPECT_SAYS(interlaced, "fix: deinterlace ! tensor_preprocess");
  for (const char* little : {"width=8,height=2", "format=RGB", "format=RGB,width=8"}) {
    const auto text = error_text(little);
    EXPECT_SAYS(text, "WEIR-2002: the video caps cannot be read");
    EXPECT_SAYS(text, "needed: a format, a width and a height");
  }
  for (const char* caps : {"width=70000,height=2", "width=64,height=48,interlace-mode=interleaved"})
    EXPECT_SAYS(error_of_pipeline(std::string("videotestsrc num-buffers=2 ! video/x-raw,"
                                              "format=NV12,") +
                                  caps + " ! tensor_preprocess width=4 height=4 ! fakesink"),
                "tensor_preprocess");
}

TEST(TensorPreprocess, ReportsAnUnknownSize) {
  const auto text = error_with_caps("width=4", video("RGB", 4, 2));
  EXPECT_SAYS(text, "the size of the tensor is unknown");
  EXPECT_SAYS(text, "fix: tensor_preprocess width=224 height=224");
}

TEST(TensorPreprocess, ReportsTheFirstDifferenceToDownstreamCaps) {
  const char* downstream =
      "other/tensors,format=static,num_tensors=1,dimensions=(string)3:4:3:1,"
      "types=(string)float32,framerate=10/1";
  const auto size = error_with_caps("width=5 height=3", video("RGB", 4, 2), downstream);
  EXPECT_SAYS(size, "WEIR-2001: the element downstream of tensor_preprocess needs another tensor");
  EXPECT_SAYS(size, "3:5:3:1");
  EXPECT_SAYS(size, "3:4:3:1");
  EXPECT_SAYS(error_with_caps("type=uint8", video("RGB", 4, 2), downstream),
              "the element downstream of tensor_preprocess needs another tensor");
}

TEST(TensorPreprocess, ReportsAnUnsupportedFormat) {
  Harness h{gst_harness_new_parse("tensor_preprocess width=4 height=4")};
  const auto text = get_error(h, [&] {
    gst_harness_set_src_caps_str(h.get(), video("Y42B", 4, 4).c_str());
    EXPECT_EQ(gst_harness_push(h.get(), frame(ramp(32))), GST_FLOW_NOT_NEGOTIATED);
  });
  EXPECT_SAYS(text, "WEIR-2002: pictures of this format cannot be preprocessed");
  EXPECT_SAYS(text, "offered: Y42B");
  EXPECT_SAYS(text, "GRAY8, NV12, NV21, I420");
  EXPECT_SAYS(text, "fix: videoconvert ! tensor_preprocess");
  EXPECT_EQ(stat(h, "consumed"), 0u);
}

TEST(TensorPreprocess, RejectsAnUnsupportedFormatMidStream) {
  auto h = harness("width=4 height=4", video("RGB", 4, 4));
  EXPECT_EQ(pushed<uint8_t>(h, frame(ramp(48))), ramp(48));
  const auto text = get_error(h, [&] {
    gst_harness_set_src_caps_str(h.get(), video("v210", 4, 4).c_str());
    EXPECT_EQ(gst_harness_push(h.get(), frame(ramp(512))), GST_FLOW_NOT_NEGOTIATED);
  });
  EXPECT_SAYS(text, "offered: v210");
  EXPECT_EQ(stat(h, "received"), 1u);  // no frame follows rejected caps
  EXPECT_EQ(stat(h, "pushed"), 1u);
}

TEST(TensorPreprocess, ReportsTheFixedFormatOfASource) {
  const std::string source = "videotestsrc num-buffers=2 ! video/x-raw,format=Y42B ! ";
  const std::string downstream = "tensor_preprocess width=4 height=4 ! fakesink";
  EXPECT_SAYS(error_of_pipeline(source + downstream), "fix: videoconvert ! tensor_preprocess");
  EXPECT_EQ(error_of_pipeline(source + "videoconvert ! " + downstream), "");
  // A source with a free choice does not choose rejected caps.
  EXPECT_EQ(error_of_pipeline("videotestsrc num-buffers=2 ! " + downstream), "");
  EXPECT_EQ(error_of_pipeline("videotestsrc num-buffers=2 ! "
                              "video/x-raw,format={Y42B,AYUV,NV12} ! " +
                              downstream),
            "");
}

TEST(TensorPreprocess, LinksToAnIncompatibleSourceToReportTheError) {
  const std::string source = "videotestsrc num-buffers=2 ! video/x-raw,format=Y42B ! ";
  const std::string downstream = "tensor_preprocess width=4 height=4 ! ";
  for (const char* rest : {"queue ! fakesink", "other/tensors,format=static ! fakesink",
                           "tensor_transform mode=typecast option=float32 ! tensor_sink"})
    EXPECT_SAYS(error_of_pipeline(source + downstream + rest),
                "fix: videoconvert ! tensor_preprocess");
  // Output caps that no video can produce still fail to link.
  EXPECT_SAYS(error_of_pipeline(source + downstream +
                                "other/tensors,dimensions=(string)3:5:4:1 ! fakesink"),
              "not linked: ");
}

TEST(TensorPreprocess, RejectsDeviceMemory) {
  const std::pair<const char*, const char*> cases[] = {
      {"memory:GLMemory", "fix: glcolorconvert ! gldownload ! tensor_preprocess"},
      {"memory:DMABuf", "fix: glupload ! glcolorconvert ! gldownload ! tensor_preprocess"},
      {"memory:VAMemory", "fix: vapostproc ! tensor_preprocess"}};
  for (const auto& [memory, fix] : cases) {
    const std::string caps =
        std::string("video/x-raw(") + memory + "),format=NV12,width=8,height=2,framerate=10/1";
    const auto text = error_with_caps("width=4 height=4", caps);
    EXPECT_SAYS(text, "WEIR-2002: the video is in device memory");
    EXPECT_SAYS(text, memory);
    EXPECT_SAYS(text, fix);
    auto h = harness("width=4 height=4", video("RGB", 4, 4));
    EXPECT_EQ(pushed<uint8_t>(h, frame(ramp(48))), ramp(48));
    EXPECT_EQ(get_error(h, [&] { gst_harness_set_src_caps_str(h.get(), caps.c_str()); }), text);
  }
}

TEST(TensorPreprocess, RejectsAnUnknownColourMatrix) {
  const auto text =
      error_with_caps("width=4 height=2", video("NV12", 4, 2, ",colorimetry=smpte240m"));
  EXPECT_SAYS(text, "WEIR-2002: the colour matrix of the video is not known");
}

TEST(TensorPreprocess, ReportsThePositionOfInvalidOptions) {
  EXPECT_SAYS(error_of_start("mean=1,x"), "at character 3:\n    1,x\n      ^");
  EXPECT_SAYS(error_of_start("scale=1..2"), "scale cannot be read");
  EXPECT_SAYS(error_of_start("quantisation=1"), "needed: SCALE:ZERO_POINT");
  EXPECT_SAYS(error_of_start("type=floaty"), "WEIR-1003");
  EXPECT_SAYS(error_with_caps("width=4 height=4 mean=1,2", video("RGB", 4, 4)),
              "mean of 2 numbers");
  EXPECT_SAYS(error_with_caps("width=4 height=4 type=int64", video("RGB", 4, 4)),
              "needed: uint8, int8, float16 or float32");
  EXPECT_SAYS(error_with_caps("width=4 height=4 type=uint8 quantisation=1:256", video("RGB", 4, 4)),
              "0 to 255");
}

class Card : public testing::Test {
 protected:
  Card() {
    path_ = testing::TempDir() + "tensor_preprocess_" +
            testing::UnitTest::GetInstance()->current_test_info()->name() + ".card.json";
  }
  ~Card() override { std::remove(path_.c_str()); }
  void write(const std::string& inputs) {
    std::ofstream(path_) << R"({"name": "a", "model": "a.onnx", "provenance": {}, "sha256": ")"
                         << std::string(64, '0') << R"(", "inputs": [)" << inputs << "]}";
  }
  std::string path_;
  static constexpr const char* kPicture =
      R"({"type": "float32", "shape": [1, 3, 2, 4], "layout": "NCHW", "color": "BGR",
          "mean": [1, 2, 3], "scale": [2], "resize": "crop"})";
};

TEST_F(Card, ProvidesUnsetProperties) {
  write(kPicture);
  auto h = harness("card=" + path_, video("RGB", 4, 2));
  const auto out = pushed<float>(h, frame(ramp(24)));
  EXPECT_SAYS(caps_text(h), "4:2:3:1");
  ASSERT_EQ(out.size(), 24u);
  for (size_t i = 0; i < 24; ++i) {
    const size_t channel = i / 8, pixel = i % 8;
    const auto value = static_cast<float>(3 * pixel + 2 - channel);
    EXPECT_EQ(out[i], (value - static_cast<float>(channel + 1)) * 2);
  }
  auto mine = harness("type=uint8 mean=0 scale=1 layout=NHWC channel-order=RGB card=" + path_,
                      video("RGB", 4, 2));
  EXPECT_EQ(pushed<uint8_t>(mine, frame(ramp(24))), ramp(24));
}

TEST_F(Card, IsReadAgainAtEachStart) {
  const auto element = lone_element("tensor_preprocess card=" + path_);
  EXPECT_EQ(gst_element_set_state(element.get(), GST_STATE_PAUSED), GST_STATE_CHANGE_FAILURE);
  write(kPicture);
  EXPECT_EQ(gst_element_set_state(element.get(), GST_STATE_PAUSED), GST_STATE_CHANGE_SUCCESS);
  gst_element_set_state(element.get(), GST_STATE_NULL);
}

TEST_F(Card, IsMissing) {
  const auto text = error_of_start("card=" + path_);
  EXPECT_SAYS(text, "WEIR-4001: the model card cannot be read");
  EXPECT_SAYS(text, "first difference: it does not exist");
  EXPECT_SAYS(text, "fix: the path of a card; docs/cards.md describes its fields");
  EXPECT_SAYS(text, path_);
}

TEST_F(Card, HasNoPicture) {
  write("");
  EXPECT_SAYS(error_of_start("card=" + path_), "a list of at least one input");
  write(R"({"type": "float32", "shape": [10], "layout": "NHWC", "color": "RGB"})");
  EXPECT_SAYS(error_of_start("card=" + path_), "the extents of one picture");
  write(std::string(kPicture) + "," + kPicture);
  EXPECT_SAYS(error_of_start("card=" + path_), "2 inputs");
  EXPECT_SAYS(error_of_start("card=" + path_ + " card-input=2"),
              "the model card has no such input");
  EXPECT_SAYS(error_of_start("card-input=2"), "card-input without a card has no effect");
}

TEST_F(Card, SelectsOneOfSeveralInputs) {
  std::string other(kPicture);
  other.replace(other.find("2, 4"), 4, "6, 5");
  other.insert(1, R"("name": "small", )");
  write(std::string(kPicture) + "," + other);
  const auto named = harness("card-input=small card=" + path_, video("RGB", 4, 2));
  EXPECT_SAYS(caps_text(named), "5:6:3:1");
  const auto first = harness("card-input=0 card=" + path_, video("RGB", 4, 2));
  EXPECT_SAYS(caps_text(first), "4:2:3:1");
}

}  // namespace tensor_preprocess_errors_test
}  // namespace weir::preprocess_test
