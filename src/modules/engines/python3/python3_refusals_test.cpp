// Tests of the errors for invalid scripts, and of what scripts may not do to frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "script_filter_test_support.hpp"

namespace weir::python_test {
namespace python3_refusals_test {

TEST_F(Python3, ReportsWhereAScriptFails) {
  const auto text = invoke_error("x = 1\nreturn x / 0");
  EXPECT_SAYS(text, "WEIR-3006: the script failed: ZeroDivisionError: division by zero");
  EXPECT_SAYS(text, ".py:10 in invoke: return x / 0");
  const auto deep = invoke_error("def inner():\n  raise KeyError('lost')\nreturn inner()");
  EXPECT_SAYS(deep, "KeyError: 'lost'");
  EXPECT_SAYS(deep, "in invoke: return inner(); ");
  EXPECT_SAYS(deep, "in inner: raise KeyError('lost')");
}

TEST_F(Python3, ContinuesAfterAFailedFrame) {
  auto filter = opened(invoking("assert input_array[0][0] < 9\nreturn input_array"));
  EXPECT_SAYS(filter.get_error({floats({9, 0, 0, 0})}), "AssertionError");
  EXPECT_EQ(filter.get_error({floats({8, 0, 0, 0})}), "");
}

struct Fault {
  const char *lines, *words;
};
std::ostream& operator<<(std::ostream& out, const Fault& fault) {
  return out << fault.lines;
}
class Python3Fault : public Python3, public testing::WithParamInterface<Fault> {};
TEST_P(Python3Fault, IsReported) {
  EXPECT_SAYS(invoke_error(GetParam().lines), GetParam().words);
}
INSTANTIATE_TEST_SUITE_P(
    Each, Python3Fault,
    testing::Values(
        Fault{"return input_array[0]", "a list of NumPy arrays, not ndarray"},
        Fault{"return {'a': 1}", "a list of NumPy arrays, not dict"},
        Fault{"return 'abcd'", "a list of NumPy arrays, not str"},
        Fault{"return input_array * 2", "invoke returned 2 arrays, needed are 1: float32 4"},
        Fault{"return [[1, 2, 3, 4]]",
              "output 0 is not a NumPy array but list, needed is float32 4"},
        Fault{"return [bytes(16)]", "output 0 is not a NumPy array but bytes"},
        Fault{"return [None]", "output 0 is not a NumPy array but NoneType"},
        Fault{"return [np.zeros(4)]",
              "an array of float64, needed is float32 4: array.astype(numpy.float32)"},
        Fault{"return [np.zeros(16, np.uint8)]", "an array of uint8, needed is float32 4"},
        Fault{"return [np.zeros(4, np.int32)]", "an array of int32, needed is float32 4"},
        Fault{"return [np.zeros(4, '>f4')]", "an array of >f4, needed is float32 4"},
        Fault{"return [np.zeros(4, bool)]", "an array of bool, needed is float32 4"},
        Fault{"return [np.zeros(4, object)]", "an array of object, needed is float32 4"},
        Fault{"return [np.zeros(3, np.float32)]",
              "output 0 has 12 bytes, shape (3,), needed are 16: float32 4"},
        Fault{"return [np.zeros((2, 4), np.float32)]",
              "output 0 has 32 bytes, shape (2, 4), needed are 16"},
        Fault{"return [np.float32(1)]", "output 0 is not a NumPy array but float32"},
        Fault{"input_array[0][0] = 1\nreturn input_array", "read-only"},
        Fault{"import sys\nsys.exit(3)", "the script failed: SystemExit: 3"},
        Fault{"exit()", "the script failed"},
        Fault{"raise KeyboardInterrupt", "the script failed: KeyboardInterrupt"},
        Fault{"raise GeneratorExit", "the script failed: GeneratorExit"},
        Fault{"import weir_that_is_not_there", "No module named 'weir_that_is_not_there'"},
        Fault{"def f(): return f()\nreturn f()",
              "RecursionError: maximum recursion depth exceeded"},
        Fault{"yield input_array", "a list of NumPy arrays, not generator"},
        Fault{"raise ValueError('a\\udc80b')", "ValueError: a\\udc80b"}));

TEST_F(Python3, MustNotKeepItsInput) {
  for (const char* lines : {"self.kept = input_array\nreturn input_array",
                            "self.kept = input_array[0]\nreturn input_array",
                            "self.kept = input_array[0][1:]\nreturn input_array",
                            "self.kept = memoryview(input_array[0])\nreturn input_array",
                            "self.kept = input_array[0].reshape(2, 2).T\nreturn input_array",
                            "self.kept = lambda: input_array\nreturn input_array"}) {
    auto filter = opened(invoking(lines));
    for (int i = 0; i < 2; ++i)
      EXPECT_SAYS(filter.get_error({floats({1, 2, 3, 4})}), "fix: array.copy()") << lines;
  }
  EXPECT_EQ(invoke_error("self.kept = input_array[0].copy()\nreturn input_array"), "");
  EXPECT_EQ(invoke_error("loop = [input_array]\nloop.append(loop)\nreturn input_array"), "")
      << "an unreachable object keeps nothing";
}

TEST_F(Python3, CanRaiseAnExceptionThatHoldsTheFrame) {
  auto filter =
      opened(invoking("try:\n  raise ValueError(input_array)\nexcept ValueError as e:\n"
                      "  raise RuntimeError('second') from e"));
  EXPECT_SAYS(filter.get_error({floats({1, 2, 3, 4})}), "RuntimeError: second");
  EXPECT_SAYS(filter.get_error({floats({1, 2, 3, 4})}), "RuntimeError: second")
      << "the exception is gone, and the arrays with it";
}

// Scripts that fail when they are opened.
struct BadScript {
  const char *name, *text, *words;
};
std::ostream& operator<<(std::ostream& out, const BadScript& bad) {
  return out << bad.name;
}
class Python3Script : public Python3, public testing::WithParamInterface<BadScript> {};
TEST_P(Python3Script, IsRejectedWithAMessage) {
  const auto text = open_error(write(GetParam().name, kHead + GetParam().text));
  EXPECT_SAYS(text, GetParam().words);
  EXPECT_SAYS(text, "WEIR-3007");
}
constexpr const char* kInvoke = "  def invoke(self, a): return a\n";
INSTANTIATE_TEST_SUITE_P(
    Each, Python3Script,
    testing::Values(
        BadScript{"syntax", "  class:\n", "SyntaxError"},
        BadScript{"no_method", "  pass\n", "no method invoke(self, input_array)"},
        BadScript{"no_shapes", "  def invoke(self, a): pass\n",
                  "neither setInputDim(self, input_dims) nor both"},
        BadScript{"half", "  def invoke(self, a): pass\n  def getInputDim(self): return []\n",
                  "nor both getInputDim"},
        BadScript{"init", "  def __init__(self, x): pass\n",
                  "missing 1 required positional argument"},
        BadScript{"leaves", "  def __init__(self):\n    import sys\n    sys.exit('now')\n",
                  "SystemExit: now"},
        BadScript{"raises", "  raise OSError('no')\n", "OSError: no"},
        BadScript{"none",
                  "  def invoke(self, a): pass\n  def getInputDim(self): pass\n  def "
                  "getOutputDim(self): pass\n",
                  "getInputDim must return a list of TensorShape, not NoneType"},
        BadScript{"lone",
                  "  def invoke(self, a): pass\n  def getInputDim(self): return TensorShape([1])\n"
                  "  def getOutputDim(self): pass\n",
                  "getInputDim must return a list of TensorShape, not TensorShape"},
        BadScript{
            "empty",
            "  def invoke(self, a): pass\n  def getInputDim(self): return [TensorShape([1])]\n"
            "  def getOutputDim(self): return []\n",
            "getOutputDim returned 0 TensorShapes: 1 to 256 can be"},
        BadScript{"many",
                  "  def invoke(self, a): pass\n  def getInputDim(self): return [TensorShape([1])] "
                  "* 257\n"
                  "  def getOutputDim(self): return []\n",
                  "getInputDim returned 257 TensorShapes"},
        BadScript{"tuples",
                  "  def invoke(self, a): pass\n  def getInputDim(self): return [(3, 4)]\n"
                  "  def getOutputDim(self): return []\n",
                  "entry 0 of its list is not a TensorShape but tuple"},
        BadScript{"nothing",
                  "  def invoke(self, a): pass\n  def getInputDim(self): return [TensorShape([])]\n"
                  "  def getOutputDim(self): return []\n",
                  "1 to 16 dimensions of at least 1"},
        BadScript{"default",
                  "  def invoke(self, a): pass\n  def getInputDim(self): return [TensorShape()]\n"
                  "  def getOutputDim(self): return []\n",
                  "1 to 16 dimensions of at least 1"},
        BadScript{"zero",
                  "  def invoke(self, a): pass\n  def getInputDim(self): return [TensorShape([2, "
                  "0, 2])]\n"
                  "  def getOutputDim(self): return []\n",
                  "dimensions of at least 1"},
        BadScript{
            "rank",
            "  def invoke(self, a): pass\n  def getInputDim(self): return [TensorShape([1] * 17)]\n"
            "  def getOutputDim(self): return []\n",
            "17 dimensions: a tensor has at most 16"},
        BadScript{"type",
                  "  def invoke(self, a): pass\n  def getInputDim(self): return [TensorShape([1], "
                  "np.complex64)]\n"
                  "  def getOutputDim(self): return []\n",
                  "complex64 is not a tensor type"}));

TEST_F(Python3, ReportsWhatIsWrongWithAFile) {
  EXPECT_SAYS(open_error("/nonexistent/x.py"), "WEIR-3003: the model file does not exist");
  const auto nothing = write("weir_nothing", "");
  EXPECT_SAYS(open_error(nothing), "the script has no class CustomFilter\n  offered: " + nothing);
  EXPECT_SAYS(open_error(write("weir_bytes", std::string("\xff\xfe\0\1", 4))), "the script failed");
  EXPECT_SAYS(open_error(write("weir_arguments", kHead + kFour + kInvoke), "1 2"),
              "WEIR-3007: the script failed: TypeError");
}

TEST_F(Python3, ReportsWhatIsWrongWithItsArguments) {
  const auto error = [&](const std::string& lines) {
    static int number = 0;
    auto filter =
        opened(write("told" + std::to_string(++number),
                     kHead + "  def setInputDim(self, dims):\n    " + lines + "\n" + kInvoke));
    return filter.get_error({floats({1, 2})});
  };
  EXPECT_SAYS(error("raise ValueError('too small')"),
              "WEIR-2001: the script failed: ValueError: too small");
  EXPECT_SAYS(error("pass"), "setInputDim must return a list of TensorShape, not NoneType");
  EXPECT_SAYS(error("return []"), "setInputDim returned 0 TensorShapes");
  EXPECT_SAYS(error("return [TensorShape([0])]"), "dimensions of at least 1");
}

// Runs in a child process because the Python library is loaded once per process.
TEST(Python3Missing, IsReportedWithTheCommandThatInstallsIt) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const std::string path = testing::TempDir() + "weir_python_missing.py";
  std::ofstream(path) << "x = 1\n";
  EXPECT_EXIT(
      {
        setenv("WEIR_PYTHON_LIBRARY", "/nonexistent/libpython.so", 1);
        const auto opened = Filter::open(path);
        std::fprintf(stderr, "%s", opened ? "opened" : opened.error().message().c_str());
        std::_Exit(0);
      },
      testing::ExitedWithCode(0),
      "WEIR-3002: Python is not installed as a library(.|\n)*apt-get install libpython3-dev");
}

TEST(Python3WithoutNumpy, IsReportedWithTheCommandThatInstallsIt) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const std::string folder = testing::TempDir() + "weir-no-numpy";
  std::filesystem::create_directories(folder + "/numpy");
  std::ofstream(folder + "/numpy/__init__.py") << "raise ImportError('none here')\n";
  const std::string path = folder + "/filter.py";
  std::ofstream(path) << "x = 1\n";
  EXPECT_EXIT(
      {
        setenv("PYTHONPATH", folder.c_str(), 1);
        const auto opened = Filter::open(path);
        std::fprintf(stderr, "%s", opened ? "opened" : opened.error().message().c_str());
        std::_Exit(0);
      },
      testing::ExitedWithCode(0),
      "(NumPy is not installed for this Python(.|\n)*ImportError: none here(.|\n)*"
      "apt-get install python3-numpy|Python is not "
      "installed)");
}

}  // namespace python3_refusals_test
}  // namespace weir::python_test
