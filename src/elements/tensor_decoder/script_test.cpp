// tensor_decoder mode=python3 in a stream. Skipped without Python or NumPy.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fstream>

#include "core/infer/module/decoder.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/tensor/tensor_header.hpp"
#include "elements/tensor_decoder/decoder_test_support.hpp"

namespace weir::testing_tensor_decoder {
namespace tensor_decoder_script_test {

std::string script(const std::string& text) {
  static int number = 0;
  const std::string path = testing::TempDir() + "weir_decoder_" + std::to_string(++number) + ".py";
  std::ofstream(path) << text;
  return path;
}
std::string python(const std::string& caps, const std::string& decode) {
  return "mode=python3 option1=" +
         script("class CustomDecoder:\n  def getOutCaps(self):\n    return " + caps +
                "\n  def decode(self, raw_data, in_info, rate_n, rate_d):\n    " + decode + "\n");
}

class DecoderScript : public testing::Test {
 protected:
  void SetUp() override {
    static infer::ModuleLibrary library;
    const auto type = library.decoder("python3");
    ASSERT_TRUE(type);
    const std::string path = script("class CustomDecoder:\n  pass\n");
    const auto opened = infer::Decoder::open(**type, {{"option1", path}});
    if (!opened && opened.error().code == Code::ENGINE_NOT_INSTALLED)
      GTEST_SKIP() << opened.error().message();
  }
};

TEST_F(DecoderScript, GetsTheFrameRateAndGivesCapsAndBytes) {
  auto h = harness(
      python("b'text/x-raw, format=utf8'",
             "return f'{raw_data[0].sum()} {in_info[0].getDims()[:3]} {rate_n}/{rate_d}'.encode()"),
      "other/tensor,dimension=(string)3:2,type=(string)int16,framerate=(fraction)15/2");
  GstBuffer* in = test::frame(std::vector<int16_t>{1, 2, 3, 4, 5, -300}, 7, 3);
  const Bytes out = decoded(h, in);
  EXPECT_EQ(std::string(out.begin(), out.end()), "-285 [3, 2, 0] 15/2");
  EXPECT_EQ(caps_text(h), "text/x-raw, format=(string)utf8, framerate=(fraction)15/2");
}

TEST_F(DecoderScript, GetsFlexibleTensorsWithoutTheirHeader) {
  auto h = harness(python("b'text/x-raw, format=utf8'",
                          "return f'{raw_data[0].tolist()} {in_info[0].getDims()[:2]} "
                          "{in_info[0].getType()}'.encode()"),
                   "other/tensors,format=flexible,framerate=0/1");
  Bytes chunk(kTensorHeaderBytes);
  write_tensor_header({{ElementType::UInt16, Shape{2}, ""}, Format::Static, MediaType::Tensor, 0},
                      std::as_writable_bytes(std::span(chunk)).first<kTensorHeaderBytes>());
  for (const uint8_t byte : {1, 0, 2, 1}) chunk.push_back(byte);
  const Bytes out = decoded(h, frame(chunk));
  EXPECT_EQ(std::string(out.begin(), out.end()), "[1, 258] [2, 0] uint16");
}

TEST_F(DecoderScript, ThatFailsIsAnErrorWithItsLineAndTheNextFrameGoesOn) {
  auto h = harness(python("b'text/x-raw'", "return bytes([10 // int(raw_data[0][0])])"),
                   tensor("uint8", "1"));
  {
    Errors errors(h);
    EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{0})), GST_FLOW_ERROR);
    const auto error = errors.next();
    EXPECT_SAYS(error, "WEIR-3006: the script failed: ZeroDivisionError");
    EXPECT_SAYS(error, ".py:5 in decode: return bytes([10 // int(raw_data[0][0])])");
  }
  EXPECT_EQ(decoded(h, frame(Bytes{5})), Bytes{2});
  EXPECT_EQ(stat(h, "dropped-error"), 1u);
}

TEST_F(DecoderScript, WhoseCapsCannotBeReadIsRefused) {
  const auto error =
      get_error(python("b'video/x-raw,width=(int'", "return b''"), tensor("uint8", "1"), Bytes(1));
  EXPECT_SAYS(error, "WEIR-5003: the decoder returned invalid caps");
  EXPECT_SAYS(error, "offered: \"video/x-raw,width=(int\"");
  EXPECT_SAYS(get_error(python("7", "return b''"), tensor("uint8", "1"), Bytes(1)),
              "getOutCaps returns caps as bytes, b'text/x-raw,format=utf8', not int");
}

TEST_F(DecoderScript, ThatIsNotThereIsNamed) {
  EXPECT_SAYS(get_error("mode=python3"), "WEIR-1004: mode=python3 has no script");
  const auto error = get_error("mode=python3 option1=/nonexistent/x.py");
  EXPECT_SAYS(error, "WEIR-4001: the script does not exist");
  EXPECT_SAYS(error, "offered: /nonexistent/x.py");
}

TEST_F(DecoderScript, WhoseBytesAreBeyondTheLimitIsAnError) {
  EXPECT_SAYS(get_error(python("b'text/x-raw'", "return bytes(100)") + " max-buffer-size=64",
                        tensor("uint8", "1"), Bytes(1)),
              "WEIR-2006");
}

}  // namespace tensor_decoder_script_test
}  // namespace weir::testing_tensor_decoder
