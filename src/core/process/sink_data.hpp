// Data of a sink element that one library of Weir sets for another.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

namespace weir::process {

// With any value but null: libweir-pipeline drops a frame that does not match its caps, with a log
// line. Without it, the frame is an error of the stream.
inline constexpr char kDropsUnreadable[] = "weir-drops-unreadable-frames";

}  // namespace weir::process
