// Estimates the work of one invoke of a TensorFlow Lite graph.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "tflite-file/tflite_graph.hpp"
#include "thread_rule.hpp"

namespace weir::engine {

// Counts float32 and int8 convolutions and matrix products, which XNNPACK runs on several threads;
// other operators and tensors with open shapes do not count.
Work tflite_work(const TfliteGraph& graph);

}  // namespace weir::engine
