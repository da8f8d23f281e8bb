// What one invoke of a TensorFlow Lite graph computes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "tflite-file/tflite_graph.hpp"
#include "thread_rule.hpp"

namespace weir::engine {

// Convolutions and matrix products of float32 and int8 numbers, which XNNPACK runs on several
// threads; others, and tensors whose shape is open, do not count.
Work tflite_work(const TfliteGraph& graph);

}  // namespace weir::engine
