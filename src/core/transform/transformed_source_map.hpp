// transform_source_map: the source map after a transform.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/transform/transform.hpp"
#include "weir/source_map.hpp"

namespace weir::transform {

// The source map of the output of `operation`. Transpositions move the dimensions of x and y, and
// padding moves the picture within the tensor. Other operations do not change it.
SourceMap transform_source_map(const Operation& operation, const SourceMap& in);

}  // namespace weir::transform
