// Switches the active pad of GStreamer's output-selector.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "gstcpp/element/ref.hpp"

namespace weir::gst {

// Makes `pad` the active pad of its output-selector as soon as no buffer is passing through it,
// immediately if none is. If only the property is set (GStreamer 1.22), a buffer in flight reaches
// the new pad before caps and segment, and caps that change before the next buffer arrive before
// stream-start. This function sends stream-start and caps to the pad before the next data, on the
// thread that brings it.
void switch_output(const Ref<GstPad>& pad);

}  // namespace weir::gst
