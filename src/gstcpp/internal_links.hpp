// The links inside an element, and where its threads begin.
#pragma once
#include <gst/gst.h>

#include <vector>

#include "gstcpp/ref.hpp"

namespace weir::gst {

// Pads of the other direction in the element of `pad` that its stream goes to or comes from.
std::vector<Ref<GstPad>> linked_inside(GstPad* pad);
// Whether a thread of its own pushes through the pad.
bool has_task(GstPad* pad);

}  // namespace weir::gst
