// The headers of std.hpp and GStreamer's, for the libraries on GStreamer.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "std.hpp"

#include <gst/base/gstbasesink.h>
#include <gst/base/gstbasesrc.h>
#include <gst/base/gstbasetransform.h>
#include <gst/gst.h>
#include <gst/video/video.h>
