// The sticky event "weir-model", with which tensor_filter describes its model downstream.
//
//   weir-model, version=(uint)1, path=(string)/models/yolo.onnx, metadata=(string)"{...}",
//     inputs=<tensor>, outputs=<tensor, ...>
// with for each tensor the structure
//   tensor, type=(string)int8, shape=<1, 84, 8400>, name=(string)output0, scale=(double)0.1,
//     zero-point=(int)-3
// Shapes are outermost first, -1 = not known; an unknown type is "". Elements that change tensors
// drop the event.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <optional>

#include "core/filter/described_model.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::gst {

// The version is part of the event: a later one that this one cannot read has another number.
Ref<GstEvent> make_model_event(const DescribedModel& model);

bool is_model_event(GstEvent* event) noexcept;

// nullopt for another event, another version, or contents that are not as described above. Any
// element may have made the event: numbers of tensors, ranks and texts are bounded.
std::optional<DescribedModel> parse_model_event(GstEvent* event);

// The model of the stream that arrives at `pad`: of its sticky event; nullopt without one.
std::optional<DescribedModel> find_model(GstPad* pad);

}  // namespace weir::gst
