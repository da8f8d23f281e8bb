// Masks as the run-length code (RLE) of COCO: the lengths of runs of pixels that are not set and
// that are set, in turn, down the columns of the picture from left to right.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/records/result_frame.hpp"

namespace weir::records {

// Whether a picture has a code: it has pixels, and no more than 2^28.
constexpr bool has_run_lengths(uint32_t width, uint32_t height) noexcept {
  return width > 0 && height > 0 && uint64_t{width} * height <= uint64_t{1} << 28;
}

using RunLengths = std::vector<uint32_t>;

// The pixels of a picture of width * height where the mask over `box` is 128 or more (nearest
// neighbour). Precondition: has_run_lengths(), a finite box.
RunLengths runs_of_mask(const MaskView& mask, const Box& box, uint32_t width, uint32_t height);

struct ClassRuns {
  uint32_t class_index = 0;
  RunLengths runs;
};
// The pixels of each class in a picture of width * height, by the map from the class map to the
// picture. Pixels outside of the class map have no class. Classes in ascending order.
// Precondition: has_run_lengths().
std::vector<ClassRuns> runs_of_classes(const ClassMapView& classes, const SourceMap& map,
                                       uint32_t width, uint32_t height);

// The text of a code in files of COCO: differences to the run before the last one, in characters
// of 6 bits from '0' on.
std::string to_string(const RunLengths& runs);
// The runs of such a text. nullopt if it is damaged or its runs are not `pixels` in sum.
std::optional<RunLengths> runs_of_text(std::string_view text, uint64_t pixels);

}  // namespace weir::records
