// Creates the painter of label texts, which uses Pango and Cairo.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <memory>

#include "core/draw/labels.hpp"
#include "weir/result.hpp"

namespace weir {

// `size`: font size in pixels. The first call loads the libraries. FILE_NOT_FOUND: a library or
// every font is missing. The painter is for one thread at a time.
Result<std::unique_ptr<draw::TextPainter>> make_text_painter(uint32_t size);

}  // namespace weir
