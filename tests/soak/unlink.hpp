// Unlinks two pads while data flows.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <chrono>

namespace weir::soak {

// A longer wait counts as a deadlock.
constexpr auto kPatience = std::chrono::seconds(30);

// Unlinks when no frame is between the two pads. False when that does not happen in time.
bool unlink_between_frames(GstPad* source, GstPad* sink);

}  // namespace weir::soak
