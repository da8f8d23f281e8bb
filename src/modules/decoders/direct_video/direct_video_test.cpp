// Tests of direct_video: format by channel count, row padding to 4 bytes, tensors that are no
// picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "decoder_test_support.hpp"

#include "says.hpp"

namespace weir::testing_decoders {
namespace direct_video_test {

template <class T = uint8_t>
Outcome shown(const std::string& format, const std::string& shape, size_t values,
              ElementType type = ElementType::UInt8) {
  infer::Decoder::Options options;
  if (!format.empty()) options.emplace_back("option1", format);
  std::vector<T> pixels(values);
  for (size_t i = 0; i < values; ++i) pixels[i] = static_cast<T>(i);
  return decode("direct_video", options, Tensor<T>{type, shape, pixels});
}

TEST(DirectVideo, ChoosesTheFormatByTheChannels) {
  EXPECT_EQ(shown("", "1:4:2", 8).sink.caps,
            "video/x-raw,format=(string)GRAY8,width=(int)4,height=(int)2,views=(int)1,"
            "interlace-mode=(string)progressive");
  EXPECT_SAYS(shown("", "3:4:2", 24).sink.caps, "format=(string)RGB,");
  EXPECT_SAYS(shown("", "4:4:2", 32).sink.caps, "format=(string)BGRx,");
  EXPECT_SAYS(shown<uint16_t>("", "1:4:2", 8, ElementType::UInt16).sink.caps, "GRAY16_LE");
}

TEST(DirectVideo, TakesTheFormatOfOption1WhereItFits) {
  for (const char* format : {"RGB", "BGR"})
    EXPECT_SAYS(shown(format, "3:4:2", 24).sink.caps, std::string("(string)") + format + ",");
  for (const char* format : {"RGBx", "BGRx", "xRGB", "xBGR", "RGBA", "BGRA", "ARGB", "ABGR"})
    EXPECT_SAYS(shown(format, "4:4:2", 32).sink.caps, std::string("(string)") + format + ",");
  for (const char* format : {"GRAY16_LE", "GRAY16_BE"})
    EXPECT_SAYS(shown<uint16_t>(format, "1:4:2", 8, ElementType::UInt16).sink.caps, format);
  EXPECT_SAYS(shown("bgr", "3:4:2", 24).sink.caps, "(string)BGR,") << "case does not count";
}

TEST(DirectVideo, SharesRowsThatNeedNoPadding) {
  const auto out = shown("", "3:4:2", 24);
  EXPECT_EQ(out.sink.shared, std::vector<uint32_t>{0});
  EXPECT_TRUE(out.sink.memories.empty());
}

TEST(DirectVideo, PadsRowsToFourBytes) {
  const auto out = shown("", "3:3:2", 18);
  ASSERT_EQ(out.sink.memories.size(), 1u) << out.error;
  EXPECT_EQ(out.sink.memories[0], (Bytes{0, 1,  2,  3,  4,  5,  6,  7,  8,  0, 0, 0,
                                         9, 10, 11, 12, 13, 14, 15, 16, 17, 0, 0, 0}));
}

TEST(DirectVideo, PadsRowsOfSixteenBits) {
  const auto out = shown<uint16_t>("", "1:3:2", 6, ElementType::UInt16);
  ASSERT_EQ(out.sink.memories.size(), 1u) << out.error;
  EXPECT_EQ(out.sink.memories[0], (Bytes{0, 0, 1, 0, 2, 0, 0, 0, 3, 0, 4, 0, 5, 0, 0, 0}));
}

TEST(DirectVideo, RefusesWhatIsNoPicture) {
  for (const char* shape : {"2:4:2", "5:4:2", "3:4:2:2"}) {
    const auto error = shown("", shape, 48).error;
    EXPECT_SAYS(error, "WEIR-2001");
    EXPECT_SAYS(error, std::string("uint8 ") + shape);
  }
  EXPECT_SAYS(shown<float>("", "3:4:2", 24, ElementType::Float32).error, "needs one picture");
  EXPECT_SAYS(shown<float>("", "3:4:2", 24, ElementType::Float32).error,
              "fix: tensor_transform mode=arithmetic option=typecast:float32,mul:255.0 ! "
              "tensor_transform mode=clamp option=0:255 ! "
              "tensor_transform mode=typecast option=uint8 ! tensor_decoder");
  EXPECT_SAYS(shown<float>("", "8:2:3", 48, ElementType::Float32).error,
              "fix: tensor_transform mode=transpose option=2:0:1:3 ! tensor_transform");
  EXPECT_SAYS(shown<uint16_t>("", "3:4:2", 24, ElementType::UInt16).error, "needs one picture");
}

// Captures log messages into `lines` until the end of the scope.
struct LogCapture {
  LogCapture() {
    lines.clear();
    infer::set_log_function([](int level, const char* module, const char* text) {
      lines.push_back(std::to_string(level) + " " + module + ": " + text);
    });
  }
  ~LogCapture() { infer::set_log_function(nullptr); }
  static inline std::vector<std::string> lines;
};

TEST(DirectVideo, ReportsThatAFormatIsNotPossible) {
  const LogCapture log;
  EXPECT_SAYS(shown("YUY2", "3:4:2", 24).sink.caps, "(string)RGB,");
  EXPECT_SAYS(shown("RGBA", "1:4:2", 8).sink.caps, "(string)GRAY8,");
  EXPECT_EQ(shown("RGB", "3:4:2", 24).error, "");
  ASSERT_EQ(log.lines.size(), 2u);
  EXPECT_EQ(
      log.lines[0],
      "1 direct_video: mode=direct_video outputs RGB instead of option1=YUY2: this tensor can "
      "become one of RGB, BGR");
  EXPECT_SAYS(log.lines[1],
              "outputs GRAY8 instead of option1=RGBA: this tensor can become one of GRAY8");
}

TEST(DirectVideo, ReportsItOncePerStream) {
  const LogCapture log;
  infer::ModuleLibrary library;
  const auto type = library.decoder("direct_video");
  ASSERT_TRUE(type);
  const auto decoder = infer::Decoder::open(**type, {{"option1", "YUY2"}});
  ASSERT_TRUE(decoder);
  Bytes pixels(24);
  weir_tensor tensor{};
  tensor.data = pixels.data();
  tensor.bytes = tensor.capacity = pixels.size();
  tensor.info = Tensor<uint8_t>{ElementType::UInt8, "3:4:2", {}}.info();
  weir_frame frame{};
  frame.struct_size = sizeof frame;
  frame.n_tensors = 1;
  frame.tensors = &tensor;
  MemorySink sink;
  ASSERT_TRUE((*decoder)->configure({tensor.info}, &sink));
  EXPECT_TRUE(log.lines.empty()) << "hosts configure decoders to answer questions";
  for (int i = 0; i < 3; ++i) ASSERT_TRUE((*decoder)->decode(frame, &sink));
  EXPECT_EQ(log.lines.size(), 1u);
}

TEST(DirectVideo, RefusesAFrameOfAnotherSize) {
  EXPECT_SAYS(shown("", "3:4:2", 23).error, "WEIR-2004");
  const Tensor<uint8_t> picture{ElementType::UInt8, "3:4:2", {}};
  EXPECT_SAYS(decode_frame("direct_video", {}, picture.info(), {}).error,
              "WEIR-2004: mode=direct_video got a frame without tensors");
}

}  // namespace direct_video_test
}  // namespace weir::testing_decoders
