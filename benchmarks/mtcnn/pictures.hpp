// Reads the pictures of a file as R'G'B' with GStreamer, for the control and the ROS camera.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/app/gstappsink.h>
#include <gst/gst.h>

#include <functional>
#include <opencv2/core.hpp>
#include <string>

namespace control {

struct Source {
  std::string file;
  double rate = 0;    // limit in pictures per second; 0: all
  bool live = false;  // at the file's rate; only the newest waiting picture is kept
};

// Calls `function` with each picture and its timestamp (ns) until EOS. The decoder owns the
// picture's memory, valid during the call. False, with a line on stderr, when decoding fails.
bool for_each_picture(const Source& source,
                      const std::function<void(const cv::Mat&, int64_t)>& function);

}  // namespace control
