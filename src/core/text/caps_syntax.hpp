// Checks the text of caps and structures before GStreamer's parser reads it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

#include "weir/result.hpp"

namespace weir {

// GStreamer's parser recurses without a limit, makes a value of any type that the text names, and
// asserts on ranges that end before they begin. What passes this check is parsed within a bounded
// stack and time, and without an assertion; the parser may still refuse it.
inline constexpr size_t kMaxCapsBytes = size_t{128} << 10;
inline constexpr size_t kMaxCapsStructures = 1024;
inline constexpr size_t kMaxCapsFields = 4096;   // of all structures
inline constexpr size_t kMaxCapsFeatures = 256;  // of all structures
inline constexpr size_t kMaxCapsDepth = 16;      // lists in lists, structures in structures

// Whether the type of this name is an enumeration or a set of flags. All other types must be those
// of numbers, strings, buffers, lists, structures and caps.
using IsPlainType = bool (*)(const std::string& name);

// OPTION_SYNTAX with the position, LIMIT_EXCEEDED beyond the limits above.
Status check_caps_text(std::string_view text, IsPlainType is_plain_type);
Status check_structure_text(std::string_view text, IsPlainType is_plain_type);

}  // namespace weir
