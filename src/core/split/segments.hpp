// Segments: cuts one tensor into several, linearly or along one of its dimensions.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "weir/result.hpp"
#include "weir/source_map.hpp"

namespace weir {

struct SplitRequest {
  std::vector<Shape> segments;      // tensorseg
  std::vector<size_t> picks;        // segments to output, in any order; empty: all
  std::optional<size_t> dimension;  // to cut along, 0 is the innermost; none: linearly
  uint32_t parts = 0;               // number of equal segments along `dimension`; 0: use `segments`
};

// "3:4:1,3:4:2": dimensions as in caps, each at least 1. For a cut along a dimension, its sizes
// alone are enough: "1,2". Unreadable text is an error with its position.
Result<std::vector<Shape>> parse_segments(std::string_view text);

// `blocks` runs of `block_bytes`: the first at `offset`, then one every `step_bytes` of the input.
struct Segment {
  size_t index = 0;  // among all segments, picked or not
  TensorSpec spec;
  size_t offset = 0, block_bytes = 0, step_bytes = 0, blocks = 1;
  // The part of the input's dimension that the segment covers; none if it is not such a part.
  struct Part {
    size_t dimension = 0;
    uint32_t from = 0, extent = 0;
  };
  std::optional<Part> part;

  bool dense() const noexcept { return blocks == 1; }  // contiguous: can be shared without a copy
};

struct SplitPlan {
  TensorSpec input;
  std::vector<Segment> segments;   // the picked ones, by ascending index
  std::optional<Error> left_over;  // a warning about a part of the tensor that is in no segment
};

// If segments exceed the tensor, the error names the first such segment and both sums.
Result<SplitPlan> plan_split(const SplitRequest& request, const TensorSpec& input);

// Copies the segment from the input's bytes. `out` has the segment's size.
void copy_segment(const Segment& segment, std::span<const std::byte> in, std::span<std::byte> out);

// The source maps of a segment, derived from those of the whole tensor; empty if it is not a part
// of the picture. `of_regions`: they belong to a batch, one for each index of its outermost
// dimension.
std::vector<SourceMap> make_source_maps(const Segment& segment, const TensorSpec& input,
                                        std::span<const SourceMap> maps, bool of_regions);

}  // namespace weir
