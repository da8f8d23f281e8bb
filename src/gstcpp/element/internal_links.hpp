// The internal links of an element, and which of its pads run a streaming thread.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <vector>

#include "gstcpp/element/ref.hpp"

namespace weir::gst {

// The internally linked pads of `pad`.
std::vector<Ref<GstPad>> linked_inside(GstPad* pad);
// Whether the pad has a task that pushes through it.
bool has_task(GstPad* pad);

}  // namespace weir::gst
