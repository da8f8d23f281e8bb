// Converts a frame of results to what is drawn on a picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>

#include "core/draw/detections.hpp"
#include "core/records/result_frame.hpp"
#include "core/tensor/geometry.hpp"
#include "weir/source_map.hpp"

namespace weir::records {

// Copies what is needed of the frame's tensors. `maps`: none, one, or one for each tensor; class
// maps are placed by theirs. Objects without a box are labels of their parent's box, or of the
// whole picture. Sources of names are those of the reader.
draw::Detections drawn_results(const ResultReader& reader, const ResultFrame& frame,
                               std::span<const SourceMap> maps);

// Over an upright part of the picture; of a map that is turned, the part around it. Without a
// source map, over all of the picture, whose sides may be unknown (0).
draw::ClassMap make_class_map(const ClassMapView& view, std::span<const SourceMap> maps,
                              Size picture);

}  // namespace weir::records
