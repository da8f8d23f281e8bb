// SSD models whose boxes are relative to prior boxes, which a text file lists.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string_view>
#include <vector>

#include "core/detection/candidate.hpp"
#include "weir/result.hpp"

namespace weir::detection {

// Prior boxes as parts of the picture: one value in each list for every anchor.
struct BoxPriors {
  std::vector<float> y, x;  // of the centre
  std::vector<float> height, width;
  size_t size() const noexcept { return y.size(); }
};

// Reads four lines (y, x, height, width) of as many values each, separated by blanks, tabs or
// commas. OPTION_SYNTAX without `offered` that names the line.
Result<BoxPriors> parse_box_priors(std::string_view text);

struct SsdHead {
  std::span<const float> boxes;   // y, x, height, width of each anchor
  std::span<const float> scores;  // logits, `classes` of each anchor; class 0 is the background
  size_t classes = 0;
};
// What the values of boxes are divided by.
struct SsdScales {
  float y = 10, x = 10, height = 5, width = 5;
};

// Which class of an anchor is taken.
enum class SsdClass {
  Best,
  First  // the first whose score reaches the threshold
};

// Returns one candidate for each anchor with a class whose probability is at least `threshold`.
// Boxes that are not finite are left out. Preconditions: as many boxes as anchors and at least as
// many priors; classes > 0.
Candidates decode(const SsdHead& head, const BoxPriors& priors, const SsdScales& scales,
                  float threshold, PictureSize picture, SsdClass choice = SsdClass::Best);

}  // namespace weir::detection
