// ONNX Runtime engine: the module's entry point.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "onnxruntime/ort_model.hpp"
#include "onnxruntime/ort_runner.hpp"
#include "tflite-file/tflite_file.hpp"
#include "weir/engine_table.hpp"

namespace weir::engine {
namespace {

struct OnnxRuntimeEngine {
  static constexpr const char *kName = "onnxruntime", *kAliases = "onnx", *kExtensions = "onnx,ort",
                              *kLibrary = "ONNX Runtime";
  static constexpr const char* kOptions = R"([
    {"name": "NumThreads", "type": "integer", "default": "for the only filter of the process all cores, or one for a small model; otherwise its part of them", "help": "threads of one invoke"},
    {"name": "GraphOptimization", "type": "none|basic|extended|all", "default": "all",
     "help": "graph optimization level of ONNX Runtime"},
    {"name": "Spinning", "type": "boolean", "default": "true for the only filter of the process, otherwise false",
     "help": "threads busy-wait between two operators"},
    {"name": "session.*", "type": "text", "default": "", "help": "an entry of the session configuration"}])";
  using Model = OrtModel;
  using Session = OrtRunner;

  static int probe(const std::string&, std::span<const unsigned char> head) {
    constexpr int kLowered = 40;  // less than TensorFlow Lite, for which such files are made
    return tflite_score(head) > 0 ? kLowered : onnx_score(head);
  }
  static Result<LibraryFacts> library() {
    const auto runtime = OrtRuntime::instance();
    if (!runtime) return runtime.error();
    return LibraryFacts{(*runtime)->path(), (*runtime)->version()};
  }
};

}  // namespace
}  // namespace weir::engine

WEIR_ENGINE_MODULE(weir::engine::OnnxRuntimeEngine)
