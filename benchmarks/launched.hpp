// launched(): a pipeline or an element from its description, for benchmarks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "gstcpp/element/ref.hpp"

namespace weir::bench {

// Ends the program with GStreamer's message, such as no element "x", when the description cannot be
// parsed: without its elements a benchmark would wait for their frames forever.
inline gst::Ref<GstElement> launched(const std::string& description) {
  GError* error = nullptr;
  GstElement* const made =
      gst_parse_launch_full(description.c_str(), nullptr, GST_PARSE_FLAG_FATAL_ERRORS, &error);
  if (!made) {
    std::fprintf(stderr, "%s\n  in: %s\n", error ? error->message : "nothing to launch",
                 description.c_str());
    std::exit(1);
  }
  return gst::Ref<GstElement>::adopt(GST_ELEMENT(gst_object_ref_sink(made)));
}

}  // namespace weir::bench
