// Tests of the python3 converter: valid scripts and every mistake a script can make. Skipped
// without Python or NumPy.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <thread>

#include "core/infer/module/converter.hpp"
#include "core/infer/module/module_library.hpp"
#include "says.hpp"

namespace weir {
namespace python3_test {

using Bytes = std::vector<uint8_t>;
using Opened = Result<std::unique_ptr<infer::Converter>>;

const char* const kPrelude = "import numpy\nfrom nnstreamer_python import TensorShape\n";

std::string script(const std::string& name, const std::string& text) {
  const std::string path = testing::TempDir() + name + ".py";
  std::ofstream(path) << kPrelude << text;
  return path;
}
// Writes a script whose convert() has these lines.
std::string converting(const std::string& lines) {
  static int number = 0;
  std::string text = "class CustomConverter:\n  def convert(self, input_array):\n";
  for (size_t at = 0; at < lines.size();) {
    const size_t end = std::min(lines.find('\n', at), lines.size());
    text += "    " + lines.substr(at, end - at) + "\n";
    at = end + 1;
  }
  return script("weir_converting_" + std::to_string(++number), text);
}
Opened open_path(const std::string& path) {
  static infer::ModuleLibrary library;
  const auto type = library.converter("python3");
  if (!type) return type.error();
  return infer::Converter::open(**type, {{"script", path}});
}

struct Made {
  std::string error;
  std::vector<std::string> specs;
  std::vector<Bytes> bytes;
  std::string rate;
};

Made convert(infer::Converter& converter, std::vector<Bytes> memories) {
  std::vector<weir_tensor> tensors;
  for (auto& bytes : memories) {
    weir_tensor tensor{};
    tensor.data = bytes.data();
    tensor.bytes = tensor.capacity = bytes.size();
    tensors.push_back(tensor);
  }
  weir_frame frame{};
  frame.struct_size = sizeof frame;
  frame.n_tensors = static_cast<uint32_t>(tensors.size());
  frame.tensors = tensors.data();
  auto made = converter.convert(frame);
  Made out;
  if (!made) {
    out.error = made.error().message();
    return out;
  }
  for (const auto& tensor : made->tensors) {
    out.specs.push_back(tensor.spec().to_string());
    const auto* data = static_cast<const uint8_t*>(tensor.memory().data);
    out.bytes.emplace_back(data, data + tensor.memory().bytes);
  }
  if (made->rate)
    out.rate =
        std::to_string(made->rate->numerator) + "/" + std::to_string(made->rate->denominator);
  return out;
}
Made convert_with(const std::string& lines, std::vector<Bytes> memories) {
  auto opened = open_path(converting(lines));
  if (!opened) return {opened.error().message(), {}, {}, ""};
  return convert(**opened, std::move(memories));
}

class Python3 : public testing::Test {
 protected:
  void SetUp() override {
    const auto opened = open_path(converting("pass"));
    if (!opened && opened.error().code == Code::ENGINE_NOT_INSTALLED)
      GTEST_SKIP() << opened.error().message();
  }
};

TEST_F(Python3, GetsAnArrayOfBytesForEachMemoryAndMakesTensors) {
  const auto made = convert_with(
      "assert all(a.dtype == numpy.uint8 and a.ndim == 1 for a in input_array)\n"
      "both = numpy.concatenate(input_array)\n"
      "floats = numpy.array([len(input_array), 2.5], numpy.float32)\n"
      "return ([TensorShape([3, 2]), TensorShape([2], numpy.float32)],\n"
      "        [both, floats.view(numpy.uint8)], 30, 2)",
      {{1, 2, 3, 4}, {5, 6}});
  EXPECT_EQ(made.error, "");
  ASSERT_EQ(made.specs, (std::vector<std::string>{"uint8 3:2", "float32 2"}));
  EXPECT_EQ(made.bytes[0], (Bytes{1, 2, 3, 4, 5, 6}));
  float floats[2];
  std::memcpy(floats, made.bytes[1].data(), sizeof floats);
  EXPECT_EQ(floats[0], 2.f);
  EXPECT_EQ(floats[1], 2.5f);
  EXPECT_EQ(made.rate, "30/2");
}

TEST_F(Python3, KnowsEveryType) {
  for (const char* type : {"int32", "uint32", "int16", "uint16", "int8", "uint8", "float64",
                           "float32", "int64", "uint64", "float16"}) {
    const auto made = convert_with("a = numpy.array([[1], [2]], numpy." + std::string(type) +
                                       ")\nreturn [TensorShape([1, 2], a.dtype)], [a], 0, 1",
                                   {{0}});
    EXPECT_EQ(made.error, "");
    EXPECT_EQ(made.specs, std::vector<std::string>{std::string(type) + " 1:2"});
  }
}

TEST_F(Python3, TakesEmptyMemoriesAndArraysThatAreNotDense) {
  const auto made = convert_with(
      "return ([TensorShape([2])], [numpy.arange(4, dtype=numpy.uint8)[::2]],\n"
      "        len(input_array[0]), 1)",
      {{}});
  EXPECT_EQ(made.error, "");
  EXPECT_EQ(made.bytes, std::vector<Bytes>({{0, 2}}));
  EXPECT_EQ(made.rate, "0/1");
}

TEST_F(Python3, MayPassItsInputOn) {
  const auto made = convert_with("return [TensorShape([3])], input_array, 1, 1", {{7, 8, 9}});
  EXPECT_EQ(made.error, "");
  EXPECT_EQ(made.bytes, std::vector<Bytes>({{7, 8, 9}}));
}

TEST_F(Python3, KeepsScriptsOfOneNameApartAndTheirState) {
  const char* text =
      "class CustomConverter:\n"
      "  def __init__(self):\n    self.n = %\n"
      "  def convert(self, input_array):\n"
      "    self.n += 1\n"
      "    return [TensorShape([1])], [numpy.array([self.n], numpy.uint8)], 0, 1\n";
  std::vector<std::unique_ptr<infer::Converter>> both;
  for (const char* start : {"10", "20"}) {
    std::string own = text;
    own.replace(own.find('%'), 1, start);
    auto opened = open_path(script("weir_same", own));
    ASSERT_TRUE(opened) << opened.error().message();
    both.push_back(*std::move(opened));
  }
  EXPECT_EQ(convert(*both[0], {{0}}).bytes, std::vector<Bytes>({{11}}));
  EXPECT_EQ(convert(*both[1], {{0}}).bytes, std::vector<Bytes>({{21}}));
  EXPECT_EQ(convert(*both[0], {{0}}).bytes, std::vector<Bytes>({{12}}));
}

TEST_F(Python3, RunsOnManyThreads) {
  const auto path = converting("return [TensorShape([1])], input_array, 0, 1");
  std::vector<std::thread> threads;
  std::atomic<int> right{0};
  for (uint8_t n = 0; n < 4; ++n)
    threads.emplace_back([&, n] {
      auto opened = open_path(path);
      for (int i = 0; opened && i < 100; ++i)
        right += convert(**opened, {{n}}).bytes == std::vector<Bytes>({{n}});
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(right, 400);
}

TEST_F(Python3, ReportsWhereAScriptFails) {
  const auto text = convert_with("x = 1\nreturn x / 0", {{0}}).error;
  EXPECT_SAYS(text, "WEIR-3006: the script failed: ZeroDivisionError: division by zero");
  EXPECT_SAYS(text, ".py:6 in convert: return x / 0");
  const auto left = convert_with("raise SystemExit(3)", {{0}}).error;
  EXPECT_SAYS(left, "the script failed: SystemExit: 3");
}

TEST_F(Python3, GoesOnAfterAFrameThatFailed) {
  auto opened = open_path(
      converting("assert input_array[0][0] < 9\nreturn [TensorShape([1])], input_array, 0, 1"));
  ASSERT_TRUE(opened);
  EXPECT_SAYS(convert(**opened, {{9}}).error, "AssertionError");
  EXPECT_EQ(convert(**opened, {{8}}).bytes, std::vector<Bytes>({{8}}));
}

TEST_F(Python3, MustNotKeepItsInput) {
  auto opened = open_path(
      converting("self.kept = input_array\nreturn [TensorShape([1])], input_array, 0, 1"));
  ASSERT_TRUE(opened);
  for (int i = 0; i < 2; ++i) EXPECT_SAYS(convert(**opened, {{1}}).error, "fix: array.copy()");
  for (const char* kept :
       {"memoryview(input_array[0])", "input_array[0][:]", "memoryview(input_array[0].base)"}) {
    auto view = open_path(converting("self.kept = " + std::string(kept) +
                                     "\nreturn [TensorShape([1])], input_array, 0, 1"));
    ASSERT_TRUE(view);
    EXPECT_NE(convert(**view, {{1}}).error, "") << kept;
  }
  auto cycle =
      open_path(converting("loop = [input_array]\nloop.append(loop)\n"
                           "return [TensorShape([1])], input_array, 0, 1"));
  ASSERT_TRUE(cycle);
  EXPECT_EQ(convert(**cycle, {{5}}).error, "") << "an unreachable object keeps nothing";
}

TEST_F(Python3, MayNotWriteToItsInput) {
  EXPECT_SAYS(convert_with("input_array[0][0] = 1", {{0}}).error, "read-only");
}

struct Fault {
  const char *lines, *words;
};
class Python3Fault : public Python3, public testing::WithParamInterface<Fault> {};
TEST_P(Python3Fault, IsNamed) {
  EXPECT_SAYS(convert_with(GetParam().lines, {{1, 2}}).error, GetParam().words);
}
INSTANTIATE_TEST_SUITE_P(
    Each, Python3Fault,
    testing::Values(
        Fault{"return 1, 2, 3", "not 3 values"},
        Fault{"return [TensorShape([2])], [], 0, 1", "1 TensorShapes for 0 arrays"},
        Fault{"return [TensorShape([2])], [[1, 2]], 0, 1", "array 0 is not a NumPy array but list"},
        Fault{"return [TensorShape([3])], input_array, 0, 1", "array 0 has 2 bytes"},
        Fault{"return [TensorShape([2])], [numpy.zeros(2)], 0, 1", "array 0 is of float64"},
        Fault{"class Array(numpy.ndarray): nbytes = 8\n"
              "return [TensorShape([8])], [numpy.zeros(2, numpy.uint8).view(Array)], 0, 1",
              "array 0 has 2 bytes: its TensorShape [8] of uint8 has 8"},
        Fault{"class List(list):\n"
              "  def __len__(self): return 1\n"
              "return List([TensorShape([2])] * 2), input_array, 0, 1",
              "2 TensorShapes for 1 arrays"},
        Fault{"class Shape(TensorShape):\n"
              "  types = [numpy.uint8, numpy.float64, numpy.float64]\n"
              "  def getType(self): return self.types.pop(0)\n"
              "return [Shape([2])], [numpy.zeros(2)], 0, 1",
              "array 0 is of float64"},
        Fault{"return [TensorShape([1.5])], input_array, 0, 1",
              "a dimension is an integer, not 1.5"},
        Fault{"return [TensorShape([2], numpy.complex64)], input_array, 0, 1",
              "complex64 is not a tensor type"},
        Fault{"return [TensorShape([])], input_array, 0, 1", "1 to 16 dimensions of at least 1"},
        Fault{"return [TensorShape([2, 0, 2])], input_array, 0, 1", "dimensions of at least 1"},
        Fault{"return [TensorShape([1] * 17)], input_array, 0, 1", "at most 16"},
        Fault{"return [TensorShape((2,))], input_array, 0, 1", "are a list, not tuple"},
        Fault{"return [2], input_array, 0, 1", "AttributeError"},
        Fault{"return [TensorShape([2])], input_array, -1, 1", "is not a frame rate"},
        Fault{"return [TensorShape([2])], input_array, 1, 0", "is not a frame rate"},
        Fault{"return [TensorShape([2])], input_array, 1 << 80, 1", "is not a frame rate"},
        Fault{"return [TensorShape([2])], input_array, 'x', 1", "ValueError"},
        Fault{"return [TensorShape([2])] * 257, input_array * 257, 0, 1",
              "a frame has too many tensors"}));

TEST_F(Python3, ReportsWhatIsWrongWithAScript) {
  const auto get_error = [](const std::string& path) {
    const auto opened = open_path(path);
    return opened ? "" : opened.error().message();
  };
  EXPECT_SAYS(get_error("/nonexistent/x.py"), "WEIR-4001: the script does not exist");
  EXPECT_SAYS(get_error(testing::TempDir()), "WEIR-4001: the script does not exist");
  EXPECT_SAYS(get_error(script("weir_empty", "")), "the script has no class CustomConverter");
  EXPECT_SAYS(get_error(script("weir_syntax", "class:\n")), "WEIR-3007: the script failed");
  EXPECT_SAYS(get_error(script("weir_syntax", "class:\n")), "SyntaxError");
  EXPECT_SAYS(get_error(script("weir_import", "import weir_that_is_not_there\n")),
              "No module named 'weir_that_is_not_there'");
  EXPECT_SAYS(get_error(script("weir_init",
                               "class CustomConverter:\n  def __init__(self, x):\n    pass\n")),
              "missing 1 required positional argument");
}

// Runs in a child process because the Python library is loaded once per process.
TEST(Python3Missing, IsNamedWithTheCommandThatBringsIt) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        setenv("WEIR_PYTHON_LIBRARY", "/nonexistent/libpython.so", 1);
        const auto opened = open_path("x.py");
        std::fprintf(stderr, "%s", opened ? "opened" : opened.error().message().c_str());
        std::_Exit(0);
      },
      testing::ExitedWithCode(0),
      "WEIR-3002: Python is not installed as a library(.|\n)*apt-get install libpython3-dev");
}

}  // namespace python3_test
}  // namespace weir
