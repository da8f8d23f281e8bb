// A hint on standard error when a model or filter crashes the process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>
#include <vector>

namespace weir::app {

// While it lives, a SIGSEGV, SIGBUS, SIGILL, SIGFPE or SIGABRT prints the hint before the process
// ends as it would have. Does nothing for a pipeline whose tensor_filters all run in processes of
// their own, and for signals that the process already handles. One object at a time.
class CrashHint {
 public:
  // `line` is the pipeline's text, of which the hint shows a copy with isolate=process.
  CrashHint(GstElement* pipeline, const std::string& line);
  ~CrashHint();
  CrashHint(const CrashHint&) = delete;
  CrashHint& operator=(const CrashHint&) = delete;

 private:
  std::vector<int> signals_;  // that are handled
};

}  // namespace weir::app
