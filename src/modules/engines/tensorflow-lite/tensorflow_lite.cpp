// TensorFlow Lite engine: the module's entry point.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tensorflow-lite/tflite_choice.hpp"
#include "tensorflow-lite/tflite_runner.hpp"
#include "weir/engine_table.hpp"

namespace weir::engine {
namespace {

struct TensorflowLiteEngine {
  static constexpr const char *kName = "tensorflow-lite",
                              *kAliases = "tensorflow2-lite,tensorflow1-lite,tflite",
                              *kExtensions = "tflite", *kLibrary = "TensorFlow Lite";
  static constexpr const char* kAccelerators = "cpu,cpu.simd";
  static constexpr const char* kOptions = R"([
    {"name": "NumThreads", "type": "integer", "default": "by the size of the model", "help": "threads of one invoke"},
    {"name": "Delegate", "type": "XNNPACK|None", "default": "XNNPACK", "help": "what runs the operators"},
    {"name": "Resize", "type": "true|false|rank", "default": "false",
     "help": "inputs have the stream's shape even if the file has a fixed one; rank: also another number of dimensions"},
    {"name": "Lowering", "type": "onnxruntime|None", "default": "None",
     "help": "a quantised graph is translated for ONNX Runtime; results differ by a few steps"}])";
  using Model = TfliteModel;
  using Session = TfliteRunner;

  static int probe(const std::string&, std::span<const unsigned char> head) {
    return tflite_score(head);
  }
  static Result<LibraryFacts> library() {
    const auto api = TfliteApi::instance();
    if (!api) return api.error();
    return LibraryFacts{(*api)->path, (*api)->version_text};
  }
  static weir_engine around(const weir_engine& own) { return choosing_table(own); }
};

}  // namespace
}  // namespace weir::engine

WEIR_ENGINE_MODULE(weir::engine::TensorflowLiteEngine)
