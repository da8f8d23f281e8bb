// Tests of filters in Python: the protocol, and the memory behind their arrays.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <atomic>
#include <thread>

#include "script_filter_test_support.hpp"

namespace weir::python_test {
namespace python3_test {

using Floats = std::vector<float>;
using Bytes = std::vector<uint8_t>;

// A script as a user writes it: dimensions innermost first, arguments in custom=.
const char* const kHalver = R"py(
import numpy as np
from nnstreamer_python import TensorShape

class CustomFilter(object):
    def __init__(self, *args):
        self.width, self.height = [int(a) for a in args]
        self.input_dims = [TensorShape([3, self.width, self.height, 1], np.uint8)]
        self.output_dims = [TensorShape([3, self.width // 2, self.height // 2], np.uint8),
                            TensorShape([1], np.float64)]

    def getInputDim(self):
        return self.input_dims

    def getOutputDim(self):
        return self.output_dims

    def invoke(self, input_array):
        assert len(input_array) == 1 and input_array[0].ndim == 1
        image = input_array[0].reshape(self.height, self.width, 3)
        return [image[::2, ::2].copy(), np.array([image.mean()])]
)py";

TEST_F(Python3, ReportsItsTensorsAndReturnsOthers) {
  auto filter = opened(write("halver", kHalver), "4 2");
  ASSERT_EQ(filter.model().inputs().size(), 1u);
  const auto& in = filter.model().inputs()[0];
  EXPECT_EQ(in.type, static_cast<uint32_t>(WEIR_UINT8));
  EXPECT_EQ(std::vector<int64_t>(in.shape, in.shape + in.rank), (std::vector<int64_t>{1, 2, 4, 3}));
  ASSERT_EQ(filter.model().outputs().size(), 2u);
  const auto& out = filter.model().outputs()[0];
  EXPECT_EQ(std::vector<int64_t>(out.shape, out.shape + out.rank), (std::vector<int64_t>{1, 2, 3}));
  Bytes picture(24);
  for (size_t i = 0; i < picture.size(); ++i) picture[i] = static_cast<uint8_t>(i);
  const auto made = filter.invoke({make_values(WEIR_UINT8, picture, {1, 2, 4, 3})});
  ASSERT_TRUE(made) << made.error().message();
  EXPECT_EQ((*made)[0].as<uint8_t>(), (Bytes{0, 1, 2, 6, 7, 8}));
  EXPECT_EQ((*made)[1].as<double>(), (std::vector<double>{11.5}));
}

TEST_F(Python3, ReceivesItsInputsAndReportsItsOutputs) {
  auto filter = opened(write(
      "sums", kHead +
                  "  def getInputDim(self): raise AssertionError('setInputDim goes first')\n"
                  "  def getOutputDim(self): raise AssertionError('setInputDim goes first')\n"
                  "  def setInputDim(self, input_dims):\n"
                  "    assert len(input_dims) == 2 and len(input_dims[0].dims) == 16\n"
                  "    assert input_dims[0].getDims()[:3] == [3, 2, 0] and input_dims[1].getType() "
                  "== np.int16\n"
                  "    return [TensorShape(input_dims[0].getDims()[:1], input_dims[0].getType())]\n"
                  "  def invoke(self, input_array):\n"
                  "    return [input_array[0].reshape(2, 3).sum(axis=0) + input_array[1][0]]\n"));
  EXPECT_TRUE(filter.model().inputs().empty());
  EXPECT_TRUE(filter.model().outputs().empty());
  const auto made = filter.invoke({make_values<float>(WEIR_FLOAT32, {1, 2, 3, 4, 5, 6}, {2, 3}),
                                   make_values<int16_t>(WEIR_INT16, {10})});
  ASSERT_TRUE(made) << made.error().message();
  ASSERT_EQ(made->size(), 1u);
  EXPECT_EQ((*made)[0].as<float>(), (Floats{15, 17, 19}));
}

TEST_F(Python3, SupportsEveryType) {
  auto filter = opened(write("same", kHead + kSame +
                                         "  def invoke(self, input_array):\n"
                                         "    a = input_array[0]\n"
                                         "    return [np.array([a.itemsize, 7], a.dtype)]\n"));
  constexpr size_t kBytes[WEIR_TYPE_END] = {4, 4, 2, 2, 1, 1, 8, 4, 8, 8, 2};
  for (int type = 0; type < WEIR_TYPE_END; ++type) {
    Values in{make_info(static_cast<weir_type>(type), {2}),
              std::vector<std::byte>(2 * kBytes[type])};
    const auto made = filter.invoke({in});
    ASSERT_TRUE(made) << made.error().message();
    EXPECT_EQ((*made)[0].info.type, static_cast<uint32_t>(type));
    if (type == WEIR_UINT8) {
      EXPECT_EQ((*made)[0].as<uint8_t>(), (Bytes{1, 7}));
    } else if (type == WEIR_INT64) {
      EXPECT_EQ((*made)[0].as<int64_t>(), (std::vector<int64_t>{8, 7}));
    } else if (type == WEIR_FLOAT64) {
      EXPECT_EQ((*made)[0].as<double>(), (std::vector<double>{8, 7}));
    } else if (type == WEIR_FLOAT16) {
      EXPECT_EQ((*made)[0].as<uint16_t>(), (std::vector<uint16_t>{0x4000, 0x4700}));
    }
  }
}

TEST_F(Python3, HasTheShapeClassThatUsersKnow) {
  const auto path = write(
      "shapes", kHead + kFour +
                    "  def invoke(self, input_array):\n"
                    "    shape = TensorShape([4, 2])\n"
                    "    assert shape.getDims() == [4, 2] + [0] * 14\n"
                    "    assert shape.getType() == np.uint8 and shape.type == np.dtype('uint8')\n"
                    "    shape.setDims([1, 2, 3])\n"
                    "    assert shape.getDims() == shape.dims == [1, 2, 3] + [0] * 13\n"
                    "    import nnstreamer_python, weir\n"
                    "    assert weir.TensorShape([1]).dims[0] == 1\n"
                    "    return input_array\n");
  EXPECT_EQ(opened(path).get_error({floats({1, 2, 3, 4})}), "");
}

TEST_F(Python3, ShapesCopyTheirLists) {
  const auto path =
      write("lists", kHead + kFour +
                         "  def invoke(self, input_array):\n"
                         "    dims = [4, 2]\n"
                         "    a, b = TensorShape(dims), TensorShape(dims)\n"
                         "    assert dims == [4, 2], 'the list of the script grew'\n"
                         "    dims[0] = 7\n"
                         "    a.getDims()[1] = 9\n"
                         "    assert a.dims[:3] == [4, 9, 0] and b.dims[:3] == [4, 2, 0]\n"
                         "    a.setDims(b.getDims())\n"
                         "    b.dims[0] = 1\n"
                         "    assert a.dims[:2] == [4, 2] and len(a.dims) == 16\n"
                         "    class Listed(list):\n"
                         "      def __len__(self): return 16\n"
                         "    assert TensorShape(Listed([3])).dims == [3] + [0] * 15\n"
                         "    return input_array\n");
  EXPECT_EQ(opened(path).get_error({floats({1, 2, 3, 4})}), "");
}

TEST_F(Python3, BothArgumentsOfAShapeAreOptional) {
  const auto path = write(
      "defaults", kHead + kFour +
                      "  def invoke(self, input_array):\n"
                      "    assert TensorShape().dims == [0] * 16\n"
                      "    assert TensorShape().getType() == TensorShape([4]).type == np.uint8\n"
                      "    assert TensorShape(type=np.int16).getType() == np.int16\n"
                      "    assert TensorShape([4], type='float64').getType() == np.float64\n"
                      "    assert TensorShape(dims=[4]).dims[0] == 4\n"
                      "    return input_array\n");
  EXPECT_EQ(opened(path).get_error({floats({1, 2, 3, 4})}), "");
}

TEST_F(Python3, ReadsTheFrameWithoutACopy) {
  auto filter = opened(write(
      "where",
      kHead + "  def getInputDim(self): return [TensorShape([4], np.float32)]\n"
              "  def getOutputDim(self): return [TensorShape([1], np.uint64)]\n"
              "  def invoke(self, input_array):\n"
              "    assert not input_array[0].flags.writeable and not input_array[0].flags.owndata\n"
              "    return [np.array([input_array[0].ctypes.data], np.uint64)]\n"));
  const Values in = floats({1, 2, 3, 4});
  const std::vector<Values> frame{in};
  const auto made = filter.invoke(frame);
  ASSERT_TRUE(made) << made.error().message();
  EXPECT_EQ((*made)[0].as<uint64_t>()[0], reinterpret_cast<uint64_t>(frame[0].bytes.data()));
}

TEST_F(Python3, CanReturnItsInputOrPartsOfIt) {
  for (const char* lines :
       {"return input_array", "return [input_array[0]]", "return [input_array[0][:]]",
        "return [input_array[0].reshape(2, 2)]", "return tuple(input_array)"}) {
    for (const bool own : {false, true}) {
      const auto made = opened(invoking(lines)).invoke({floats({1, 2, 3, 4})}, own);
      ASSERT_TRUE(made) << made.error().message();
      EXPECT_EQ((*made)[0].as<float>(), (Floats{1, 2, 3, 4})) << lines;
    }
  }
}

TEST_F(Python3, WritesSeveralOutputsIncludingStridedOnes) {
  auto filter = opened(write(
      "several", kHead +
                     "  def setInputDim(self, dims): return dims * 3\n"
                     "  def invoke(self, input_array):\n"
                     "    a = input_array[0]\n    return [a + np.float32(1), a[::-1], a * 2]\n"));
  for (const bool own : {false, true}) {
    const auto made = filter.invoke({floats({1, 2})}, own);
    ASSERT_TRUE(made) << made.error().message();
    EXPECT_EQ((*made)[0].as<float>(), (Floats{2, 3}));
    EXPECT_EQ((*made)[1].as<float>(), (Floats{2, 1}));
    EXPECT_EQ((*made)[2].as<float>(), (Floats{2, 4}));
  }
}

TEST_F(Python3, AcceptsArraysOfAnyLayoutAndShape) {
  const auto made = [&](const std::string& lines) {
    const auto all = opened(invoking(lines)).invoke({floats({1, 2, 3, 4})});
    return all ? (*all)[0].as<float>() : Floats{};
  };
  EXPECT_EQ(made("return [input_array[0][::-1]]"), (Floats{4, 3, 2, 1}));
  EXPECT_EQ(made("return [input_array[0].reshape(2, 2).T]"), (Floats{1, 3, 2, 4}));
  EXPECT_EQ(made("return [np.asfortranarray(input_array[0].reshape(2, 2))]"), (Floats{1, 2, 3, 4}));
  EXPECT_EQ(made("return [np.ma.masked_array(input_array[0].copy())]"), (Floats{1, 2, 3, 4}));
}

// Tests where output memory comes from: outputs have the values and the script's address.
class Python3Giving : public Python3 {
 protected:
  Filter giving(const std::string& lines) {
    static int number = 0;
    return opened(
        write("giving" + std::to_string(++number),
              kHead +
                  "  def getInputDim(self): return [TensorShape([4], np.float32)]\n"
                  "  def getOutputDim(self):\n"
                  "    return [TensorShape([4], np.float32), TensorShape([1], np.uint64)]\n"
                  "  def __init__(self): self.own = np.zeros(4, np.float32)\n"
                  "  def at(self, a): return np.array([a.ctypes.data], np.uint64)\n"
                  "  def invoke(self, input_array):\n" +
                  lines));
  }
  // Whether outputs are the script's own memory, with the right values in every frame.
  static bool gives_its_memory(Filter filter) {
    bool same = true;
    for (float i = 0; i < 5; ++i) {
      const auto made = filter.invoke({floats({i, 1, 2, 3})}, true);
      if (!made) ADD_FAILURE() << made.error().message();
      if (!made) return false;
      EXPECT_EQ((*made)[0].as<float>(), (Floats{2 * i, 2, 4, 6}));
      same = same && filter.places()[0] == (*made)[1].as<uint64_t>()[0];
    }
    return same;
  }
};

TEST_F(Python3Giving, TransfersArraysWithoutOtherReferences) {
  EXPECT_TRUE(gives_its_memory(giving("    a = input_array[0] * 2\n    return [a, self.at(a)]\n")));
}

TEST_F(Python3Giving, CopiesArraysThatTheScriptCanStillWrite) {
  for (const char* lines :
       {"    np.multiply(input_array[0], 2, out=self.own)\n    return [self.own, "
        "self.at(self.own)]\n",
        "    a = input_array[0] * 2\n    self.kept = a\n    return [a, self.at(a)]\n",
        "    a = input_array[0] * 2\n    self.kept = a[:]\n    return [a, self.at(a)]\n",
        "    a = input_array[0] * 2\n    self.kept = [a, self.at(a)]\n    return self.kept\n",
        "    a = np.zeros(8, np.float32)\n    a[4:] = input_array[0] * 2\n"
        "    return [a[4:], self.at(a[4:])]\n",
        "    a = input_array[0] * 2\n    return (a, self.at(a))\n",
        // A subclass that claims to own the memory of another array.
        "    class Flags:\n      owndata = True\n"
        "    class Array(np.ndarray):\n      base = None\n      flags = Flags()\n"
        "    np.multiply(input_array[0], 2, out=self.own)\n"
        "    return [self.own.view(Array), self.at(self.own)]\n"})
    EXPECT_FALSE(gives_its_memory(giving(lines))) << lines;
}

TEST_F(Python3, SeparatesScriptsOfTheSameNameAndTheirState) {
  std::vector<Filter> both;
  for (const std::string start : {"10", "20"})
    both.push_back(
        opened(write("same",
                     kHead + kFour + "  def __init__(self): self.n = " + start +
                         "\n"
                         "  def invoke(self, input_array):\n"
                         "    self.n += 1\n    return [np.full(4, self.n, np.float32)]\n",
                     "folder" + start)));
  const auto first = [](Filter& filter) {
    return (*filter.invoke({floats({1, 2, 3, 4})}))[0].as<float>()[0];
  };
  EXPECT_EQ(first(both[0]), 11);
  EXPECT_EQ(first(both[1]), 21);
  EXPECT_EQ(first(both[0]), 12);
}

TEST_F(Python3, ImportsModulesBesideTheScript) {
  write("weir_beside_the_script", "FACTOR = 3\n", "beside");
  const auto path =
      write("script",
            "from weir_beside_the_script import FACTOR\n" + kHead + kFour +
                "  def invoke(self, input_array): return [input_array[0] * np.float32(FACTOR)]\n",
            "beside");
  const auto made = opened(path).invoke({floats({1, 2, 3, 4})});
  ASSERT_TRUE(made) << made.error().message();
  EXPECT_EQ((*made)[0].as<float>(), (Floats{3, 6, 9, 12}));
}

// The working directory may hold files of anyone.
TEST_F(Python3, ImportsNoModulesOfTheWorkingDirectory) {
  write("weir_in_the_working_directory", "FACTOR = 3\n", "working");
  const auto path = write("script",
                          "import sys\n"
                          "assert '.' not in sys.path and '' not in sys.path, sys.path\n"
                          "from weir_in_the_working_directory import FACTOR\n" +
                              kHead + kFour,
                          "elsewhere");
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(std::filesystem::path(path).parent_path().parent_path() /
                                "working");
  const auto refused = Filter::open(path);
  std::filesystem::current_path(before);
  ASSERT_FALSE(refused);
  EXPECT_SAYS(refused.error().message(), "No module named 'weir_in_the_working_directory'");
}

TEST_F(Python3, ImportsModulesBesideAScriptWithARelativePath) {
  write("weir_beside_the_relative", "FACTOR = 3\n", "relative");
  const auto path =
      write("script",
            "from weir_beside_the_relative import FACTOR\n" + kHead + kFour +
                "  def invoke(self, input_array): return [input_array[0] * np.float32(FACTOR)]\n",
            "relative");
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(std::filesystem::path(path).parent_path());
  auto filter = Filter::open("script.py");
  std::filesystem::current_path(before);
  ASSERT_TRUE(filter) << filter.error().message();
  const auto made = filter->invoke({floats({1, 2, 3, 4})});
  ASSERT_TRUE(made) << made.error().message();
  EXPECT_EQ((*made)[0].as<float>(), (Floats{3, 6, 9, 12}));
}

TEST_F(Python3, PassesItsArguments) {
  const auto path = write("words",
                          "import numpy as np\nfrom nnstreamer_python import TensorShape\n"
                          "class CustomFilter:\n"
                          "  def __init__(self, *words): self.words = words\n"
                          "  def setInputDim(self, dims):\n"
                          "    raise ValueError('|'.join(self.words))\n"
                          "  def invoke(self, input_array): pass\n");
  const auto error_of_arguments = [&](const std::string& custom) {
    auto filter = opened(path, custom);
    return filter.get_error({floats({1})});
  };
  EXPECT_SAYS(error_of_arguments("one"), "ValueError: one");
  EXPECT_SAYS(error_of_arguments("640 480 x=2.5"), "ValueError: 640|480|x=2.5");
  EXPECT_SAYS(error_of_arguments("a  b"), "ValueError: a||b");
}

TEST_F(Python3, RunsOnManyThreads) {
  const auto path = invoking("return [input_array[0] + np.float32(1)]");
  std::vector<std::thread> threads;
  std::atomic<int> right{0};
  for (float n = 0; n < 4; ++n)
    threads.emplace_back([&, n] {
      auto filter = Filter::open(path);
      for (int i = 0; filter && i < 100; ++i) {
        const auto made = filter->invoke({floats({n, n, n, n})});
        right += made && (*made)[0].as<float>() == Floats(4, n + 1);
      }
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(right, 400);
}

TEST_F(Python3, LetsThreadsOfTheScriptRunBetweenFrames) {
  auto filter = opened(write(
      "threads", "import threading\n" + kHead + kFour +
                     "  def __init__(self):\n"
                     "    self.go, self.done = threading.Event(), threading.Event()\n"
                     "    threading.Thread(target=self.work, daemon=True).start()\n"
                     "  def work(self):\n"
                     "    self.go.wait()\n    self.done.set()\n"
                     "  def invoke(self, input_array):\n"
                     "    if not self.go.is_set():\n      self.go.set()\n      return input_array\n"
                     "    self.done.wait()\n"
                     "    return [input_array[0] + np.float32(1)]\n"));
  EXPECT_EQ(filter.get_error({floats({1, 2, 3, 4})}), "");
  const auto made = filter.invoke({floats({1, 2, 3, 4})});
  ASSERT_TRUE(made);
  EXPECT_EQ((*made)[0].as<float>(), (Floats{2, 3, 4, 5}));
}

// The growth in blocks allocated by Python after `frames` frames, beyond those of a few frames.
double growth(Filter filter, int frames) {
  const auto blocks = [&] { return (*filter.invoke({floats({1})}))[0].as<double>()[0]; };
  double first = 0;
  for (int i = 0; i < 20; ++i) first = blocks();
  for (int i = 0; i < frames; ++i) blocks();
  return blocks() - first;
}
TEST_F(Python3, DoesNotLeakReferences) {
  const auto counting = [&](const std::string& name, const std::string& line) {
    return opened(
        write(name, "import gc, sys\n" + kHead +
                        "  held = []\n"
                        "  def getInputDim(self): return [TensorShape([1], np.float32)]\n"
                        "  def getOutputDim(self): return [TensorShape([1], np.float64)]\n"
                        "  def invoke(self, input_array):\n"
                        "    " +
                        line +
                        "\n    gc.collect()\n"
                        "    return [np.array([sys.getallocatedblocks()], np.float64)]\n"));
  };
  EXPECT_LT(growth(counting("clean", "pass"), 200), 20);
  EXPECT_GT(growth(counting("holding", "self.held.append(input_array[0].copy())"), 200), 190)
      << "a leak would be seen";
}

// A program opens and closes the script of each pipeline that it runs.
TEST_F(Python3, LeavesNoModuleWhenItIsClosed) {
  const auto path =
      write("counting", "import sys\n" + kHead +
                            "  def getInputDim(self): return [TensorShape([1], np.float32)]\n"
                            "  def getOutputDim(self): return [TensorShape([1], np.float64)]\n"
                            "  def invoke(self, input_array):\n"
                            "    return [np.array([sum(n.startswith('weir_script_') for n in "
                            "sys.modules)], float)]\n");
  Filter counting = opened(path);
  const auto modules = [&] { return (*counting.invoke({floats({1})}))[0].as<double>()[0]; };
  const double before = modules();
  {
    const Filter other = opened(path);
    EXPECT_EQ(modules(), before + 1);
  }
  EXPECT_EQ(modules(), before);
}

}  // namespace python3_test
}  // namespace weir::python_test
