// What the tensors of a stream were made of.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

namespace weir::gst {

enum class Medium {
  Unknown,  // tensors from the first element on, or results of a network
  Video,
  Other  // audio, text, bytes, ...
};

// The first medium upstream of a sink pad that is no stream of tensors, by the caps of the pads.
// Of an element with several sink pads, the first one counts.
Medium find_upstream_medium(GstPad* sink);

}  // namespace weir::gst
