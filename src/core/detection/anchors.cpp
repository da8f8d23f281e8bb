// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/anchors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "core/detection/best_class.hpp"
#include "core/detection/sigmoid.hpp"
#include "core/tensor/geometry.hpp"
#include "core/text/text.hpp"

namespace weir::detection {
namespace {

constexpr std::array kLineNames{"y of the centres", "x of the centres", "heights", "widths"};

Error invalid_priors(std::string difference) {
  return Error{
      .code = Code::OPTION_SYNTAX,
      .what = "the file is not a list of prior boxes",
      .needed =
          "four lines with the same number of values: y and x of the centres, heights, widths",
      .difference = std::move(difference)};
}

Status read_line(std::string_view line, const std::string& place, std::vector<float>* list) {
  for (const auto word : split(line, " \t,\r")) {
    if (word.empty()) continue;
    const auto value = parse_double(word);
    if (!value || !std::isfinite(static_cast<float>(*value)))
      return invalid_priors(place + ": \"" + std::string(word.substr(0, 40)) +
                            "\" is not a number");
    list->push_back(static_cast<float>(*value));
  }
  return ok();
}

float logit(float probability) {
  if (probability <= 0) return -std::numeric_limits<float>::infinity();
  if (probability >= 1) return std::numeric_limits<float>::infinity();
  return std::log(probability / (1 - probability));
}

// The class of a row that is taken and its logit; class 0 if none reaches the threshold.
struct Found {
  int32_t class_index = 0;
  float score = 0;
};
Found find_class(std::span<const float> row, float threshold, SsdClass choice) {
  const auto scores = row.subspan(1);
  if (choice == SsdClass::First) {
    for (size_t i = 0; i < scores.size(); ++i)
      if (scores[i] >= threshold) return {static_cast<int32_t>(i + 1), scores[i]};
    return {};
  }
  const float best = best_score(scores);
  if (!(best >= threshold) || scores.empty()) return {};
  const int32_t found = class_with(scores, best);
  if (scores[static_cast<size_t>(found)] != best) return {};  // no score is a number
  return {found + 1, best};
}

constexpr uint32_t kGrids = 6, kFirstStride = 16;
constexpr double kMinScale = 0.2, kMaxScale = 0.95, kScaleOfFirst = 0.1;

struct AnchorSize {
  double height, width;
};

// Returns the size with the ratio width / height and the area of a square of this scale.
AnchorSize make_size(double scale, double ratio) {
  return {scale / std::sqrt(ratio), scale * std::sqrt(ratio)};
}

std::vector<AnchorSize> make_sizes(uint32_t grid) {
  const auto scale = [](uint32_t i) {
    return kMinScale + (kMaxScale - kMinScale) * i / (kGrids - 1);
  };
  if (grid == 0)
    return {make_size(kScaleOfFirst, 1), make_size(scale(0), 2), make_size(scale(0), 0.5)};
  std::vector<AnchorSize> out;
  for (const double ratio : {1.0, 2.0, 0.5, 3.0, 1.0 / 3})
    out.push_back(make_size(scale(grid), ratio));
  const double next = grid + 1 < kGrids ? scale(grid + 1) : 1.0;
  out.push_back(make_size(std::sqrt(scale(grid) * next), 1));
  return out;
}

// Calls `visit` with the number, the columns and the rows of each grid.
template <class Visit>
void for_each_grid(Size input, Visit visit) {
  uint32_t columns = input.width / kFirstStride + (input.width % kFirstStride > 0 ? 1 : 0);
  uint32_t rows = input.height / kFirstStride + (input.height % kFirstStride > 0 ? 1 : 0);
  for (uint32_t grid = 0; grid < kGrids; ++grid) {
    visit(grid, columns, rows);
    columns = (columns + 1) / 2, rows = (rows + 1) / 2;
  }
}

constexpr uint32_t kGridPixels = 192;

float get_scale(const PalmAnchorOptions& options, size_t layer) {
  const size_t layers = options.strides.size();
  if (layers == 1) return (options.min_scale + options.max_scale) / 2;
  return options.min_scale + (options.max_scale - options.min_scale) * static_cast<float>(layer) /
                                 static_cast<float>(layers - 1);
}

// One anchor of each scale in each cell of a square grid.
void add_grid(uint32_t stride, const std::vector<float>& scales, const PalmAnchorOptions& options,
              std::vector<Anchor>* anchors) {
  const uint32_t cells = kGridPixels / stride + (kGridPixels % stride != 0 ? 1 : 0);
  const auto across = static_cast<float>(cells);
  for (uint32_t y = 0; y < cells; ++y)
    for (uint32_t x = 0; x < cells; ++x)
      for (const float scale : scales)
        anchors->push_back({.x = (static_cast<float>(x) + options.x_offset) / across,
                            .y = (static_cast<float>(y) + options.y_offset) / across,
                            .width = scale,
                            .height = scale});
}

}  // namespace

Result<BoxPriors> parse_box_priors(std::string_view text) {
  BoxPriors priors;
  const std::array lists{&priors.y, &priors.x, &priors.height, &priors.width};
  size_t line_number = 0;
  for (const auto line : split(strip(text), "\n")) {
    if (line_number == lists.size()) return invalid_priors("there are more than four lines");
    auto& list = *lists[line_number];
    const std::string place =
        "line " + std::to_string(line_number + 1) + " (" + kLineNames[line_number] + ")";
    if (auto status = read_line(line, place, &list); !status) return status.error();
    if (list.empty() || list.size() != priors.y.size())
      return invalid_priors(place + " has " + std::to_string(list.size()) +
                            " values, the first line " + std::to_string(priors.y.size()));
    ++line_number;
  }
  if (line_number < lists.size())
    return invalid_priors("there are " + std::to_string(line_number) + " lines");
  return priors;
}

Candidates decode(const SsdHead& head, const BoxPriors& priors, const SsdScales& scales,
                  float threshold, Size picture, SsdClass choice) {
  const auto picture_width = static_cast<float>(picture.width);
  const auto picture_height = static_cast<float>(picture.height);
  const float min = logit(threshold);
  Candidates found;
  for (size_t i = 0; i < head.scores.size() / head.classes; ++i) {
    const auto best = find_class(head.scores.subspan(i * head.classes, head.classes), min, choice);
    if (best.class_index == 0) continue;
    const auto box = head.boxes.subspan(4 * i, 4);
    const float centre_y = box[0] / scales.y * priors.height[i] + priors.y[i];
    const float centre_x = box[1] / scales.x * priors.width[i] + priors.x[i];
    const float height = std::exp(box[2] / scales.height) * priors.height[i];
    const float width = std::exp(box[3] / scales.width) * priors.width[i];
    const Candidate candidate{.x = (centre_x - width / 2) * picture_width,
                              .y = (centre_y - height / 2) * picture_height,
                              .width = width * picture_width,
                              .height = height * picture_height,
                              .score = sigmoid(best.score),
                              .class_index = best.class_index,
                              .row = static_cast<uint32_t>(i)};
    if (candidate.is_finite()) found.push_back(candidate);
  }
  return found;
}

size_t ssd_anchor_count(Size input) noexcept {
  constexpr size_t kOfFirst = 3, kOfOthers = 6;
  size_t count = 0;
  for_each_grid(input, [&](uint32_t grid, uint32_t columns, uint32_t rows) {
    count += size_t{columns} * rows * (grid == 0 ? kOfFirst : kOfOthers);
  });
  return count;
}

BoxPriors make_ssd_anchors(Size input) {
  BoxPriors out;
  for_each_grid(input, [&](uint32_t grid, uint32_t columns, uint32_t rows) {
    const auto sizes = make_sizes(grid);
    for (uint32_t y = 0; y < rows; ++y)
      for (uint32_t x = 0; x < columns; ++x)
        for (const AnchorSize& size : sizes) {
          out.y.push_back(static_cast<float>((y + 0.5) / rows));
          out.x.push_back(static_cast<float>((x + 0.5) / columns));
          out.height.push_back(static_cast<float>(size.height));
          out.width.push_back(static_cast<float>(size.width));
        }
  });
  return out;
}

std::vector<Anchor> make_palm_anchors(const PalmAnchorOptions& options) {
  std::vector<Anchor> anchors;
  const size_t layers = options.strides.size();
  for (size_t first = 0, end = 0; first < layers; first = end) {
    const uint32_t stride = options.strides[first];
    std::vector<float> scales;
    for (end = first; end < layers && options.strides[end] == stride; ++end)
      for (const size_t layer : {end, end + 1}) scales.push_back(get_scale(options, layer));
    add_grid(stride, scales, options, &anchors);
  }
  return anchors;
}

Candidates decode_palms(std::span<const float> boxes, std::span<const float> scores,
                        std::span<const Anchor> anchors, float threshold, Size picture) {
  constexpr float kMaxRaw = 100;
  const auto picture_width = static_cast<float>(picture.width);
  const auto picture_height = static_cast<float>(picture.height);
  Candidates found;
  for (size_t i = 0; i < scores.size(); ++i) {
    const float score = sigmoid(std::clamp(scores[i], -kMaxRaw, kMaxRaw));
    if (!(score >= threshold)) continue;
    const auto box = boxes.subspan(kPalmRow * i, 4);
    const Anchor& anchor = anchors[i];
    const float centre_y = box[0] / picture_height * anchor.height + anchor.y;
    const float centre_x = box[1] / picture_width * anchor.width + anchor.x;
    const float height = box[2] / picture_height * anchor.height;
    const float width = box[3] / picture_width * anchor.width;
    const Candidate candidate{.x = (centre_x - width / 2) * picture_width,
                              .y = (centre_y - height / 2) * picture_height,
                              .width = width * picture_width,
                              .height = height * picture_height,
                              .score = score,
                              .class_index = 0,
                              .row = static_cast<uint32_t>(i)};
    if (candidate.is_finite()) found.push_back(candidate);
  }
  return found;
}

}  // namespace weir::detection
