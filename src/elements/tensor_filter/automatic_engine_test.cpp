// framework=auto: uses and logs the engine of the configuration.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdlib>
#include <fstream>

#include "elements/tensor_filter/adder_test_support.hpp"

namespace {

using namespace weir::test;

// Collects log messages during its lifetime.
class Log {
 public:
  Log() {
    (gst_debug_add_log_function)(take, this, nullptr);
    gst_debug_set_threshold_for_name("tensor_filter", GST_LEVEL_DEBUG);
    gst_debug_set_active(TRUE);
  }
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;
  ~Log() {
    gst_debug_unset_threshold_for_name("tensor_filter");
    gst_debug_remove_log_function_by_data(this);
  }
  const std::string& text() const { return text_; }

 private:
  static void take(GstDebugCategory*, GstDebugLevel level, const char*, const char*, gint, GObject*,
                   GstDebugMessage* message, gpointer self) {
    if (level <= GST_LEVEL_DEBUG)
      static_cast<Log*>(self)->text_ += std::string(gst_debug_message_get(message)) + "\n";
  }
  std::string text_;
};

TEST(TensorFilterAuto, UsesAndLogsTheConfiguredPriority) {
  const AdderFiles files;
  const auto ini = files.write("weir.ini", "[filter]\npriority_add = absent, adder, scaling\n");
  setenv("WEIR_CONFIG", ini.c_str(), 1);
  const Log log;
  auto h = harness_of("tensor_filter model=" + files.model(5), kAdderCaps);
  EXPECT_EQ(pushed_sum(h), 5);
  EXPECT_EQ(text_property(element_of(h, "tensor_filter").get(), "framework"), "adder");
  setenv("WEIR_CONFIG", "", 1);
  EXPECT_SAYS(log.text(),
              "framework=auto is adder: the file has the extension .add; first installed engine of "
              "priority_add (" +
                  ini + ":2); other candidates: scaling");
}

TEST(TensorFilterAuto, LogsNoPriorityWithoutIt) {
  const AdderFiles files;
  EXPECT_SAYS(start_error("tensor_filter model=" + files.model(5)),
              "WEIR-3001: no engine claims this model file by its name");
}

}  // namespace
