// Replaces the text painter in builds without Pango.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_overlay/text_painter.hpp"

namespace weir {

Result<std::unique_ptr<draw::TextPainter>> make_text_painter(uint32_t) {
  return Error{.code = Code::FILE_NOT_FOUND,
               .what = "this build cannot draw text",
               .offered = "built without Pango's headers",
               .needed = "Pango and Cairo",
               .fix =
                   "apt-get install libpango1.0-dev, then build again; or tensor_overlay "
                   "show-scores=false and no labels"};
}

}  // namespace weir
