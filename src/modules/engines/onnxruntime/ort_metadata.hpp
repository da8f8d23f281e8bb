// Returns the origin and metadata of an ONNX model as JSON.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "onnxruntime/onnx_file.hpp"
#include "onnxruntime/ort_api.hpp"

namespace weir::engine {

// {"producer":..., "producer_version":..., "graph":..., "domain":..., "description":...,
//  "model_version":N, "ir_version":N, "opset":{"ai.onnx":N}, "custom_metadata_map":{...}};
// empty texts are omitted.
std::string ort_metadata_json(const OrtRuntime& runtime, const OrtSession* session,
                              const OnnxSummary& summary);

}  // namespace weir::engine
