// Whether the element where a loop meets another stream can work with frames that are one round
// old.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <optional>

#include "weir/result.hpp"

namespace weir {

// Follows the line behind `source` to the first element that synchronises several streams. An error
// when it does so by time.
std::optional<Error> unfit_sync_mode(GstPad* source);

}  // namespace weir
