// The error of an edgesrc that has no caps for its buffers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "weir/result.hpp"

namespace weir {

// For an edgesink that did not announce its caps. The fix has caps that the peer of `pad` accepts.
Error unknown_caps(GstPad* pad);

}  // namespace weir
