// The text of labels, painted by Pango and Cairo.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <memory>

#include "core/draw/labels.hpp"
#include "weir/result.hpp"

namespace weir {

// `size`: of the font, pixels. The libraries are opened when the first painter is made.
// FILE_NOT_FOUND: they, or any font at all, are not there. Of one thread at a time.
Result<std::unique_ptr<draw::TextPainter>> make_text_painter(uint32_t size);

}  // namespace weir
