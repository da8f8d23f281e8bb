// Writes scores, charts and pictures.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "evaluate/comparison.hpp"

#include <glib.h>

#include <algorithm>
#include <cmath>

#include "core/config/install_paths.hpp"
#include "core/evaluate/average_precision.hpp"
#include "evaluate/evaluator.hpp"
#include "gstcpp/element/ref.hpp"
#include "run/html.hpp"

namespace weir::app {
namespace {

const char* to_string(PictureMark::Kind kind) {
  switch (kind) {
    case PictureMark::Kind::Truth:
      return "truth";
    case PictureMark::Kind::Missed:
      return "missed";
    case PictureMark::Kind::Right:
      return "right";
    case PictureMark::Kind::False:
      return "false";
  }
  return "";
}

std::string make_rect(const std::string& attribute, const evaluate::Rectangle& box) {
  return "<rect" + attribute + " x=\"" + fixed(box.x, 1) + "\" y=\"" + fixed(box.y, 1) +
         "\" width=\"" + fixed(box.width, 1) + "\" height=\"" + fixed(box.height, 1) + "\"/>";
}

// The labels of a picture. They stay inside it, and none covers another while there is place.
class Labels {
 public:
  static constexpr double kLine = 17;  // the height of a label

  Labels(double width, double height) : width_(width), height_(height) {}

  std::string add(const std::string& kind, const std::string& text, double x, double y) {
    const evaluate::Rectangle place = free_place(text, x, y);
    placed_.push_back(place);
    return "<g class=\"label " + kind + "\">" + make_rect("", place) + "<text x=\"" +
           fixed(place.x + kMargin, 1) + "\" y=\"" + fixed(place.y + kLine - kMargin - 1, 1) +
           "\">" + escaped(text) + "</text></g>\n";
  }

 private:
  static constexpr double kLetter = 7.6, kMargin = 3;  // of letters 13 pixels high

  evaluate::Rectangle free_place(const std::string& text, double x, double y) const {
    const auto letters = static_cast<double>(g_utf8_strlen(text.c_str(), -1));
    evaluate::Rectangle place{0, 0, letters * kLetter + 2 * kMargin, kLine};
    place.x = std::clamp(x, 0.0, std::max(0.0, width_ - place.width));
    place.y = std::clamp(y, 0.0, std::max(0.0, height_ - kLine));
    const auto covers = [&place](const auto& other) {
      return place.x < other.x + other.width && other.x < place.x + place.width &&
             place.y < other.y + other.height && other.y < place.y + place.height;
    };
    const auto begin = place;
    for (const double step : {kLine, -kLine}) {  // downwards, and where that leaves it, upwards
      place = begin;
      while (place.y >= 0 && place.y + kLine <= height_) {
        const auto other = std::find_if(placed_.begin(), placed_.end(), covers);
        if (other == placed_.end()) return place;
        place.y = other->y + step;
      }
    }
    return begin;
  }

  const double width_, height_;
  std::vector<evaluate::Rectangle> placed_;
};

// Boxes and points over a dark edge, so that they are seen on every background, then the labels.
// `scale`: pixels of the page for each of the picture.
std::string make_svg(const std::vector<PictureMark>& shapes, double scale, Labels labels) {
  constexpr double kRadius = 3.2;
  std::string edges, boxes, texts;
  for (const PictureMark& shape : shapes) {
    const std::string kind = to_string(shape.kind);
    const evaluate::Rectangle box{shape.box.x * scale, shape.box.y * scale, shape.box.width * scale,
                                  shape.box.height * scale};
    edges += make_rect(" class=\"edge\"", box);
    boxes += make_rect(" class=\"" + kind + "\"", box);
    for (const auto& point : shape.points)
      if (point.is_labelled)
        boxes += "<circle class=\"" + kind + "\" cx=\"" + fixed(point.x * scale, 1) + "\" cy=\"" +
                 fixed(point.y * scale, 1) + "\" r=\"" + fixed(kRadius, 1) + "\"/>";
    // Labels of the truth are at the bottom of its box, so that they do not cover those of results.
    const bool is_truth =
        shape.kind == PictureMark::Kind::Truth || shape.kind == PictureMark::Kind::Missed;
    texts +=
        labels.add(kind, shape.label, box.x, is_truth ? box.y + box.height - Labels::kLine : box.y);
  }
  return edges + "\n" + boxes + "\n" + texts;
}

// Mixes red into the wrong pixels.
void mark(const std::vector<bool>& wrong, DecodedPicture* picture) {
  if (wrong.size() != size_t{picture->width} * picture->height) return;
  const size_t stride = picture->pixels.size() / picture->height;
  constexpr size_t kStep = 3;
  for (uint32_t y = 0; y < picture->height; ++y)
    for (uint32_t x = 0; x < picture->width; ++x) {
      if (!wrong[size_t{y} * picture->width + x]) continue;
      uint8_t* pixel = &picture->pixels[y * stride + kStep * x];
      pixel[0] = static_cast<uint8_t>((pixel[0] + 2 * 255) / 3);
      pixel[1] /= 3;
      pixel[2] /= 3;
    }
}

// A figure: the picture as JPEG in the page, with boxes and points as SVG over it. "" if the
// picture cannot be read any more.
std::string example_picture(const Example& example) {
  constexpr uint32_t kMaxPixels = 640;
  auto picture = decode_picture(example.path);
  if (!picture) return "";
  if (!example.wrong_pixels.empty()) mark(example.wrong_pixels, &*picture);
  const std::string jpeg = small_jpeg(*picture, kMaxPixels);
  if (jpeg.empty()) return "";
  const gst::UniqueText base64(
      g_base64_encode(reinterpret_cast<const guchar*>(jpeg.data()), jpeg.size()));
  const uint32_t longer = std::max(picture->width, picture->height);
  const double scale = std::min(1.0, static_cast<double>(kMaxPixels) / longer);
  const double width = picture->width * scale, height = picture->height * scale;
  std::string out = "<figure><svg class=\"picture\" viewBox=\"0 0 " + fixed(width, 0) + " " +
                    fixed(height, 0) + "\" width=\"" + fixed(width, 0) + "\" height=\"" +
                    fixed(height, 0) + "\"><image width=\"" + fixed(width, 0) + "\" height=\"" +
                    fixed(height, 0) + "\" href=\"data:image/jpeg;base64," + base64.get() +
                    "\"/>\n";
  out += make_svg(example.shapes, scale, Labels(width, height));
  return out + "</svg><figcaption>" + escaped(example.path) + "<br>" + escaped(example.caption) +
         "</figcaption></figure>\n";
}

using Rows = std::vector<std::vector<std::string>>;

constexpr char kEvaluationStyle[] = R"(
.curve { fill: none; stroke: var(--mark); stroke-width: 2; } .curve.b { stroke: var(--heat); }
figure { display: inline-block; margin: 0 1em 1.5em 0; max-width: 640px; vertical-align: top; }
figure svg { max-width: 100%; height: auto; border-radius: 4px; }
figcaption { font-size: 13px; overflow-wrap: anywhere; }
svg.picture rect { fill: none; stroke-width: 2; } svg.picture .edge { stroke: #000; stroke-width: 4; stroke-opacity: .6; }
svg.picture .truth { stroke: #36c26b; } svg.picture .missed { stroke: #ffb020; stroke-dasharray: 6 4; }
svg.picture .right { stroke: #4f9dff; } svg.picture .false { stroke: #ff4d4d; }
svg.picture .label, svg.picture .label rect { stroke: none; }
svg.picture .label text { font: 13px sans-serif; fill: #000; }
svg.picture .truth rect { fill: #36c26b; } svg.picture .missed rect { fill: #ffb020; }
svg.picture .right rect { fill: #4f9dff; } svg.picture .false rect { fill: #ff4d4d; }
svg.picture circle { stroke: none; } svg.picture circle.truth { fill: #36c26b; }
svg.picture circle.missed { fill: #ffb020; } svg.picture circle.right { fill: #4f9dff; }
svg.picture circle.false { fill: #ff4d4d; }
.legend b { padding: 0 .4em; border: 2px solid; border-radius: 3px; margin-right: .8em; font-weight: 400; }
)";

std::string letter(size_t index) {
  return index == 0 ? "A" : "B";
}

std::string score_table(const EvaluationComparison& comparison) {
  const bool is_pair = comparison.evaluated.size() > 1;
  Rows rows{{"score"}};
  for (size_t e = 0; e < comparison.evaluated.size(); ++e) {
    rows[0].push_back(is_pair ? letter(e) : "value");
    rows[0].push_back("95 %");
  }
  if (is_pair) rows[0].insert(rows[0].end(), {"B - A", "95 %"});
  const auto& scores = comparison.evaluated[0].evaluation.scores;
  for (size_t i = 0; i < scores.size(); ++i) {
    std::vector<std::string> row{escaped(scores[i].name)};
    for (const Evaluated& one : comparison.evaluated) {
      row.push_back(number_text(one.evaluation.scores[i].value));
      row.push_back(i < one.intervals.size() ? interval_text(one.intervals[i]) : "");
    }
    if (is_pair) {
      row.push_back(
          number_text(comparison.evaluated[1].evaluation.scores[i].value - scores[i].value));
      row.push_back(i < comparison.differences.size() ? interval_text(comparison.differences[i])
                                                      : "");
    }
    rows.push_back(std::move(row));
  }
  return html_table(rows, "scores");
}

std::string part_table(const EvaluationComparison& comparison) {
  const Evaluation& first = comparison.evaluated[0].evaluation;
  if (first.parts.empty()) return "";
  const bool is_pair = comparison.evaluated.size() > 1;
  Rows rows{{first.part_name, first.part_score + (is_pair ? " of A" : "")}};
  if (is_pair) rows[0].push_back("of B");
  for (const evaluate::Score& part : first.parts) {
    if (std::isnan(part.value)) continue;
    rows.push_back({escaped(part.name), number_text(part.value)});
    if (!is_pair) continue;
    const auto& parts = comparison.evaluated[1].evaluation.parts;
    const auto same = std::find_if(parts.begin(), parts.end(),
                                   [&](const auto& other) { return other.name == part.name; });
    rows.back().push_back(same == parts.end() ? "" : number_text(same->value));
  }
  return "<h2>" + first.part_score + " of each " + first.part_name + "</h2>\n" +
         html_table(rows, "parts");
}

constexpr int kChartWidth = 420, kChartHeight = 260, kChartEdge = 40;

std::string chart_x(double part) {
  return fixed(kChartEdge + part * kChartWidth, 1);
}
std::string chart_y(double part) {
  return fixed(kChartEdge + (1 - part) * kChartHeight, 1);
}

std::string chart_grid() {
  constexpr int kLines = 4;
  std::string out;
  for (int i = 0; i <= kLines; ++i) {
    const double at = static_cast<double>(i) / kLines;
    out += "<path class=\"grid\" d=\"M" + chart_x(0) + " " + chart_y(at);
    out += " H" + chart_x(1) + "\"/><text class=\"axis\" x=\"4\" y=\"" + chart_y(at);
    out += "\">" + fixed(at, 2) + "</text><text class=\"axis\" x=\"" + chart_x(at);
    out += "\" y=\"" + std::to_string(kChartHeight + kChartEdge + 18) + "\">" + fixed(at, 2);
    out += "</text>\n";
  }
  return out;
}

// The mean over the categories with truth.
double precision_at(const Evaluation& evaluation, size_t recall) {
  double sum = 0, categories = 0;
  for (size_t c = 0; c < evaluation.curves.size(); ++c) {
    if (std::isnan(evaluation.parts[c].value)) continue;
    sum += evaluation.curves[c][recall];
    categories += 1;
  }
  return categories > 0 ? sum / categories : 0;
}

// Precision over recall at an overlap of 0.5.
std::string curve_chart(const EvaluationComparison& comparison) {
  if (comparison.evaluated[0].evaluation.curves.empty()) return "";
  std::string out = "<h2>Precision over recall</h2>\n<svg id=\"curves\" width=\"" +
                    std::to_string(kChartWidth + 2 * kChartEdge) + "\" height=\"" +
                    std::to_string(kChartHeight + 2 * kChartEdge) + "\">\n" + chart_grid();
  for (size_t e = 0; e < comparison.evaluated.size(); ++e) {
    out += std::string("<polyline class=\"curve") + (e > 0 ? " b" : "") + "\" points=\"";
    for (size_t r = 0; r < evaluate::kRecalls; ++r) {
      out += chart_x(static_cast<double>(r) / (evaluate::kRecalls - 1)) + ",";
      out += chart_y(precision_at(comparison.evaluated[e].evaluation, r)) + " ";
    }
    out += "\"/>\n";
  }
  return out +
         "</svg>\n<p class=\"note\">Vertical: precision of the boxes above a score. "
         "Horizontal: recall, the part of the objects that these boxes find. A box matches an "
         "object at a similarity of 0.5 or more. The curve is the mean of the categories."
         "</p>\n";
}

std::string confusion_table(const Evaluated& one, const std::string& title) {
  constexpr size_t kMaxClasses = 40;
  const auto& counts = one.evaluation.confusion;
  if (counts.empty() || counts.size() > kMaxClasses) return "";
  Rows rows{{"is"}};
  for (const auto& part : one.evaluation.parts) rows[0].push_back(escaped(part.name));
  rows[0].push_back("another label");
  for (size_t c = 0; c < counts.size(); ++c) {
    rows.push_back({escaped(one.evaluation.parts[c].name)});
    for (size_t f = 0; f < counts[c].size(); ++f) {
      const std::string number = std::to_string(counts[c][f]);
      const bool is_wrong = f != c && counts[c][f] > 0;
      rows.back().push_back(is_wrong ? "<b class=\"bad\">" + number + "</b>" : number);
    }
  }
  return "<h2>" + title + "</h2>\n" + html_table(rows, "confusion") +
         "<p class=\"note\">Rows: the truth; columns: the class that came first.</p>\n";
}

std::string examples(const Evaluated& one, const std::string& title) {
  std::string out = "<h2>" + title + "</h2>\n";
  if (one.evaluation.worst.empty()) return out + "<p>No picture has errors.</p>\n";
  if (!one.evaluation.worst[0].shapes.empty())
    out +=
        "<p class=\"legend\"><b style=\"border-color:#36c26b\">truth</b>"
        "<b style=\"border-color:#ffb020\">missed</b>"
        "<b style=\"border-color:#4f9dff\">found</b>"
        "<b style=\"border-color:#ff4d4d\">false</b></p>\n";
  if (!one.evaluation.worst[0].wrong_pixels.empty())
    out += "<p class=\"note\">Wrong pixels are red.</p>\n";
  for (const Example& example : one.evaluation.worst) out += example_picture(example);
  return out;
}

std::string warnings(const EvaluationComparison& comparison) {
  std::string out;
  for (const Error& warning : comparison.warnings)
    out += "<li><b class=\"bad\">warning</b> " + escaped(warning.what) + ": " +
           escaped(warning.offered) + "</li>\n";
  return out.empty() ? "" : "<ul class=\"diagnostics\">\n" + out + "</ul>\n";
}

}  // namespace

std::string evaluation_page(const EvaluationComparison& comparison) {
  const bool is_pair = comparison.evaluated.size() > 1;
  const Evaluation& first = comparison.evaluated[0].evaluation;
  std::string out = page_begin("Evaluation", kEvaluationStyle) +
                    "<h1>Evaluation</h1>\n<p id=\"folder\">" + escaped(first.metric) + " of " +
                    pictures_text(comparison.pictures) + ", " + escaped(comparison.folder) +
                    "</p>\n";
  for (size_t e = 0; e < comparison.evaluated.size(); ++e)
    out += "<pre>" + (is_pair ? letter(e) + ": " : std::string()) +
           escaped(comparison.evaluated[e].pipeline) + "</pre>\n";
  out += warnings(comparison);
  if (is_pair) out += "<p id=\"verdict\"><b>" + escaped(verdict(comparison)) + "</b></p>\n";
  out += "<h2>Scores</h2>\n" + score_table(comparison);
  if (!comparison.evaluated[0].intervals.empty())
    out += "<p class=\"note\">95 %: the central 95 % of " + std::to_string(comparison.draws) +
           " bootstrap draws of " + std::to_string(first.units) + " " + first.unit_name +
           " with replacement, seed " + std::to_string(comparison.seed) + ".</p>\n";
  for (size_t e = 0; e < comparison.evaluated.size(); ++e)
    out += examples(comparison.evaluated[e],
                    "Most errors" + (is_pair ? " of " + letter(e) : std::string()));
  out += part_table(comparison) + curve_chart(comparison);
  for (size_t e = 0; e < comparison.evaluated.size(); ++e)
    out += confusion_table(comparison.evaluated[e],
                           "Confusion" + (is_pair ? " of " + letter(e) : std::string()));
  return out + "<p class=\"note\">Written by weir " + config::kVersion +
         " evaluate --page.</p>\n</body></html>\n";
}

}  // namespace weir::app
