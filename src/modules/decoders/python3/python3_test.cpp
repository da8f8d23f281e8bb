// Tests of the python3 decoder: valid scripts and the mistakes a script can make. Skipped without
// Python or NumPy.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdlib>
#include <fstream>

#include "decoder_test_support.hpp"

namespace weir::testing_decoders {
namespace python3_test {

std::string script(const std::string& text) {
  static int number = 0;
  const std::string path = testing::TempDir() + "weir_decoding_" + std::to_string(++number) + ".py";
  std::ofstream(path) << "import numpy\n" << text;
  return path;
}
// A script whose decode() has these lines.
std::string decoding(const std::string& lines) {
  std::string text =
      "class CustomDecoder:\n  def decode(self, raw_data, in_info, rate_n, rate_d):\n";
  for (size_t at = 0; at < lines.size();) {
    const size_t end = std::min(lines.find('\n', at), lines.size());
    text += "    " + lines.substr(at, end - at) + "\n";
    at = end + 1;
  }
  return script(text);
}

struct Made {
  std::string error, caps;
  Bytes bytes;
};

class Opened {
 public:
  explicit Opened(const std::string& path) {
    static infer::ModuleLibrary library;
    const auto type = library.decoder("python3");
    auto decoder = type ? infer::Decoder::open(**type, {{"option1", path}})
                        : Result<std::unique_ptr<infer::Decoder>>(type.error());
    if (decoder)
      decoder_ = *std::move(decoder);
    else
      error_ = decoder.error();
  }
  const std::optional<Error>& error() const { return error_; }

  template <class... T>
  Made decode(const Fraction& rate, Tensor<T>... tensors) {
    if (error_) return {error_->message(), "", {}};
    MemorySink sink;
    std::vector<weir_tensor_info> infos{tensors.info()...};
    std::vector<weir_tensor> memories{weir_tensor{}, weir_tensor{}};
    memories.resize(sizeof...(tensors));
    size_t i = 0;
    ((memories[i].data = tensors.values.data(),
      memories[i].bytes = tensors.values.size() * sizeof(T), memories[i].info = infos[i], ++i),
     ...);
    decoder_->set_stream(rate, Format::Static);
    if (const auto status = decoder_->configure(infos, &sink); !status)
      return {status.error().message(), "", {}};
    weir_frame frame{};
    frame.struct_size = sizeof frame;
    frame.n_tensors = sizeof...(tensors);
    frame.tensors = memories.data();
    const auto kept = decoder_->decode(frame, &sink);
    if (!kept) return {kept.error().message(), sink.caps, {}};
    return {"", sink.caps, sink.memories.empty() ? Bytes() : sink.memories[0]};
  }

 private:
  std::optional<Error> error_;
  std::unique_ptr<infer::Decoder> decoder_;
};

Made decode_with(const std::string& path) {
  return Opened(path).decode({30, 1}, Tensor<float>{ElementType::Float32, "2:1", {1.5f, -2}},
                             Tensor<uint8_t>{ElementType::UInt8, "3", {7, 8, 9}});
}

class Python3Decoder : public testing::Test {
 protected:
  void SetUp() override {
    const Opened opened(decoding("pass"));
    if (opened.error() && opened.error()->code == Code::ENGINE_NOT_INSTALLED)
      GTEST_SKIP() << opened.error()->message();
  }
};

TEST_F(Python3Decoder, GetsTypedArraysTheirShapesAndTheFrameRate) {
  const auto made = decode_with(decoding(
      "from nnstreamer_python import TensorShape\n"
      "assert [a.dtype for a in raw_data] == [numpy.float32, numpy.uint8]\n"
      "assert all(a.ndim == 1 for a in raw_data)\n"
      "assert raw_data[0].tolist() == [1.5, -2] and raw_data[1].tolist() == [7, 8, 9]\n"
      "assert all(isinstance(i, TensorShape) for i in in_info)\n"
      "assert in_info[0].getDims() == [2, 1] + [0] * 14 and in_info[0].getType() == numpy.float32\n"
      "assert in_info[1].getDims() == [3] + [0] * 15\n"
      "assert (rate_n, rate_d) == (30, 1)\n"
      "return b'seen'"));
  EXPECT_EQ(made.error, "");
  EXPECT_EQ(made.caps, "application/octet-stream") << "without getOutCaps";
  EXPECT_EQ(made.bytes, (Bytes{'s', 'e', 'e', 'n'}));
}

TEST_F(Python3Decoder, ChoosesItsCaps) {
  const std::string decode = "  def decode(self, *a):\n    return b''\n";
  const auto caps = [&](const std::string& returned) {
    return decode_with(script("class CustomDecoder:\n  def getOutCaps(self):\n    return " +
                              returned + "\n" + decode));
  };
  EXPECT_EQ(caps("b'text/x-raw,format=utf8'").caps, "text/x-raw,format=utf8");
  EXPECT_EQ(caps("'video/x-raw'").caps, "video/x-raw");
  EXPECT_SAYS(caps("5").error,
              "WEIR-3006: the script failed: TypeError: getOutCaps returns caps as bytes");
  EXPECT_SAYS(caps("None").error, "not NoneType");
  EXPECT_SAYS(caps("1 / 0").error, "ZeroDivisionError");
}

TEST_F(Python3Decoder, MayReturnWhateverHasBytes) {
  EXPECT_EQ(decode_with(decoding("return bytearray(b'ab')")).bytes, (Bytes{'a', 'b'}));
  EXPECT_EQ(decode_with(decoding("return raw_data[1] + 1")).bytes, (Bytes{8, 9, 10}));
  const auto input = decode_with(decoding("return raw_data[1]"));
  EXPECT_EQ(input.error, "") << "the input itself is no keeping";
  EXPECT_EQ(input.bytes, (Bytes{7, 8, 9}));
  const auto none = decode_with(decoding("return b''"));
  EXPECT_EQ(none.error, "");
  EXPECT_TRUE(none.bytes.empty());
}

TEST_F(Python3Decoder, NamesWhatAScriptReturnsInstead) {
  const std::pair<const char*, const char*> faults[] = {
      {"pass", "TypeError: decode returns bytes, not NoneType"},
      {"return 'text'", "TypeError: decode returns bytes, not str: text.encode()"},
      {"return [1, 2]", "TypeError: decode returns bytes, not list"},
      {"return numpy.zeros(4, numpy.uint8)[::2]", "contiguous"},
      {"return raw_data[0][9]", "IndexError"},
      {"raw_data[0][0] = 1", "read-only"},
      {"raise SystemExit(3)", "the script failed: SystemExit: 3"},
      {"raise BaseException('own')", "BaseException: own"}};
  for (const auto& [lines, words] : faults) EXPECT_SAYS(decode_with(decoding(lines)).error, words);
}

TEST_F(Python3Decoder, ReportsWhereAScriptFails) {
  EXPECT_SAYS(decode_with(decoding("x = 1\nreturn x / 0")).error, ".py:5 in decode: return x / 0");
}

TEST_F(Python3Decoder, GoesOnAfterAFrameThatFailed) {
  Opened opened(decoding("assert raw_data[0][0] < 9\nreturn raw_data[0]"));
  const auto decode = [&](uint8_t value) {
    return opened.decode({0, 1}, Tensor<uint8_t>{ElementType::UInt8, "1", {value}});
  };
  EXPECT_SAYS(decode(9).error, "AssertionError");
  EXPECT_EQ(decode(8).bytes, Bytes{8});
}

TEST_F(Python3Decoder, MustNotKeepItsInput) {
  for (const char* kept : {"raw_data", "raw_data[0][:]", "memoryview(raw_data[0])"}) {
    Opened opened(decoding("self.kept = " + std::string(kept) + "\nreturn b''"));
    for (int i = 0; i < 2; ++i) {
      const auto made = opened.decode({0, 1}, Tensor<uint8_t>{ElementType::UInt8, "1", {1}});
      EXPECT_SAYS(made.error,
                  "the script keeps an array of its input, whose memory is gone after decode");
      EXPECT_SAYS(made.error, "fix: array.copy()");
    }
  }
  EXPECT_EQ(decode_with(decoding("loop = [raw_data]\nloop.append(loop)\nreturn b''")).error, "")
      << "an unreachable object keeps nothing";
}

// A program opens and closes the script of each pipeline that it runs.
TEST_F(Python3Decoder, LeavesNoModuleWhenItIsClosed) {
  const auto path = decoding(
      "import sys\nreturn bytes([sum(n.startswith('weir_script_') for n in sys.modules)])");
  Opened counting(path);
  const auto modules = [&] {
    return counting.decode({0, 1}, Tensor<uint8_t>{ElementType::UInt8, "1", {1}}).bytes;
  };
  EXPECT_EQ(modules(), Bytes{1});
  {
    const Opened other(path);
    EXPECT_EQ(modules(), Bytes{2});
  }
  EXPECT_EQ(modules(), Bytes{1});
}

TEST_F(Python3Decoder, ReportsWhatIsWrongWithAScript) {
  EXPECT_SAYS(decode_with("").error, "WEIR-1004: mode=python3 has no script");
  EXPECT_SAYS(decode_with("").error, "fix: tensor_decoder mode=python3 option1=/path/to/script.py");
  EXPECT_SAYS(decode_with("/nonexistent/x.py").error, "WEIR-4001: the script does not exist");
  EXPECT_SAYS(decode_with(script("")).error, "the script has no class CustomDecoder");
  EXPECT_SAYS(decode_with(script("class:\n")).error, "SyntaxError");
  EXPECT_SAYS(decode_with(script("class CustomDecoder:\n  pass\n")).error, "AttributeError");
}

}  // namespace python3_test
}  // namespace weir::testing_decoders
