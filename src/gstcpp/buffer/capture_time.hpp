// When a frame was captured, in UTC.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <cstdint>

namespace weir::gst {

// Nanoseconds since 1970 UTC, -1 = unknown: by the buffer's GstReferenceTimestampMeta of the caps
// timestamp/x-unix or timestamp/x-ntp; else by the element's clock if that is a system clock of
// type realtime.
int64_t unix_time_of(GstBuffer* buffer, const GstSegment& segment, GstElement* element);

}  // namespace weir::gst
