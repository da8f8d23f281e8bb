// Draws boxes for elements and arrows for links; the darker a box, the larger its share of the
// time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/graph_picture.hpp"

#include <algorithm>
#include <map>

#include "core/trace/layout.hpp"
#include "run/html.hpp"

namespace weir::app {
namespace {

constexpr double kWidth = 168, kHeight = 74, kAcross = 84, kBetween = 26, kMargin = 12;

double left(const trace::Place& place) {
  return kMargin + static_cast<double>(place.column) * (kWidth + kAcross);
}
double middle(const trace::Place& place) {
  return kMargin + place.row * (kHeight + kBetween) + kHeight / 2;
}
std::string number(double value) {
  return fixed(value, 1);
}

std::string line(double y, const char* kind, const std::string& text) {
  return "<text class=\"" + std::string(kind) + "\" x=\"10\" y=\"" + number(y) + "\">" +
         escaped(text) + "</text>";
}

std::string box(const trace::Place& place, const Json& element, double most) {
  const double work = element["work"];
  const double frames =
      std::max(element["in"]["frames"].get<double>(), element["out"]["frames"].get<double>());
  const double heat = most > 0 ? work / most : 0;
  const std::string name = element["name"], factory = element["factory"];
  std::string out = "<g class=\"element\" transform=\"translate(" + number(left(place)) + "," +
                    number(middle(place) - kHeight / 2) + ")\"><title>" + escaped(name) + " (" +
                    escaped(factory) + ")</title><rect class=\"box\" width=\"" + number(kWidth) +
                    "\" height=\"" + number(kHeight) +
                    "\" rx=\"6\"/><rect class=\"heat\" width=\"" + number(kWidth) + "\" height=\"" +
                    number(kHeight) + "\" rx=\"6\" fill-opacity=\"" + fixed(heat * 0.55, 3) +
                    "\"/>";
  out += line(21, "name", shortened(name, 18));
  out += line(37, "factory", shortened(factory, 24));
  const double in = element["in"]["frames"];
  const double calls = in > 0 ? in : static_cast<double>(element["out"]["frames"]);
  const double own = element["thread_work"];
  // A source has no chain function: its time is that of its thread.
  const std::string time = in > 0      ? duration_text(work / calls) + " a frame"
                           : calls > 1 ? duration_text(own / (calls - 1)) + " a frame"
                                       : "";
  const double rate = in > 0 ? element["in"]["rate"] : element["out"]["rate"];
  out += line(56, "number",
              fixed(frames, 0) + " frames" + (rate > 0 ? ", " + rate_text(rate) + "/s" : ""));
  out += line(69, "number", time);
  return out + "</g>\n";
}

std::string arrow(const trace::Route& route, const trace::Layout& layout, const std::string& what,
                  const std::string& title) {
  const trace::Place &from = layout.boxes[route.from], &to = layout.boxes[route.to];
  double x = left(from) + kWidth, y = middle(from);
  std::string path = "M" + number(x) + "," + number(y);
  const auto curve = [&](double next_x, double next_y) {
    const double half = (next_x - x) / 2;
    path += " C" + number(x + half) + "," + number(y) + " " + number(next_x - half) + "," +
            number(next_y) + " " + number(next_x) + "," + number(next_y);
    x = next_x;
    y = next_y;
  };
  for (const trace::Place& place : route.through) {
    const bool forward = left(place) > x;
    curve(left(place) + (forward ? 0 : kWidth), middle(place));
    curve(left(place) + (forward ? kWidth : 0), middle(place));
  }
  // Puts the number of frames next to a line that comes from above or below, not across it.
  const bool from_above = y < middle(to);
  curve(left(to) - 7, middle(to));
  return "<g><title>" + escaped(title) +
         "</title><path class=\"link\" marker-end=\"url(#tip)\" d=\"" + path +
         "\"/><text class=\"count\" x=\"" + number(left(to) - 12) + "\" y=\"" +
         number(middle(to) + (from_above ? 15 : -6)) + "\">" + escaped(what) + "</text></g>\n";
}

}  // namespace

std::string graph_picture(const Json& summary, const std::vector<size_t>& shown) {
  std::map<size_t, size_t> box_of;
  double most = 0;
  for (size_t i = 0; i < shown.size(); ++i) {
    box_of[shown[i]] = i;
    most = std::max(most, summary["elements"][shown[i]]["work"].get<double>());
  }
  std::vector<std::pair<size_t, size_t>> arrows;
  std::vector<const Json*> links;
  for (const Json& link : summary["links"]) {
    if (!link["from"].is_number() || !link["to"].is_number()) continue;
    const auto from = box_of.find(link["from"]), to = box_of.find(link["to"]);
    if (from == box_of.end() || to == box_of.end() || from == to) continue;
    arrows.emplace_back(from->second, to->second);
    links.push_back(&link);
  }
  const trace::Layout layout = trace::lay_out(shown.size(), arrows);
  const double width =
      2 * kMargin + static_cast<double>(layout.columns) * (kWidth + kAcross) - kAcross;
  const double height = 2 * kMargin + layout.rows * (kHeight + kBetween) - kBetween;
  // Fits the width of the page as long as the text stays readable.
  std::string out =
      "<div class=\"wide\"><svg id=\"graph\" role=\"img\" width=\"" + number(width) +
      "\" style=\"max-width: 100%; height: auto; min-width: " + fixed(width * 0.6, 0) +
      "px\" height=\"" + number(height) + "\" viewBox=\"0 0 " + number(width) + " " +
      number(height) +
      "\"><defs><marker id=\"tip\" viewBox=\"0 0 8 8\" refX=\"1\" refY=\"4\" "
      "markerWidth=\"8\" markerHeight=\"8\" orient=\"auto\"><path class=\"tip\" "
      "d=\"M0,0 L8,4 L0,8 z\"/></marker></defs>\n";
  for (size_t i = 0; i < links.size(); ++i) {
    const Json& link = *links[i];
    const std::string title = link["from_pad"].get<std::string>() + " to " +
                              link["to_pad"].get<std::string>() + ", " + bytes_text(link["bytes"]) +
                              " in all";
    out += arrow(layout.routes[i], layout, fixed(link["frames"], 0), title);
  }
  for (size_t i = 0; i < shown.size(); ++i)
    out += box(layout.boxes[i], summary["elements"][shown[i]], most);
  return out + "</svg></div>\n";
}

}  // namespace weir::app
