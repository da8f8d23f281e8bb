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

std::string shortened(const std::string& text, size_t max) {
  const gst::UniqueText valid(g_utf8_make_valid(text.data(), static_cast<gssize>(text.size())));
  if (g_utf8_strlen(valid.get(), -1) <= static_cast<glong>(max)) return valid.get();
  const gst::UniqueText head(g_utf8_substring(valid.get(), 0, static_cast<glong>(max) - 1));
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

namespace {

constexpr char kPageStyle[] = R"(
:root { color-scheme: light dark; --text: #1c2330; --dim: #5d6778; --line: #cdd3dd; --back: #fff; --box: #f4f6f9;
  --mark: #2f6fde; --heat: #e2622b; --bad: #b3261e; }
@media (prefers-color-scheme: dark) { :root { --text: #e6e9ef; --dim: #9aa4b5; --line: #3a4352; --back: #161b24;
  --box: #212936; --mark: #6ea2ff; --heat: #e2622b; --bad: #ff8a80; } }
body { font: 15px/1.45 system-ui, sans-serif; color: var(--text); background: var(--back); margin: 2em auto;
  max-width: 120em; padding: 0 1.5em; }
h1 { font-size: 1.5em; margin-bottom: .2em; } h2 { font-size: 1.15em; margin-top: 2em; } h3 { font-size: 1em; }
pre { background: var(--box); padding: .8em 1em; border-radius: 6px; white-space: pre-wrap; overflow-wrap: anywhere; }
.wide { overflow-x: auto; } p.note { color: var(--dim); max-width: 60em; }
.bad { color: var(--bad); } ul.diagnostics li { overflow-wrap: anywhere; }
table { border-collapse: collapse; font-size: 13px; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: .25em .7em .25em 0; border-bottom: 1px solid var(--line); white-space: nowrap; }
th { color: var(--dim); font-weight: 600; } th.text, td.text { text-align: left; }
svg text { font: 12px system-ui, sans-serif; fill: var(--text); } svg text.name { font-size: 14px; font-weight: 600; }
svg text.factory, svg text.count, svg text.axis { fill: var(--dim); } svg text.count { text-anchor: middle; font-size: 11px;
  paint-order: stroke; stroke: var(--back); stroke-width: 4px; }
#graph { max-width: 100%; height: auto; } input[name=zoom] { margin: 0 .2em 0 0; } input[name=zoom] + label { margin-right: .8em; }
#zoom-150:checked ~ .wide #graph { width: 150%; max-width: none; } #zoom-200:checked ~ .wide #graph { width: 200%; max-width: none; }
#zoom-300:checked ~ .wide #graph { width: 300%; max-width: none; }
.box { fill: var(--box); stroke: var(--line); } .box.marked { stroke: var(--heat); stroke-width: 2.5; }
.box.failed { stroke: var(--bad); stroke-width: 3; } svg text.bad { fill: var(--bad); font-weight: 600; }
.track { fill: var(--back); } .work { fill: var(--heat); } .waiting { fill: var(--mark); fill-opacity: .35; }
.link, .grid { fill: none; stroke: var(--dim); stroke-width: 1.3; } .grid { stroke: var(--line); }
.tip { fill: var(--dim); } .area { fill: var(--mark); fill-opacity: .35; stroke: var(--mark); } .bar { fill: var(--mark); }
#verdict { font-size: 1.3em; font-weight: 600; margin: .4em 0; } #verdict.failed, #verdict.nothing-ran { color: var(--bad); }
.key { display: inline-block; width: 2.2em; height: .7em; } .key.work { background: var(--heat); }
.key.waiting { background: var(--mark); opacity: .35; }
#links td:last-child, #properties td:last-child { white-space: normal; overflow-wrap: anywhere; }
summary { cursor: pointer; font-size: 1.15em; font-weight: 600; margin: 2em 0 .8em; }
)";

}  // namespace

std::string page_begin(std::string_view title, std::string_view style) {
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
         "<meta name=\"viewport\" content=\"width=device-width\"><title>" +
         escaped(title) + "</title><style>" + kPageStyle + std::string(style) +
         "</style></head><body>\n";
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
