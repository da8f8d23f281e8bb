// The scheme of bounding_boxes for MediaPipe's palm detector.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "core/decoders/box_scheme.hpp"

namespace weir::decoders {

std::unique_ptr<BoxScheme> open_palm(const SchemeOptions& options);

}  // namespace weir::decoders
