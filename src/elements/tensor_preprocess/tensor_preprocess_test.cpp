// tensor_preprocess in a harness: numbers, caps, metadata of buffers, errors.
#include <gst/check/gstharness.h>
#include <gst/video/video.h>
#include <gtest/gtest.h>

#include <fstream>
#include <numeric>
#include <string>
#include <vector>

#include "gstcpp/ref.hpp"

namespace {

using weir::gst::Mapped;
using weir::gst::Ref;
using weir::gst::Unique;
using Harness = Unique<GstHarness, gst_harness_teardown>;
using Bytes = std::vector<uint8_t>;

std::string video(const std::string& format, int width, int height, const char* more = "") {
  return "video/x-raw,format=" + format + ",width=" + std::to_string(width) +
         ",height=" + std::to_string(height) + ",framerate=10/1,interlace-mode=progressive" + more;
}
Harness harness(const std::string& properties, const std::string& caps) {
  Harness h{gst_harness_new_parse(("tensor_preprocess " + properties).c_str())};
  gst_harness_set_src_caps_str(h.get(), caps.c_str());
  return h;
}
Bytes ramp(size_t size) {
  Bytes out(size);
  std::iota(out.begin(), out.end(), uint8_t{0});
  return out;
}
GstBuffer* frame(const Bytes& bytes) {
  GstBuffer* b = gst_buffer_new_allocate(nullptr, bytes.size(), nullptr);
  gst_buffer_fill(b, 0, bytes.data(), bytes.size());
  return b;
}
template <class T>
std::vector<T> pushed(const Harness& h, GstBuffer* in) {
  if (gst_harness_push(h.get(), in) != GST_FLOW_OK) return {};
  const auto out = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
  if (!out) return {};
  const Mapped map(out.get(), GST_MAP_READ);
  const auto span = map.as<const T>();
  return {span.begin(), span.end()};
}
std::string caps_text(const Harness& h) {
  auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(h->sinkpad));
  const weir::gst::UniqueText text{gst_caps_to_string(caps.get())};
  return text.get();
}
Unique<GstStructure, gst_structure_free> stats(const Harness& h) {
  const auto e = Ref<GstElement>::adopt(gst_harness_find_element(h.get(), "tensor_preprocess"));
  GstStructure* raw = nullptr;
  g_object_get(e.get(), "stats", &raw, nullptr);
  return Unique<GstStructure, gst_structure_free>(raw);
}
uint64_t stat(const Harness& h, const char* name) {
  guint64 value = UINT64_MAX;
  gst_structure_get_uint64(stats(h).get(), name, &value);
  return value;
}

// What the element says on its bus while `run` is at work.
template <class F>
std::string error_of(const Harness& h, F&& run) {
  const auto e = Ref<GstElement>::adopt(gst_harness_find_element(h.get(), "tensor_preprocess"));
  const auto bus = Ref<GstBus>::adopt(gst_bus_new());
  gst_element_set_bus(e.get(), bus.get());
  run();
  auto message = Ref<GstMessage>::adopt(gst_bus_pop_filtered(bus.get(), GST_MESSAGE_ERROR));
  gst_element_set_bus(e.get(), nullptr);
  if (!message) return "";
  GError* error = nullptr;
  gst_message_parse_error(message.get(), &error, nullptr);
  std::string text = error->message;
  g_error_free(error);
  return text;
}
std::string error_with_caps(const std::string& properties, const std::string& caps,
                            const char* behind = nullptr) {
  Harness h{gst_harness_new_parse(("tensor_preprocess " + properties).c_str())};
  if (behind) gst_harness_set_sink_caps_str(h.get(), behind);
  return error_of(h, [&] { gst_harness_set_src_caps_str(h.get(), caps.c_str()); });
}
std::string error_of_start(const std::string& properties) {
  auto element = Ref<GstElement>::adopt(GST_ELEMENT(
      gst_object_ref_sink(gst_parse_launch(("tensor_preprocess " + properties).c_str(), nullptr))));
  auto bus = Ref<GstBus>::adopt(gst_bus_new());
  gst_element_set_bus(element.get(), bus.get());
  EXPECT_EQ(gst_element_set_state(element.get(), GST_STATE_PAUSED), GST_STATE_CHANGE_FAILURE);
  auto message = Ref<GstMessage>::adopt(gst_bus_pop_filtered(bus.get(), GST_MESSAGE_ERROR));
  gst_element_set_state(element.get(), GST_STATE_NULL);
  gst_element_set_bus(element.get(), nullptr);
  if (!message) return "";
  GError* error = nullptr;
  gst_message_parse_error(message.get(), &error, nullptr);
  std::string text = error->message;
  g_error_free(error);
  return text;
}
void expect_words(const std::string& text, const char* words) {
  EXPECT_NE(text.find(words), std::string::npos) << text << "\nlacks " << words;
}

TEST(TensorPreprocess, PassesPixelsOfTheSameSize) {
  auto h = harness("width=4 height=2", video("RGB", 4, 2));
  EXPECT_EQ(pushed<uint8_t>(h, frame(ramp(24))), ramp(24));
  expect_words(caps_text(h), "types=(string)uint8");
  expect_words(caps_text(h), "3:4:2:1");
  expect_words(caps_text(h), "framerate=(fraction)10/1");
}

TEST(TensorPreprocess, NormalisesEachChannelAndTransposes) {
  auto h = harness("width=4 height=1 mean=0,1,2 scale=1,2,4 layout=NCHW", video("BGR", 4, 1));
  const auto out = pushed<float>(h, frame(ramp(12)));
  ASSERT_EQ(out.size(), 12u);
  for (size_t x = 0; x < 4; ++x) {
    EXPECT_EQ(out[x], static_cast<float>(3 * x + 2));
    EXPECT_EQ(out[4 + x], (static_cast<float>(3 * x + 1) - 1) * 2);
    EXPECT_EQ(out[8 + x], (static_cast<float>(3 * x) - 2) * 4);
  }
  expect_words(caps_text(h), "float32");
}

TEST(TensorPreprocess, ConvertsLimitedAndFullRange) {
  // Y = 81, Cb = 90, Cr = 240 is red of BT.601 limited: 255 * 65 / 219 + ... computed by hand.
  const Bytes red{81, 81, 0, 0, 81, 81, 0, 0, 90, 240, 0, 0};  // rows are of four bytes
  auto h = harness("width=2 height=2", video("NV12", 2, 2, ",colorimetry=bt601"));
  const auto out = pushed<uint8_t>(h, frame(red));
  ASSERT_EQ(out.size(), 12u);
  EXPECT_EQ(out[0], 254);  // 75.68 + 1.402 * 127.5 = 254.4
  EXPECT_EQ(out[1], 0);    // 75.68 + 0.344 * 43.26 - 0.714 * 127.5 = -0.5
  EXPECT_EQ(out[2], 0);    // 75.68 - 1.772 * 43.26 = -1.0
  // Full range and BT.709: 81 + 1.5748 * 112 = 257.4; 81 + 0.1873 * 38 - 0.4681 * 112 = 35.7;
  // 81 - 1.8556 * 38 = 10.5 (10.487).
  auto full = harness("width=2 height=2", video("NV12", 2, 2, ",colorimetry=1:3:5:1"));
  const auto other = pushed<uint8_t>(full, frame(red));
  ASSERT_EQ(other.size(), 12u);
  EXPECT_EQ(other[0], 255);
  EXPECT_EQ(other[1], 36);
  EXPECT_EQ(other[2], 10);
}

TEST(TensorPreprocess, TakesSizeTypeAndLayoutFromBehind) {
  Harness h{gst_harness_new("tensor_preprocess")};
  gst_harness_set_sink_caps_str(h.get(),
                                "other/tensors,format=static,num_tensors=1,"
                                "dimensions=(string)4:3:3:1,types=(string)float16,framerate=10/1");
  gst_harness_set_src_caps_str(h.get(), video("I420", 20, 10).c_str());
  GstVideoInfo info;
  gst_video_info_set_format(&info, GST_VIDEO_FORMAT_I420, 20, 10);
  EXPECT_EQ(pushed<uint16_t>(h, frame(Bytes(info.size, 128))).size(), 36u);
}

TEST(TensorPreprocess, FitsTheOldSpellingOfOneTensor) {
  Harness h{gst_harness_new_parse("tensor_preprocess width=4 height=3")};
  gst_harness_set_sink_caps_str(h.get(),
                                "other/tensor,framerate=10/1,type=(string)uint8,"
                                "dimension=(string)3:4:3:1");
  gst_harness_set_src_caps_str(h.get(), video("RGB", 4, 3).c_str());
  EXPECT_EQ(pushed<uint8_t>(h, frame(ramp(36))), ramp(36));
}

TEST(TensorPreprocess, LetterboxesWithThePaddingValue) {
  auto h = harness("width=4 height=4 fit=letterbox padding-value=114", video("RGB", 4, 2));
  const auto out = pushed<uint8_t>(h, frame(ramp(24)));
  ASSERT_EQ(out.size(), 48u);
  for (size_t i = 0; i < 48; ++i) EXPECT_EQ(out[i], i < 12 || i >= 36 ? 114 : i - 12);
  double offset = 0;
  EXPECT_TRUE(gst_structure_get_double(stats(h).get(), "source-offset-y", &offset));
  EXPECT_EQ(offset, -1);
}

TEST(TensorPreprocess, FollowsNewCapsAndKeepsTime) {
  auto h = harness("width=2 height=1", "video/x-raw,format=RGB,width=2,height=1,framerate=10/1");
  EXPECT_EQ(pushed<uint8_t>(h, frame(ramp(8))), ramp(6));  // rows are of eight bytes
  gst_harness_set_src_caps_str(h.get(), video("BGRx", 2, 1).c_str());
  GstBuffer* in = frame(ramp(8));
  GST_BUFFER_PTS(in) = 7 * GST_SECOND;
  GST_BUFFER_DURATION(in) = GST_SECOND;
  ASSERT_EQ(gst_harness_push(h.get(), in), GST_FLOW_OK);
  const auto out = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
  ASSERT_TRUE(out);
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 7 * GST_SECOND);
  EXPECT_EQ(GST_BUFFER_DURATION(out.get()), GST_SECOND);
  EXPECT_FALSE(gst_buffer_get_video_meta(out.get()));
  const Mapped map(out.get(), GST_MAP_READ);
  EXPECT_EQ(Bytes(map.as<const uint8_t>().begin(), map.as<const uint8_t>().end()),
            (Bytes{2, 1, 0, 6, 5, 4}));
  EXPECT_EQ(stat(h, "received"), 2u);
  EXPECT_EQ(stat(h, "consumed"), 2u);
  EXPECT_EQ(stat(h, "pushed"), 2u);
}

TEST(TensorPreprocess, HonoursStridesAndOffsets) {
  auto h = harness("width=3 height=2 channel-order=GRAY", video("GRAY8", 3, 2));
  GstBuffer* in = frame({9, 9, 1, 2, 3, 9, 4, 5, 6});
  gsize offsets[GST_VIDEO_MAX_PLANES] = {2, 0, 0, 0};
  gint strides[GST_VIDEO_MAX_PLANES] = {4, 0, 0, 0};
  gst_buffer_add_video_meta_full(in, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_GRAY8, 3, 2, 1,
                                 offsets, strides);
  EXPECT_EQ(pushed<uint8_t>(h, in), (Bytes{1, 2, 3, 4, 5, 6}));
}

TEST(TensorPreprocess, ReadsPlanesInMemoriesOfTheirOwn) {
  auto h =
      harness("width=2 height=2 channel-order=GRAY", video("NV12", 2, 2, ",colorimetry=1:4:5:1"));
  GstBuffer* in = frame({10, 20, 30, 40});
  gst_buffer_append(in, frame({128, 128}));
  gsize offsets[GST_VIDEO_MAX_PLANES] = {0, 4, 0, 0};
  gint strides[GST_VIDEO_MAX_PLANES] = {2, 2, 0, 0};
  gst_buffer_add_video_meta_full(in, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_NV12, 2, 2, 2,
                                 offsets, strides);
  EXPECT_EQ(pushed<uint8_t>(h, in), (Bytes{10, 20, 30, 40}));
}

GstVideoCropMeta* crop(GstBuffer* in, guint x, guint y, guint width, guint height) {
  GstVideoCropMeta* meta = gst_buffer_add_video_crop_meta(in);
  meta->x = x;
  meta->y = y;
  meta->width = width;
  meta->height = height;
  return meta;
}

TEST(TensorPreprocess, HonoursTheCropOfEachBuffer) {
  auto h = harness("width=2 height=1 channel-order=GRAY", video("GRAY8", 4, 3));
  GstBuffer* in = frame(ramp(12));
  crop(in, 1, 2, 2, 1);
  EXPECT_EQ(pushed<uint8_t>(h, in), (Bytes{9, 10}));
  in = frame(ramp(12));
  crop(in, 0, 0, 2, 1);
  EXPECT_EQ(pushed<uint8_t>(h, in), (Bytes{0, 1}));
  EXPECT_EQ(pushed<uint8_t>(h, frame(ramp(12))).size(), 2u);
}

TEST(TensorPreprocess, RefusesACropBeyondThePicture) {
  auto h = harness("width=2 height=1", video("GRAY8", 4, 3));
  const auto text = error_of(h, [&] {
    GstBuffer* in = frame(ramp(12));
    crop(in, 3, 0, 2, 1);
    EXPECT_EQ(gst_harness_push(h.get(), in), GST_FLOW_ERROR);
  });
  expect_words(text, "the crop is not within the picture");
  expect_words(text, "2x1 at 3,0");
  EXPECT_EQ(stat(h, "dropped-error"), 1u);
}

TEST(TensorPreprocess, RefusesAFrameThatIsTooShort) {
  auto h = harness("width=2 height=1", video("RGB", 4, 3));
  const auto text =
      error_of(h, [&] { EXPECT_EQ(gst_harness_push(h.get(), frame(ramp(35))), GST_FLOW_ERROR); });
  expect_words(text, "WEIR-2004");
  expect_words(text, "offered: 35 bytes");
  EXPECT_EQ(stat(h, "received"), 1u);
  EXPECT_EQ(stat(h, "dropped-error"), 1u);
  EXPECT_EQ(stat(h, "held"), 0u);
}

TEST(TensorPreprocess, RefusesMetadataThatLie) {
  gsize offsets[GST_VIDEO_MAX_PLANES] = {0, 0, 0, 0};
  const struct {
    GstVideoFormat format;
    guint width, height;
    gsize offset;
    gint stride;
    const char* words;
  } cases[] = {{GST_VIDEO_FORMAT_BGR, 4, 3, 0, 12, "metadata of a video buffer are of another"},
               {GST_VIDEO_FORMAT_RGB, 3, 3, 0, 12, "offered: RGB 3x3"},
               {GST_VIDEO_FORMAT_RGB, 4, 3, 36, 12, "plane 0 at byte 36"},
               {GST_VIDEO_FORMAT_RGB, 4, 3, 1, 12, "a picture is shorter than its size says"},
               {GST_VIDEO_FORMAT_RGB, 4, 3, 0, 13, "a picture is shorter than its size says"},
               {GST_VIDEO_FORMAT_RGB, 4, 3, 0, -12, "a picture is shorter than its size says"}};
  for (const auto& c : cases) {
    auto h = harness("width=2 height=3", video("RGB", 4, 3));
    const auto text = error_of(h, [&] {
      GstBuffer* in = frame(ramp(36));
      gint strides[GST_VIDEO_MAX_PLANES] = {12, 0, 0, 0};
      GstVideoMeta* meta = gst_buffer_add_video_meta_full(
          in, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_RGB, 4, 3, 1, offsets, strides);
      meta->format = c.format;
      meta->width = c.width;
      meta->height = c.height;
      meta->offset[0] = c.offset;
      meta->stride[0] = c.stride;
      EXPECT_EQ(gst_harness_push(h.get(), in), GST_FLOW_ERROR);
    });
    expect_words(text, c.words);
  }
}

TEST(TensorPreprocess, SaysThatTheSizeIsNotKnown) {
  const auto text = error_with_caps("width=4", video("RGB", 4, 2));
  expect_words(text, "the size of the tensor is not known");
  expect_words(text, "fix: tensor_preprocess width=224 height=224");
}

TEST(TensorPreprocess, NamesTheFirstDifferenceToWhatIsWantedBehind) {
  const char* behind =
      "other/tensors,format=static,num_tensors=1,dimensions=(string)3:4:3:1,"
      "types=(string)float32,framerate=10/1";
  const auto size = error_with_caps("width=5 height=3", video("RGB", 4, 2), behind);
  expect_words(size, "WEIR-2001: the element behind tensor_preprocess needs another tensor");
  expect_words(size, "3:5:3:1");
  expect_words(size, "3:4:3:1");
  expect_words(error_with_caps("type=uint8", video("RGB", 4, 2), behind),
               "the element behind tensor_preprocess needs another tensor");
}

TEST(TensorPreprocess, RefusesAColourMatrixItDoesNotKnow) {
  const auto text =
      error_with_caps("width=4 height=2", video("NV12", 4, 2, ",colorimetry=smpte240m"));
  expect_words(text, "WEIR-2002: the colour matrix of the video is not known");
}

TEST(TensorPreprocess, ShowsThePlaceOfOddOptions) {
  expect_words(error_of_start("mean=1,x"), "at character 3:\n1,x\n  ^");
  expect_words(error_of_start("scale=1..2"), "scale cannot be read");
  expect_words(error_of_start("quantisation=1"), "needed: SCALE:ZERO_POINT");
  expect_words(error_of_start("type=floaty"), "WEIR-1003");
  expect_words(error_with_caps("width=4 height=4 mean=1,2", video("RGB", 4, 4)),
               "mean of 2 numbers");
  expect_words(error_with_caps("width=4 height=4 type=int64", video("RGB", 4, 4)),
               "needed: uint8, int8, float16 or float32");
  expect_words(
      error_with_caps("width=4 height=4 type=uint8 quantisation=1:256", video("RGB", 4, 4)),
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

TEST_F(Card, SaysEverythingThatIsNotSet) {
  write(kPicture);
  auto h = harness("card=" + path_, video("RGB", 4, 2));
  const auto out = pushed<float>(h, frame(ramp(24)));
  expect_words(caps_text(h), "4:2:3:1");
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
  const auto element = Ref<GstElement>::adopt(GST_ELEMENT(
      gst_object_ref_sink(gst_parse_launch(("tensor_preprocess card=" + path_).c_str(), nullptr))));
  EXPECT_EQ(gst_element_set_state(element.get(), GST_STATE_PAUSED), GST_STATE_CHANGE_FAILURE);
  write(kPicture);
  EXPECT_EQ(gst_element_set_state(element.get(), GST_STATE_PAUSED), GST_STATE_CHANGE_SUCCESS);
  gst_element_set_state(element.get(), GST_STATE_NULL);
}

TEST_F(Card, IsMissing) {
  const auto text = error_of_start("card=" + path_);
  expect_words(text, "WEIR-4001: the model card cannot be read");
  expect_words(text, path_.c_str());
}

TEST_F(Card, HasNoPicture) {
  write("");
  expect_words(error_of_start("card=" + path_), "a list of at least one input");
  write(R"({"type": "float32", "shape": [10], "layout": "NHWC", "color": "RGB"})");
  expect_words(error_of_start("card=" + path_), "the extents of one picture");
  write(std::string(kPicture) + "," + kPicture);
  expect_words(error_of_start("card=" + path_), "2 inputs");
}

}  // namespace
