// The lines that tensor_debug logs about a stream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>

namespace weir {

// Bits of the property `metadata`.
enum class DebugMetadata : int { Disabled = 0, Timestamp = 1, QueryServer = 2 };

// "1 tensor: uint8 3:224:224:1 at 30/1", or why there is no such text; with `whole` also the caps.
std::string caps_report(const GstCaps* caps, bool whole);
// "frame 7: 2 memories, 150528 + 4 bytes", and what `metadata` selects.
std::string frame_report(GstBuffer* buffer, uint64_t number, DebugMetadata metadata);

}  // namespace weir
