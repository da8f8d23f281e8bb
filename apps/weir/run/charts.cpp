// Draws charts with the least and greatest value at the axes; everything else is a tooltip.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/charts.hpp"

#include <algorithm>

#include "run/html.hpp"

namespace weir::app {
namespace {

constexpr double kWidth = 640, kHeight = 150, kLeft = 54, kTop = 10, kBottom = 24;

std::string number(double value) {
  return fixed(value, 1);
}

std::string label(double x, double y, const char* anchor, const std::string& text) {
  return "<text class=\"axis\" text-anchor=\"" + std::string(anchor) + "\" x=\"" + number(x) +
         "\" y=\"" + number(y) + "\">" + escaped(text) + "</text>";
}

std::string frame(const char* kind, const std::string& inside) {
  const double bottom = kTop + kHeight;
  return "<svg class=\"" + std::string(kind) + "\" role=\"img\" width=\"" +
         number(kLeft + kWidth + 40) + "\" height=\"" + number(bottom + kBottom) +
         "\" viewBox=\"0 0 " + number(kLeft + kWidth + 40) + " " + number(bottom + kBottom) +
         "\"><path class=\"grid\" d=\"M" + number(kLeft) + "," + number(kTop) + " V" +
         number(bottom) + " H" + number(kLeft + kWidth) + "\"/>" + inside + "</svg>\n";
}

}  // namespace

std::string level_chart(const Json& queue, double seconds) {
  const Json& levels = queue["levels"];
  const double most = std::max(queue["most"].get<double>(), 1.0);
  const double step = kWidth / static_cast<double>(std::max<size_t>(levels.size(), 1));
  const double bottom = kTop + kHeight;
  std::string path = "M" + number(kLeft) + "," + number(bottom);
  double x = kLeft;
  for (const Json& level : levels) {
    path += " V" + number(bottom - level.get<double>() / most * kHeight);
    x += step;
    path += " H" + number(x);
  }
  path += " V" + number(bottom) + " z";
  return frame("levels", "<path class=\"area\" d=\"" + path + "\"/>" +
                             label(kLeft - 6, kTop + 8, "end", fixed(most, 0)) +
                             label(kLeft - 6, bottom, "end", "0") +
                             label(kLeft, bottom + 17, "start", "0 s") +
                             label(kLeft + kWidth, bottom + 17, "end", fixed(seconds, 2) + " s"));
}

std::string histogram(const Json& latency) {
  const Json& buckets = latency["buckets"];
  double most = 1;
  for (const Json& bucket : buckets) most = std::max(most, bucket["frames"].get<double>());
  const auto count = static_cast<double>(std::max<size_t>(buckets.size(), 1));
  const double step = std::min(kWidth / count, 60.0), bottom = kTop + kHeight;
  std::string inside =
      label(kLeft - 6, kTop + 8, "end", fixed(most, 0)) + label(kLeft - 6, bottom, "end", "0");
  double x = kLeft;
  const size_t labelled = buckets.size() / 8 + 1;
  for (size_t i = 0; i < buckets.size(); ++i, x += step) {
    const Json& bucket = buckets[i];
    const double height = bucket["frames"].get<double>() / most * kHeight;
    const std::string range = duration_text(bucket["from"]) + " to " + duration_text(bucket["to"]);
    inside += "<rect class=\"bar\" x=\"" + number(x + 1) + "\" y=\"" + number(bottom - height) +
              "\" width=\"" + number(std::max(step - 2, 1.0)) + "\" height=\"" + number(height) +
              "\"><title>" + escaped(range) + ": " + fixed(bucket["frames"], 0) +
              " frames</title></rect>";
    if (i % labelled == 0) inside += label(x, bottom + 17, "start", duration_text(bucket["from"]));
  }
  return frame("histogram", inside);
}

}  // namespace weir::app
