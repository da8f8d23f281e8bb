// GstMetaQuery: which client of a query server a buffer belongs to (specification 1.9).
#pragma once
#include <gst/gst.h>

#include <optional>

namespace weir::gst {

// The API type is "GstMetaQueryAPI", the implementation "GstMetaQuery" with one gint64: the names
// that existing software uses. Where another plug-in of the process registered them first, its own
// are used. The meta goes with every copy of a buffer's metadata.

// The client's number. Elements that keep frames for each client take those without a meta as of
// client 0.
std::optional<gint64> client_of(GstBuffer* buffer) noexcept;

// Says whose the buffer is, in place of what it said before. `buffer` is writable. False when
// another plug-in registered the names for something else.
bool set_client(GstBuffer* buffer, gint64 client) noexcept;

}  // namespace weir::gst
