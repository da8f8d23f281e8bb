// GstMetaQuery: which client of a query server a buffer belongs to
// (docs/compatibility/types-and-caps.md 1.9).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <optional>

namespace weir::gst {

// The API type is "GstMetaQueryAPI" and the implementation "GstMetaQuery" with one gint64: the
// names that existing software uses. If another plug-in of the process registered them first, its
// registration is used. The meta is copied with a buffer's metadata.

// The client's number. Elements that keep frames per client treat buffers without a meta as client
// 0's.
std::optional<gint64> get_client_id(GstBuffer* buffer) noexcept;

// Sets or replaces the client of a writable buffer. False when another plug-in registered the names
// for a different structure.
bool set_client(GstBuffer* buffer, gint64 client) noexcept;

}  // namespace weir::gst
