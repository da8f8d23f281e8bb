// Takes two pads apart while data flow.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <chrono>

namespace weir::soak {

// The most a wait may take before it counts as a deadlock.
constexpr auto kPatience = std::chrono::seconds(30);

// Unlinks when no frame is between the two. False when that does not come, in time.
bool unlink_between_frames(GstPad* source, GstPad* sink);

}  // namespace weir::soak
