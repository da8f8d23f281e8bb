// Reads prior boxes and decodes SSD heads with them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/ssd_priors.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "core/detection/best_class.hpp"
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
                  float threshold, PictureSize picture, SsdClass choice) {
  const auto picture_width = static_cast<float>(picture.width);
  const auto picture_height = static_cast<float>(picture.height);
  const float least = logit(threshold);
  Candidates found;
  for (size_t i = 0; i < head.scores.size() / head.classes; ++i) {
    const auto best =
        find_class(head.scores.subspan(i * head.classes, head.classes), least, choice);
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
                              .score = 1 / (1 + std::exp(-best.score)),
                              .class_index = best.class_index,
                              .row = static_cast<uint32_t>(i)};
    if (candidate.is_finite()) found.push_back(candidate);
  }
  return found;
}

}  // namespace weir::detection
