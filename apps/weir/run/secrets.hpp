// Hides passwords and tokens in text that goes into a report, which people pass on.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>

namespace weir::app {

// Whether a property of this name holds a secret: "password", "user-pw", "token".
bool is_secret(std::string_view property);

// Replaces user names and passwords in addresses ("rtsp://user:password@camera"), and the values of
// properties that hold secrets, with asterisks.
std::string without_secrets(const std::string& text);

}  // namespace weir::app
