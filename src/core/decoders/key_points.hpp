// KeyPoints: the names of a body's key points and the lines between them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "core/draw/skeleton.hpp"

namespace weir::decoders {

struct KeyPoints {
  std::vector<std::string> names;
  std::vector<draw::Bone> bones;  // each connection once, at its key point with the lower index
};

// 14 key points from the top of the head to the left ankle (docs/compatibility/decoder.md 5.4).
const KeyPoints& default_key_points();

// Reads a text file with one line for each key point: its name, at most 15 bytes, then the indices
// of at most 7 key points that it is connected with. `option` is the option's name for errors.
// Throws Failure: FILE_NOT_FOUND, LABELS_INVALID.
KeyPoints read_key_point_file(const std::string& option, const std::string& path);

}  // namespace weir::decoders
