// PlanTables: what a plan knows before the first frame.
#pragma once
#include <vector>

#include "core/preprocess/axis.hpp"
#include "core/preprocess/placement.hpp"
#include "core/preprocess/row_kernels.hpp"

namespace weir::preprocess {

// One plane: its rows are blended to one row of float, of which the target's columns are gathered.
struct Band {
  uint8_t plane = 0;
  size_t first_byte = 0, bytes = 0;  // of each row
  Axis rows, columns;
  // The columns by tap, then by target column: which element of the blended row, and its weight.
  size_t taps = 0;
  std::vector<int32_t> index;
  std::vector<float> weights;
};

struct LaneSource {
  size_t band = 0, offset = 0;  // offset is added to the band's index
};

struct PlanTables {
  explicit PlanTables(Preparation preparation);

  // Precondition: check_crop(). Keeps the memory of the tables, and all that no crop changes.
  void set_crop(const Rect& crop);

  Preparation preparation;
  Placement placement;
  std::vector<Band> bands;
  std::vector<LaneSource> lanes;  // the samples that the target needs: 1 or 3
  ColorTransform colors{};        // of Y'CbCr
  float gray_factor = 1, gray_add = 0;
  std::vector<NumberRule> numbers;  // by channel of the target
  std::vector<std::byte> padding;   // NHWC: one row of pixels; NCHW: one row for each channel

 private:
  void lay_bands();
};

}  // namespace weir::preprocess
