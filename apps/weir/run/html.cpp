// Escapes text and formats units.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/html.hpp"

#include <glib.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "gstcpp/element/ref.hpp"

namespace weir::app {

std::string escaped(std::string_view text) {
  const gst::UniqueText valid(g_utf8_make_valid(text.data(), static_cast<gssize>(text.size())));
  std::string out;
  for (const char c : std::string_view(valid.get())) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += (static_cast<unsigned char>(c) < ' ' && c != '\n') || c == '\x7f' ? ' ' : c;
    }
  }
  return out;
}

std::string shortened(const std::string& text, size_t most) {
  const gst::UniqueText valid(g_utf8_make_valid(text.data(), static_cast<gssize>(text.size())));
  if (g_utf8_strlen(valid.get(), -1) <= static_cast<glong>(most)) return valid.get();
  const gst::UniqueText head(g_utf8_substring(valid.get(), 0, static_cast<glong>(most) - 1));
  return std::string(head.get()) + "\u2026";
}

std::string fixed(double value, int digits) {
  std::array<char, G_ASCII_DTOSTR_BUF_SIZE> text{};
  const std::string format = "%." + std::to_string(digits) + "f";
  return g_ascii_formatd(text.data(), static_cast<int>(text.size()), format.c_str(),
                         std::clamp(value, -1e15, 1e15));
}

namespace {

struct Unit {
  double size;
  const char* name;
};

std::string with_unit(double value, const std::vector<Unit>& units) {
  for (const Unit& unit : units) {
    const double number = value / unit.size;
    if (number >= 1 || unit.name == units.back().name)
      return fixed(number, number >= 100 ? 0 : number >= 10 ? 1 : 2) + " " + unit.name;
  }
  return "";
}

}  // namespace

std::string duration_text(double seconds) {
  if (seconds <= 0) return "0";
  return with_unit(seconds, {{1, "s"}, {1e-3, "ms"}, {1e-6, "\u00b5s"}, {1e-9, "ns"}});
}

std::string bytes_text(double bytes) {
  if (bytes < 1000) return fixed(bytes, 0) + " B";
  return with_unit(bytes, {{1e12, "TB"}, {1e9, "GB"}, {1e6, "MB"}, {1e3, "kB"}});
}

std::string rate_text(double per_second) {
  if (per_second <= 0) return "";
  return fixed(per_second, per_second >= 100 ? 0 : per_second >= 10 ? 1 : 2);
}

std::string html_table(const std::vector<std::vector<std::string>>& rows, std::string_view id,
                       const std::vector<size_t>& texts) {
  std::string out = "<div class=\"wide\"><table id=\"" + std::string(id) + "\">\n";
  for (size_t r = 0; r < rows.size(); ++r) {
    out += "<tr>";
    const std::string tag = r == 0 ? "th" : "td";
    for (size_t c = 0; c < rows[r].size(); ++c) {
      const bool text = c == 0 || std::find(texts.begin(), texts.end(), c) != texts.end();
      out.append("<").append(tag).append(text ? " class=\"text\">" : ">");
      out.append(rows[r][c]).append("</").append(tag).append(">");
    }
    out += "</tr>\n";
  }
  return out + "</table></div>\n";
}

}  // namespace weir::app
