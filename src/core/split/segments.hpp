// Segments: how one tensor is cut into several, in a line or along one of its dimensions.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "weir/picture_map.hpp"
#include "weir/result.hpp"

namespace weir {

struct SplitRequest {
  std::vector<Shape> segments;      // tensorseg
  std::vector<size_t> picks;        // segments that leave, in any order; empty: all
  std::optional<size_t> dimension;  // to cut along, 0 is the innermost; none: in a line
  uint32_t parts = 0;               // so many equal segments along `dimension`; 0: as `segments`
};

// "3:4:1,3:4:2": dimensions as in caps, each entry at least 1; of a cut along a dimension also the
// sizes along it alone: "1,2". What cannot be read is an error that shows its place.
Result<std::vector<Shape>> parse_segments(std::string_view text);

// `blocks` runs of `block_bytes`, the first at `offset`, one every `step_bytes` of the input.
struct Segment {
  size_t index = 0;  // of all, picked or not
  TensorSpec spec;
  size_t offset = 0, block_bytes = 0, step_bytes = 0, blocks = 1;
  // The part of the input's dimension that it is; none when it is no part of one.
  struct Part {
    size_t dimension = 0;
    uint32_t from = 0, extent = 0;
  };
  std::optional<Part> part;

  bool dense() const noexcept { return blocks == 1; }  // it can be shared as it lies
};

struct SplitPlan {
  TensorSpec input;
  std::vector<Segment> segments;   // those picked, by ascending index
  std::optional<Error> left_over;  // a part of the tensor that is in no segment, as a warning
};

// Segments beyond the tensor are an error that names the first and both sums.
Result<SplitPlan> plan_split(const SplitRequest& request, const TensorSpec& input);

// Gathers the segment out of the input's bytes. `out` has the segment's size.
void copy_segment(const Segment& segment, std::span<const std::byte> in, std::span<std::byte> out);

// The ways back of a segment, from those of the whole tensor; none where it is no part of the
// picture. `of_regions`: they are those of a batch, one for each index of its outermost dimension.
std::vector<PictureMap> maps_of(const Segment& segment, const TensorSpec& input,
                                std::span<const PictureMap> maps, bool of_regions);

}  // namespace weir
