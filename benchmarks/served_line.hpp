// run_served_line(): a pipeline that serves clients until the end of the standard input, for
// ServerProcess.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <cstdio>
#include <string>

#include "launched.hpp"

namespace weir::bench {

// Prints `port PORT`, of the tensor_query_serversrc named "source". Returns the exit code.
inline int run_served_line(const std::string& line) {
  const auto pipeline = launched(line);
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  if (gst_element_get_state(pipeline.get(), nullptr, nullptr, 10 * GST_SECOND) ==
      GST_STATE_CHANGE_FAILURE)
    return 1;
  const auto source =
      gst::Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline.get()), "source"));
  guint port = 0;
  g_object_get(source.get(), "port", &port, nullptr);
  std::printf("port %u\n", port);
  std::fflush(stdout);
  while (std::getchar() != EOF) {
  }
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  return 0;
}

}  // namespace weir::bench
