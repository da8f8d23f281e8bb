// The module of the engine ONNX Runtime.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "engine_table.hpp"
#include "onnxruntime/ort_model.hpp"
#include "onnxruntime/ort_runner.hpp"
#include "tflite-file/tflite_file.hpp"

namespace weir::engine {
namespace {

struct OnnxRuntimeEngine {
  static constexpr const char *kName = "onnxruntime", *kAliases = "onnx", *kEndings = "onnx,ort",
                              *kLibrary = "ONNX Runtime";
  static constexpr const char* kOptions = R"([
    {"name": "NumThreads", "type": "integer", "default": "all cores for the only filter of the process, else its share", "help": "threads of one invoke"},
    {"name": "GraphOptimization", "type": "none|basic|extended|all", "default": "all",
     "help": "how far ONNX Runtime rewrites the graph"},
    {"name": "Spinning", "type": "boolean", "default": "true for the only filter of the process, else false",
     "help": "between two operators threads wait without sleeping"},
    {"name": "LoweringCache", "type": "boolean", "default": "true",
     "help": "graphs of .tflite models, once translated, are kept in ~/.cache/weir"},
    {"name": "session.*", "type": "text", "default": "", "help": "an entry of the session's configuration"}])";
  using Model = OrtModel;
  using Session = OrtRunner;

  static int probe(const std::string&, std::span<const unsigned char> head) {
    constexpr int kLowered = 40;  // less than the engine that such files are made for
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
