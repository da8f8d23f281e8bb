// Tests a script that runs out of memory: it gets errors, and runs again once memory is available.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "out_of_memory_test_support.hpp"
#include "script_filter_test_support.hpp"

namespace weir::python_test {
namespace python3_memory_test {

class Python3Memory : public Python3 {};

// Runs in a child process, so that the module gets the host of the engine tests.
void run_and_exit(const std::string& path) {
  const std::vector<int64_t> shape{1 << 22};
  const weir_engine* engine = engine_test::load_module(WEIR_MODULE_FILE);
  if (!engine) std::_Exit(1);
  const auto folder = std::filesystem::path(path).lexically_normal().parent_path();
  engine_test::run_without_memory_and_exit({*engine, path, shape, folder.string()});
}

TEST_F(Python3Memory, AScriptReportsMissingMemoryAndRecovers) {
  if (!can_limit_address_space()) GTEST_SKIP() << "the address space cannot be limited";
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto path = write("negative", kHead +
                                          "  def getInputDim(self):\n"
                                          "    return [TensorShape([1 << 22], np.float32)]\n"
                                          "  getOutputDim = getInputDim\n"
                                          "  def invoke(self, input_array):\n"
                                          "    return [-input_array[0]]\n");
  EXPECT_EXIT(run_and_exit(path), testing::ExitedWithCode(0), "errors, then successes");
}

}  // namespace python3_memory_test
}  // namespace weir::python_test
