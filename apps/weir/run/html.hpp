// Formats text for HTML and SVG: escapes names and prints readable numbers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace weir::app {

// Safe as text and in quoted attributes. Control characters become blanks; bytes that are not UTF-8
// become the replacement character.
std::string escaped(std::string_view text);
// At most `max` characters; the last is an ellipsis if some are omitted. Not escaped.
std::string shortened(const std::string& text, size_t max);

std::string fixed(double value, int digits);  // independent of the locale
std::string duration_text(double seconds);    // "12.3 ms"
std::string bytes_text(double bytes);         // "1.2 MB"
std::string rate_text(double per_second);     // "29.97", "" for 0

// The begin of a self-contained page, up to the begin of its body. `style`: further rules of CSS.
std::string page_begin(std::string_view title, std::string_view style = "");

// A table of HTML cells. The first row is the heading. The first column and those in `texts` are
// text, the others numbers.
std::string html_table(const std::vector<std::vector<std::string>>& rows, std::string_view id,
                       const std::vector<size_t>& texts = {});

}  // namespace weir::app
