// Pictures of a file as R'G'B', by GStreamer: the control's and the ROS camera's.
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
  double rate = 0;    // of more pictures a second, as many; 0: all
  bool live = false;  // at the rate of the file; of pictures that wait the newest stays
};

// Calls `function` with each picture and its time-stamp (ns) until the end. The picture's memory
// is the decoder's and lasts for the call. False, with a line on stderr, when nothing can be
// decoded.
bool for_each_picture(const Source& source,
                      const std::function<void(const cv::Mat&, int64_t)>& function);

}  // namespace control
