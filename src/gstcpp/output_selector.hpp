// Which pad an output-selector of GStreamer's sends to.
#pragma once
#include <gst/gst.h>

#include "gstcpp/ref.hpp"

namespace weir::gst {

// Makes `pad` the active one of its output-selector as soon as no frame is on its way through it,
// at once where none is. By its property alone (GStreamer 1.22) such a frame comes to the new pad
// ahead of caps and segment, and caps that change before the next frame come ahead of stream-start:
// here stream-start and caps go to the pad ahead of what comes next, in the thread that brings it.
void switch_output(const Ref<GstPad>& pad);

}  // namespace weir::gst
