// Appends numbers, times and strings to the text formats of results. No locale has an effect.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace weir::records {

// The shortest decimal text that reads back as the same float. Precondition: finite.
void append_number(float number, std::string* out);
void append_number(int64_t number, std::string* out);
// Nanoseconds as seconds, with the decimals that are needed: 1.5.
void append_seconds(int64_t nanoseconds, std::string* out);
// Nanoseconds since 1970 (UTC) as RFC 3339 writes them: 2024-02-29T12:00:00.5Z.
void append_utc(int64_t unix_nanoseconds, std::string* out);
// A JSON string with its quotes. Bytes that are not UTF-8 become U+FFFD.
void append_json_string(std::string_view text, std::string* out);

}  // namespace weir::records
