// The metas of a buffer as bytes, for another process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <cstddef>
#include <span>
#include <vector>

#include "weir/result.hpp"

namespace weir {

// Regions of interest with their parameters, the client of a query (GstMetaQuery), source maps
// (WeirTensorMeta) and GstVideoMeta. Other metas are of the process or of its elements. Empty if
// the buffer has none of these.
std::vector<std::byte> encode_metas(GstBuffer* buffer);

// Adds what encode_metas() wrote to a writable buffer that has its memories. The bytes are not
// trusted. PEER_MESSAGE_INVALID; the buffer may have some of the metas then.
Status decode_metas(std::span<const std::byte> bytes, GstBuffer* buffer);

}  // namespace weir
