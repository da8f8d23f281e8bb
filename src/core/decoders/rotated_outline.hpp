// Draws a rotated rectangle into a frame of another size than the model's input.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/detection/pixel_box.hpp"
#include "core/draw/rgba_frame.hpp"

namespace weir::decoders {

// The box has its centre at x, y; its corners are scaled from `input` to `output` and truncated to
// whole pixels.
void draw_rotated(const detection::PixelBox& box, detection::PictureSize input, draw::Size output,
                  draw::RgbaFrame* frame) noexcept;

}  // namespace weir::decoders
