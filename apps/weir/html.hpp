// Text for HTML and SVG: escaped names, numbers for people.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace weir::app {

// Safe as text and inside quoted attributes. Control characters become blanks, bytes that are not
// UTF-8 the replacement character.
std::string escaped(std::string_view text);
// At most `most` characters, the last one an ellipsis where some are left out. Not escaped.
std::string shortened(const std::string& text, size_t most);

std::string fixed(double value, int digits);  // in any locale
std::string duration_text(double seconds);    // "12.3 ms"
std::string bytes_text(double bytes);         // "1.2 MB"
std::string rate_text(double per_second);     // "29.97", "" for 0

// A table; the cells are HTML. The first row is the heading, the first column text, others numbers
// unless `texts` names them.
std::string html_table(const std::vector<std::vector<std::string>>& rows, std::string_view id,
                       const std::vector<size_t>& texts = {});

}  // namespace weir::app
