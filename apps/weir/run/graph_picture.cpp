// A graph reads like text: columns from left to right, and after a few of them on the next line.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/report_document.hpp"

#include <gst/gst.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string_view>

#include "core/trace/graph_layout.hpp"
#include "gstcpp/buffer/caps_text.hpp"
#include "run/html.hpp"

namespace weir::app {
namespace {

std::string field(const GstStructure* caps, const char* name) {
  const char* text = gst_structure_get_string(caps, name);
  return text ? text : "";
}

int number(const GstStructure* caps, const char* name) {
  int value = 0;
  gst_structure_get_int(caps, name, &value);
  return value;
}

// "640x480", "" if the caps have no size.
std::string size_text(const GstStructure* caps) {
  const int width = number(caps, "width"), height = number(caps, "height");
  return width > 0 && height > 0 ? std::to_string(width) + "x" + std::to_string(height) : "";
}

std::string frame_rate_text(const GstStructure* caps) {
  int frames = 0, seconds = 0;
  if (!gst_structure_get_fraction(caps, "framerate", &frames, &seconds) || frames <= 0 ||
      seconds <= 0)
    return "";
  const double rate = static_cast<double>(frames) / seconds;
  return fixed(rate, frames % seconds == 0 ? 0 : 2) + " fps";
}

std::string sound_text(const GstStructure* caps) {
  const int rate = number(caps, "rate"), channels = number(caps, "channels");
  constexpr int kKilo = 1000;
  return rate <= 0 ? ""
                   : fixed(static_cast<double>(rate) / kKilo, rate % kKilo == 0 ? 0 : 1) +
                         " kHz, " + std::to_string(channels) + " ch";
}

// The first of a list, and how many more there are: "3:224:224 +1".
std::string format_first(std::string list) {
  size_t more = 0;
  for (const char c : list) more += c == ',' || c == '.' ? 1U : 0U;
  list.erase(std::min(list.find_first_of(",."), list.size()));
  return more == 0 ? list : list + " +" + std::to_string(more);
}

std::vector<std::string> make_lines(const GstStructure* caps) {
  const std::string_view type = gst_structure_get_name(caps);
  if (type == "video/x-raw")
    return {field(caps, "format") + " " + size_text(caps), frame_rate_text(caps)};
  if (type == "audio/x-raw") return {field(caps, "format"), sound_text(caps)};
  if (type == "other/tensor") return {field(caps, "type"), field(caps, "dimension")};
  if (type == "other/tensors" && !field(caps, "types").empty())
    return {format_first(field(caps, "types")), format_first(field(caps, "dimensions"))};
  if (type == "other/tensors") return {std::string(type), field(caps, "format")};
  const std::string size = size_text(caps);
  return {std::string(type), size.empty() ? sound_text(caps) : size};
}

// Lines of a label: {"RGB 640x480", "30 fps"}, {"float32", "3:224:224"}, {"video/x-h264"}. None
// for text that is not caps.
std::vector<std::string> caps_lines(const std::string& text) {
  const auto caps = gst::caps_from_text(text);
  if (!caps || gst_caps_get_size(caps->get()) == 0) return {};
  auto lines = make_lines(gst_caps_get_structure(caps->get(), 0));
  std::erase_if(lines, [](const std::string& line) { return line.empty() || line == " "; });
  return lines;
}

constexpr double kBoxWidth = 184, kBoxHeight = 98, kAcross = 130, kBetween = 30, kMargin = 30;
constexpr double kBar = 10;                 // of work and waiting, at the bottom of a box
constexpr size_t kColumns = 4;              // on a line
constexpr double kGutter = 76, kTrack = 5;  // between lines; between arrows there
constexpr double kParallel = 44;            // between links of the same two elements
constexpr double kTip = 7;
constexpr size_t kLabel = 20;  // characters between two boxes

std::string coordinate(double value) {
  return fixed(value, 1);
}

// Where the places of a layout are drawn.
class Page {
 public:
  explicit Page(const trace::GraphLayout& layout) {
    const size_t lines = (layout.columns + kColumns - 1) / kColumns;
    first_row_.assign(lines, layout.rows);
    std::vector<double> end_row(lines, 0);
    const auto add = [&](const trace::Place& place) {
      double& first = first_row_[place.column / kColumns];
      double& end = end_row[place.column / kColumns];
      first = std::min(first, place.row);
      end = std::max(end, place.row + 1);
    };
    for (const auto& box : layout.boxes) add(box);
    for (const auto& route : layout.routes)
      for (const auto& place : route.through) add(place);
    double y = kMargin / 2;
    for (size_t line = 0; line < lines; ++line) {
      top_.push_back(y);
      y += std::max(end_row[line] - first_row_[line], 1.0) * (kBoxHeight + kBetween) - kBetween;
      bottom_.push_back(y);
      y += kGutter;
    }
    height_ = lines == 0 ? kMargin : bottom_.back() + kMargin / 2;
    const auto columns =
        static_cast<double>(std::min(std::max<size_t>(layout.columns, 1), kColumns));
    width_ = 2 * kMargin + columns * (kBoxWidth + kAcross) - kAcross;
  }

  static double left(const trace::Place& place) {
    return kMargin + static_cast<double>(place.column % kColumns) * (kBoxWidth + kAcross);
  }
  double middle(const trace::Place& place) const {
    const size_t line = get_line(place);
    return top_[line] + (place.row - first_row_[line]) * (kBoxHeight + kBetween) + kBoxHeight / 2;
  }
  static size_t get_line(const trace::Place& place) { return place.column / kColumns; }
  double below(size_t line) const { return bottom_[line]; }
  double width() const { return width_; }
  double height() const { return height_; }

 private:
  std::vector<double> first_row_, top_, bottom_;  // of each line
  double width_ = 0, height_ = 0;
};

std::string line(double y, const char* kind, const std::string& text) {
  return "<text class=\"" + std::string(kind) + "\" x=\"10\" y=\"" + coordinate(y) + "\">" +
         escaped(text) + "</text>";
}

std::string rectangle(const char* kind, double x, double y, double width, double height) {
  return "<rect class=\"" + std::string(kind) + "\" x=\"" + coordinate(x) + "\" y=\"" +
         coordinate(y) + "\" width=\"" + coordinate(width) + "\" height=\"" + coordinate(height) +
         "\"/>";
}

std::string rounded_percent(double share) {
  return fixed(share * 100, share < 0.1 && share >= 0.0005 ? 1 : 0) + " %";
}

// Work from the left, waiting after it; the whole width is all of the time.
std::string share_bar(double work, double waiting) {
  const double all = kBoxWidth - 20, y = kBoxHeight - kBar - 8;
  const double worked = std::clamp(work, 0.0, 1.0) * all;
  const double waited = std::clamp(waiting, 0.0, 1.0) * all;
  return rectangle("track", 10, y, all, kBar) + rectangle("work", 10, y, worked, kBar) +
         rectangle("waiting", 10 + worked, y, std::min(waited, all - worked), kBar);
}

std::string tooltip(const Json& element) {
  std::string out =
      element["name"].get<std::string>() + " (" + element["factory"].get<std::string>() + ")";
  for (const auto& [name, value] : element["properties"].items())
    out += "\n" + name + "=" + value.get<std::string>();
  return out;
}

std::string box(double x, double y, const Json& trace, const Json& element,
                const std::string& marked) {
  const double work = element["share"], waiting = element["waiting_share"];
  const double in = element["in"]["frames"], out_frames = element["out"]["frames"];
  const double rate = in > 0 ? element["in"]["rate"] : element["out"]["rate"];
  const std::string name = element["name"];
  const bool has_failed = element["failed"];
  std::string kind = has_failed ? "box failed" : name == marked ? "box marked" : "box";
  std::string factory = element["factory"];
  const Json& bin = trace["elements"][element["parent"].get<size_t>()];
  if (!bin["parent"].is_null()) factory += ", in " + bin["name"].get<std::string>();
  std::string out = "<g class=\"element\" transform=\"translate(" + coordinate(x) + "," +
                    coordinate(y) + ")\"><title>" + escaped(tooltip(element)) +
                    "</title><rect class=\"" + kind + "\" width=\"" + coordinate(kBoxWidth) +
                    "\" height=\"" + coordinate(kBoxHeight) + "\" rx=\"6\"/>";
  out += line(19, "name", shortened(name, 21)) + line(34, "factory", shortened(factory, 27));
  out += line(51, "number",
              fixed(std::max(in, out_frames), 0) + " frames" +
                  (rate > 0 ? ", " + rate_text(rate) + "/s" : ""));
  std::string times = rounded_percent(work) + " work";
  if (waiting >= 0.0005) times += ", " + rounded_percent(waiting) + " waiting";
  out += has_failed ? line(69, "number bad", "failed") : line(69, "number", times);
  return out + share_bar(work, waiting) + "</g>\n";
}

// The gutters between lines, in which each arrow has a track and a place for its label.
class Gutters {
 public:
  void add(const trace::GraphLayout& layout, const trace::Route& route) {
    const trace::Place* at = &layout.boxes[route.from];
    const auto reach = [&](const trace::Place& place) {
      if (const auto gutter = between(*at, place)) ++arrows_[*gutter];
      at = &place;
    };
    for (const auto& place : route.through) reach(place);
    reach(layout.boxes[route.to]);
  }
  // The line above the gutter that two places of adjacent columns have between them.
  static std::optional<size_t> between(const trace::Place& a, const trace::Place& b) {
    if (Page::get_line(a) == Page::get_line(b)) return std::nullopt;
    return std::min(Page::get_line(a), Page::get_line(b));
  }
  struct Track {
    double aside = 0;  // from the middle of the gutter
    double half = 0;   // from the middle to the outermost track
    double along = 0;  // where its label is, 0 to 1
  };
  // For the next arrow.
  Track take(size_t gutter) {
    const auto all = static_cast<double>(arrows_[gutter]);
    const auto used = static_cast<double>(used_[gutter]++);
    const double half = (all - 1) / 2;
    return {(used - half) * kTrack, half * kTrack, (used + 0.5) / all};
  }

 private:
  std::map<size_t, size_t> arrows_, used_;  // by the line above
};

// Draws an arrow from place to place, around the ends of lines.
class Arrow {
 public:
  Arrow(const Page& page, Gutters* gutters, const trace::Place& from, double aside)
      : page_(page),
        gutters_(gutters),
        at_(&from),
        x_(Page::left(from) + kBoxWidth),
        y_(page.middle(from) + aside) {
    path_ = "M" + coordinate(x_) + "," + coordinate(y_);
  }

  void through(const trace::Place& place) {
    const bool forward = place.column > at_->column;
    reach(place, Page::left(place) + (forward ? 0 : kBoxWidth), 0);
    curve(Page::left(place) + (forward ? kBoxWidth : 0), page_.middle(place));
  }
  void end(const trace::Place& place, double aside) {
    reach(place, Page::left(place) - kTip, aside);
  }
  double label_x() const { return label_x_; }
  double label_y() const { return label_y_; }
  double label_half() const { return label_half_; }
  const std::string& path() const { return path_; }

 private:
  void reach(const trace::Place& place, double x, double aside) {
    const double y = page_.middle(place) + aside;
    if (const auto gutter = Gutters::between(*at_, place))
      around(*gutter, x, y, place.column > at_->column);
    else
      curve(x, y);
    at_ = &place;
  }
  void curve(double x, double y) {
    const double half = (x - x_) / 2;
    label_x_ = x_ + half;
    label_y_ = (y_ + y) / 2;
    label_half_ = 0;
    path_ += " C" + coordinate(x_ + half) + "," + coordinate(y_) + " " + coordinate(x - half) +
             "," + coordinate(y) + " " + coordinate(x) + "," + coordinate(y);
    x_ = x;
    y_ = y;
  }
  void around(size_t gutter, double x, double y, bool forward) {
    const Gutters::Track track = gutters_->take(gutter);
    const double middle = page_.below(gutter) + kGutter / 2;
    const double level = middle + track.aside;
    const double right = page_.width() - kMargin / 2 + track.aside / 2;
    const double left = kMargin / 2 - track.aside / 2;
    label_x_ = kMargin + (page_.width() - 2 * kMargin) * track.along;
    label_y_ = middle;
    label_half_ = track.half;
    path_ += " H" + coordinate(forward ? right : left) + " V" + coordinate(level) + " H" +
             coordinate(forward ? left : right) + " V" + coordinate(y) + " H" + coordinate(x);
    x_ = x;
    y_ = y;
  }

  const Page& page_;
  Gutters* gutters_;
  const trace::Place* at_;
  double x_, y_;
  // The label of the last part; half: the distance to keep above and below.
  double label_x_ = 0, label_y_ = 0, label_half_ = 0;
  std::string path_;
};

std::string label(double x, double y, const std::string& text) {
  return "<text class=\"count\" x=\"" + coordinate(x) + "\" y=\"" + coordinate(y) + "\">" +
         escaped(text) + "</text>";
}

// `aside`: how far it is moved down, where two elements have several links.
std::string arrow(const Page& page, Gutters* gutters, const trace::GraphLayout& layout,
                  const trace::Route& route, double aside, const Json& link) {
  Arrow drawn(page, gutters, layout.boxes[route.from], aside);
  for (const trace::Place& place : route.through) drawn.through(place);
  drawn.end(layout.boxes[route.to], aside);
  const std::string caps = link["caps"];
  const std::string title = link["from_pad"].get<std::string>() + " to " +
                            link["to_pad"].get<std::string>() + ", " + bytes_text(link["bytes"]) +
                            " in all\n" + (caps.empty() ? "no caps" : caps);
  std::string out = "<g><title>" + escaped(title) +
                    "</title><path class=\"link\" marker-end=\"url(#tip)\" d=\"" + drawn.path() +
                    "\"/>";
  const auto lines = caps_lines(caps);
  double y =
      drawn.label_y() - drawn.label_half() - 5 - 13 * (static_cast<double>(lines.size()) - 1);
  for (const std::string& text : lines) {
    out += label(drawn.label_x(), y, shortened(text, kLabel));
    y += 13;
  }
  return out +
         label(drawn.label_x(), drawn.label_y() + drawn.label_half() + 15,
               fixed(link["frames"], 0)) +
         "</g>\n";
}

// Buttons that need no script; the rules of CSS are in html.cpp.
std::string zoom_buttons() {
  std::string out;
  for (const auto& [id, text] :
       {std::pair{"fit", "Fit"}, {"150", "150 %"}, {"200", "200 %"}, {"300", "300 %"}})
    out += "<input type=\"radio\" name=\"zoom\" id=\"zoom-" + std::string(id) + "\"" +
           (id == std::string("fit") ? " checked" : "") + "><label for=\"zoom-" + id + "\">" +
           text + "</label>\n";
  return out;
}

}  // namespace

std::string graph_picture(const Json& trace, const std::vector<size_t>& shown,
                          const std::string& marked) {
  std::map<size_t, size_t> box_of;
  for (size_t i = 0; i < shown.size(); ++i) box_of[shown[i]] = i;
  std::vector<std::pair<size_t, size_t>> arrows;
  std::vector<const Json*> links;
  for (const Json& link : trace["links"]) {
    if (!link["from"].is_number() || !link["to"].is_number()) continue;
    const auto from = box_of.find(link["from"]), to = box_of.find(link["to"]);
    if (from == box_of.end() || to == box_of.end() || from == to) continue;
    arrows.emplace_back(from->second, to->second);
    links.push_back(&link);
  }
  const trace::GraphLayout layout = trace::lay_out(shown.size(), arrows);
  const Page page(layout);
  const std::string width = coordinate(page.width()), height = coordinate(page.height());
  std::string out = zoom_buttons() + "<div class=\"wide\"><svg id=\"graph\" role=\"img\" width=\"" +
                    width + "\" height=\"" + height + "\" viewBox=\"0 0 " + width + " " + height +
                    "\"><defs><marker id=\"tip\" viewBox=\"0 0 8 8\" refX=\"1\" refY=\"4\" "
                    "markerWidth=\"8\" markerHeight=\"8\" orient=\"auto\"><path class=\"tip\" "
                    "d=\"M0,0 L8,4 L0,8 z\"/></marker></defs>\n";
  Gutters gutters;
  std::map<std::pair<size_t, size_t>, double> links_of, drawn_of;
  for (size_t i = 0; i < links.size(); ++i) {
    gutters.add(layout, layout.routes[i]);
    ++links_of[arrows[i]];
  }
  for (size_t i = 0; i < links.size(); ++i) {
    const double aside = (drawn_of[arrows[i]]++ - (links_of[arrows[i]] - 1) / 2) * kParallel;
    out += arrow(page, &gutters, layout, layout.routes[i], aside, *links[i]);
  }
  for (size_t i = 0; i < shown.size(); ++i) {
    const trace::Place& place = layout.boxes[i];
    out += box(Page::left(place), page.middle(place) - kBoxHeight / 2, trace,
               trace["elements"][shown[i]], marked);
  }
  return out + "</svg></div>\n";
}

}  // namespace weir::app
