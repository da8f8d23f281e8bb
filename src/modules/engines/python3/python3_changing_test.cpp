// Tests of scripts whose objects misreport their contents: subclasses of list and numpy.ndarray
// with their own methods. Such a script gets an error, or its data is copied.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "script_filter_test_support.hpp"

namespace weir::python_test {
namespace python3_changing_test {

class Python3Changing : public Python3 {
 protected:
  inline static const std::string kClasses =
      "class List(list):\n"
      "  def __len__(self): return 1\n"
      "  def __iter__(self): return iter(self.values)\n"
      "def listed(*values):\n"
      "  made = List()\n"
      "  made.values = values\n"
      "  return made\n"
      "class Array(np.ndarray):\n"
      "  base = None\n"
      "  nbytes = 16\n"
      "  dtype = np.dtype(np.float32)\n"
      "class Impostor(bytearray):\n"
      "  __class__ = np.ndarray\n";

  std::string script(const std::string& name, const std::string& methods) const {
    return write(name, "import numpy as np\nfrom nnstreamer_python import TensorShape\n" +
                           kClasses + "class CustomFilter:\n" + methods);
  }
  // A filter of a float32 vector of 4 that returns `value`.
  std::string returning(const std::string& name, const std::string& value) const {
    return script(name, kFour + "  def invoke(self, input_array):\n    " + value + "\n");
  }
};

// What it iterates over counts: none is no result.
TEST_F(Python3Changing, AListThatIteratesOverNoArraysIsNoResult) {
  auto filter = opened(returning("fewer", "return listed()"));
  EXPECT_EQ(filter.get_error({floats({1, 2, 3, 4})}), "");
}

TEST_F(Python3Changing, AListThatIteratesOverMoreArraysThanItHasIsRejected) {
  auto filter = opened(returning("more", "return listed(*input_array, *input_array)"));
  EXPECT_SAYS(filter.get_error({floats({1, 2, 3, 4})}),
              "invoke returned 2 arrays, needed are 1: float32 4");
}

TEST_F(Python3Changing, AnArrayThatReportsAnotherSizeIsRejected) {
  auto filter = opened(returning("size", "return [np.zeros(2, np.float32).view(Array)]"));
  EXPECT_SAYS(filter.get_error({floats({1, 2, 3, 4})}),
              "output 0 has 8 bytes, shape (2,), needed are 16: float32 4");
}

TEST_F(Python3Changing, AnArrayThatReportsAnotherTypeIsRejected) {
  auto filter = opened(returning("type", "return [np.zeros(2, np.float64).view(Array)]"));
  EXPECT_SAYS(filter.get_error({floats({1, 2, 3, 4})}), "output 0 is an array of float64");
}

TEST_F(Python3Changing, AnObjectThatReportsToBeAnArrayIsRejected) {
  auto filter = opened(returning("impostor", "return [Impostor(16)]"));
  EXPECT_SAYS(filter.get_error({floats({1, 2, 3, 4})}),
              "output 0 is not a NumPy array but Impostor, needed is float32 4");
}

TEST_F(Python3Changing, AnObjectThatEmptiesTheListWhileItIsReadIsRejected) {
  auto filter = opened(returning("emptied",
                                 "made = []\n"
                                 "    class Emptying:\n"
                                 "      @property\n"
                                 "      def __class__(self):\n"
                                 "        made.clear()\n"
                                 "        return np.ndarray\n"
                                 "    made.append(Emptying())\n"
                                 "    return made"));
  EXPECT_SAYS(filter.get_error({floats({1, 2, 3, 4})}), "output 0 is not a NumPy array");
}

TEST_F(Python3Changing, AListOfShapesThatIteratesOverTooManyIsRejected) {
  const auto error =
      open_error(script("shapes",
                        "  def invoke(self, input_array): return input_array\n"
                        "  def getInputDim(self): return listed(*[TensorShape([4])] * 300)\n"
                        "  def getOutputDim(self): return [TensorShape([4])]\n"));
  EXPECT_SAYS(error, "getInputDim returned 300 TensorShapes: 1 to 256 can be");
}

TEST_F(Python3Changing, DimensionsThatAreNotIntegersAreRejected) {
  const auto error = open_error(script("fraction",
                                       "  def invoke(self, input_array): return input_array\n"
                                       "  def getInputDim(self): return [TensorShape([4])]\n"
                                       "  def getOutputDim(self):\n"
                                       "    shape = TensorShape([4])\n"
                                       "    shape.getDims = lambda: [1.9999, 4]\n"
                                       "    return [shape]\n"));
  EXPECT_SAYS(error, "a dimension is an integer, not 1.9999");
}

}  // namespace python3_changing_test
}  // namespace weir::python_test
