// Estimates the work of one invoke of a TensorFlow Lite graph.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "tflite-file/tflite_graph.hpp"
#include "thread_rule.hpp"

namespace weir::engine {

// Counts float32 and int8 convolutions and matrix products, which XNNPACK runs on several threads;
// other operators and tensors with open shapes do not count.
Work tflite_work(const TfliteGraph& graph);

// Whether XNNPACK can run at least one of the convolutions and matrix products, or there are none.
// It does not speed up a graph in which all of them are uint8.
bool suits_xnnpack(const TfliteGraph& graph);

}  // namespace weir::engine
