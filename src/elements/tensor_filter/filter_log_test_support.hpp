// The log lines of tensor_filter, for tests of their texts.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>

namespace weir::test {

// Collects the log lines of tensor_filter during its lifetime. Frames run on the calling thread.
class FilterLog {
 public:
  FilterLog() {
    (gst_debug_add_log_function)(take, this, nullptr);
    gst_debug_set_threshold_for_name("tensor_filter", GST_LEVEL_DEBUG);
    gst_debug_set_active(TRUE);
  }
  FilterLog(const FilterLog&) = delete;
  FilterLog& operator=(const FilterLog&) = delete;
  ~FilterLog() {
    gst_debug_unset_threshold_for_name("tensor_filter");
    gst_debug_remove_log_function_by_data(this);
  }
  const std::string& text() const { return text_; }

 private:
  static void take(GstDebugCategory*, GstDebugLevel level, const char*, const char*, gint, GObject*,
                   GstDebugMessage* message, gpointer self) {
    if (level <= GST_LEVEL_DEBUG)
      static_cast<FilterLog*>(self)->text_ += std::string(gst_debug_message_get(message)) + "\n";
  }
  std::string text_;
};

}  // namespace weir::test
