// framework=auto: uses and logs the engine of the configuration.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdlib>
#include <fstream>

#include "elements/tensor_filter/adder_test_support.hpp"
#include "elements/tensor_filter/filter_log_test_support.hpp"

namespace automatic_engine_test {

using namespace weir::test;

TEST(TensorFilterAuto, UsesAndLogsTheConfiguredPriority) {
  const AdderFiles files;
  const auto ini = files.write("weir.ini", "[filter]\npriority_add = absent, adder, scaling\n");
  setenv("WEIR_CONFIG", ini.c_str(), 1);
  const FilterLog log;
  auto h = make_harness("tensor_filter model=" + files.model(5), kAdderCaps);
  EXPECT_EQ(pushed_sum(h), 5);
  EXPECT_EQ(text_property(find_element(h, "tensor_filter").get(), "framework"), "adder");
  setenv("WEIR_CONFIG", "", 1);
  EXPECT_SAYS(
      log.text(),
      "framework=auto selected adder: the file has the extension .add; first installed engine of "
      "priority_add (" +
          ini + ":2); other candidates: scaling");
}

TEST(TensorFilterAuto, LogsNoPriorityWithoutIt) {
  const AdderFiles files;
  EXPECT_SAYS(start_error("tensor_filter model=" + files.model(5)),
              "WEIR-3001: no engine can be selected for this model");
}

}  // namespace automatic_engine_test
