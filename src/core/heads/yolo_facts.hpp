// What the outputs of a YOLO model can be, and what speaks for it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string_view>

#include "core/heads/dense_head.hpp"

namespace weir::heads {

inline constexpr size_t kBoxValues = 4, kCocoClasses = 80;

// The outputs of a detector of cells: rows, and prototype masks if there are two.
struct YoloOutputs {
  size_t output = 0;
  DenseLayout layout;
  std::optional<PrototypeFacts> prototypes{};
};
// nullopt if the outputs are not one of rows with `anchors` a cell, with or without prototypes.
std::optional<YoloOutputs> find_yolo_outputs(const ModelFacts& model, size_t anchors,
                                             bool has_prototypes);
// For a family that the user named: rows whose number no grid explains too.
std::optional<YoloOutputs> any_yolo_outputs(const ModelFacts& model, bool has_prototypes);

// Whether the model's metadata says that it is for `task` (detect, segment, pose, obb, as
// Ultralytics writes it); nullopt if it reports nothing.
std::optional<bool> is_for_task(const ModelFacts& model, std::string_view task);

// Numbers of key points of the model's metadata: "[17, 3]".
struct PointShape {
  size_t points = 0, length = 3;
};
std::optional<PointShape> point_shape(const ModelFacts& model);

}  // namespace weir::heads
