// Detectors whose boxes are relative to anchors: SSD, with prior boxes of a file or of SSD
// MobileNet, and MediaPipe's palm detector.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "core/detection/candidate.hpp"
#include "core/tensor/geometry.hpp"
#include "weir/result.hpp"

namespace weir::detection {

// SSD models whose boxes are relative to prior boxes, which a text file lists.

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
                  float threshold, Size picture, SsdClass choice = SsdClass::Best);

// The anchors of SSD MobileNet, from the description of the network (Liu et al., 2016).

// Six grids of ceil(input / 16) cells and half as many each, rounded up; scales from 0.2 to 0.95.
// Each cell has 6 anchors of the ratios 1, 2, 1/2, 3, 1/3 and 1, those of the first grid 3. Grids,
// rows, columns, then anchors.
BoxPriors make_ssd_anchors(Size input);
// Their number.
size_t ssd_anchor_count(Size input) noexcept;

// MediaPipe's palm detector: its anchors and its head, which is relative to them.

// Parts of the picture: centre and size.
struct Anchor {
  float x = 0, y = 0, width = 0, height = 0;
  bool operator==(const Anchor&) const = default;
};

struct PalmAnchorOptions {
  float min_scale = 1, max_scale = 1;
  float x_offset = 0.5f, y_offset = 0.5f;        // of a cell's centre, in cells
  std::vector<uint32_t> strides{8, 16, 16, 16};  // pixels of a cell, of each layer; above 0
};

// The anchors of a grid over 192 x 192 pixels. Adjacent layers of the same stride share a grid:
// each of its cells, row by row, has two anchors for every layer.
std::vector<Anchor> make_palm_anchors(const PalmAnchorOptions& options);

inline constexpr size_t kPalmRow = 18;  // y, x, height, width, then 7 key points

// Returns the anchors with a probability of at least `threshold`, in their order; class 0. Boxes
// that are not finite are left out. Preconditions: kPalmRow values in `boxes` for each score, and
// at least as many anchors.
Candidates decode_palms(std::span<const float> boxes, std::span<const float> scores,
                        std::span<const Anchor> anchors, float threshold, Size picture);

}  // namespace weir::detection
