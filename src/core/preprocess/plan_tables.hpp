// PlanTables: what a plan knows before the first frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <vector>

#include "core/preprocess/axis.hpp"
#include "core/preprocess/block_sums.hpp"
#include "core/preprocess/pair_columns.hpp"
#include "core/preprocess/placement.hpp"
#include "core/preprocess/row_kernels.hpp"
#include "core/preprocess/row_memory.hpp"

namespace weir::preprocess {

// How each target pixel of `area` is made of whole blocks of so many samples, which BlockSums adds
// up for all layers; 1: it is not. Of so many rows at once, where that changes no number.
struct GridSums {
  size_t block = 1, rows = 1;
  bool whole = false;  // each target pixel is one block: nothing is to be gathered
  // Whether a pixel is the sum of so few samples that 2 to the power of `shift` of it are
  // kSampleScale times their mean in 16 bits, as pairs are.
  bool few = false;
  unsigned shift = 0;
  // By what the last pixel of a row is multiplied that was made of co-sited blocks: a quarter of a
  // sample is not there.
  float last_scale = 1;
};

// Planes that are sampled alike: what the pixels of the target are made of.
struct Grid {
  Lane sampling;
  size_t first_byte = 0, bytes = 0;  // of each row, what is read
  Axis rows, columns;
  // Whether a target pixel is made of no more than two rows and two samples of each. Then the
  // columns are `pairs`, else `index` and `weights`, which are those of tap_kernels.hpp.
  bool paired = false;
  PairColumns pairs;
  size_t taps = 0;
  RowMemory<int32_t> index;
  RowMemory<float> weights;
  GridSums sums;  // where a block is of several samples, index and weights are of blocks
  uint32_t low = 0, high = 0;  // the samples of a row that are read
  bool cosited = false;        // the columns' samples, of two pixels each

  SummedSamples summed(size_t plane) const noexcept {
    return {plane, low, high, sampling.step, cosited};
  }
  // The lanes of 16 bits that a pixel's samples have, kSampleScale times the value; 0: they are
  // floats.
  size_t lanes() const noexcept {
    return paired ? pair_lanes(sampling.step) : sums.few ? sampling.step : 0;
  }
};

struct Band {
  uint8_t plane = 0;
  size_t grid = 0;
};

struct LaneSource {
  size_t band = 0, offset = 0;  // offset: bytes, from the beginning of a sample of the band
};

struct PlanTables {
  explicit PlanTables(Preparation preparation);

  // Precondition: check_crop(). Keeps the memory of the tables, and all that no crop changes.
  void set_crop(const Rect& crop);
  // The same of a region that place() shows something of.
  void set_region(const Rect& picture, const Box& region);

  Preparation preparation;
  Placement placement;
  std::vector<Grid> grids;
  std::vector<Band> bands;
  std::vector<LaneSource> lanes;  // the samples that the target needs: 1 or 3
  ColorTransform colors;
  std::array<size_t, 3> lane_of_sample{0, 1, 2};  // of the transform
  std::vector<NumberRule> numbers;                // by channel of the target
  std::vector<std::byte> padding;  // NHWC: one row of pixels; NCHW: one row for each channel

 private:
  size_t grid_of(const Lane& lane, size_t known);
  void lay_colors();
  void lay_bands();
};

}  // namespace weir::preprocess
