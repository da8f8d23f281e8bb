// Checks whether the element that joins a loop with another stream can work with frames that are
// one round old.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <optional>

#include "weir/result.hpp"

namespace weir {

// Walks downstream from `source` to the first element that synchronises several streams. Returns an
// error if it does so by time.
std::optional<Error> unfit_sync_mode(GstPad* source);

}  // namespace weir
