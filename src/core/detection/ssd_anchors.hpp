// The anchors of SSD MobileNet, from the description of the network (Liu et al., 2016).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/detection/ssd_priors.hpp"

namespace weir::detection {

// Six grids of ceil(input / 16) cells and half as many each, rounded up; scales from 0.2 to 0.95.
// Each cell has 6 anchors of the ratios 1, 2, 1/2, 3, 1/3 and 1, those of the first grid 3. Grids,
// rows, columns, then anchors.
BoxPriors make_ssd_anchors(PictureSize input);
// Their number.
size_t ssd_anchor_count(PictureSize input) noexcept;

}  // namespace weir::detection
