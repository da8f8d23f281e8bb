// The module of the engine ONNX Runtime.
#include "engine_table.hpp"
#include "onnxruntime/ort_model.hpp"
#include "onnxruntime/ort_runner.hpp"

namespace weir::engine {
namespace {

struct OnnxRuntimeEngine {
  using Model = OrtModel;
  using Session = OrtRunner;

  static int probe(const std::string&, std::span<const unsigned char> head) {
    return onnx_score(head);
  }
  // "weir.library/1": const char* const[2] = path and version of the engine's library; null when
  // it is not installed.
  static const void* extension(const char* id) {
    if (!id || std::string_view(id) != "weir.library/1") return nullptr;
    const auto runtime = OrtRuntime::instance();
    if (!runtime) return nullptr;
    static const std::string path = (*runtime)->path(), version = (*runtime)->version();
    static const char* const library[] = {path.c_str(), version.c_str()};
    return library;
  }
};

}  // namespace
}  // namespace weir::engine

extern "C" __attribute__((visibility("default"))) const weir_module* weir_module_entry(
    const weir_host* host) {
  using namespace weir::engine;
  if (!weir::accept_host(host)) return nullptr;
  module_name = "onnxruntime";
  static const weir_engine engine =
      EngineTable<OnnxRuntimeEngine>::make("onnxruntime", "1", "onnx", "onnx,ort");
  static const weir_engine* const engines[] = {&engine, nullptr};
  static const weir_module module{sizeof(weir_module),
                                  WEIR_ABI_MAJOR,
                                  WEIR_ABI_MINOR,
                                  engines,
                                  nullptr,
                                  nullptr,
                                  nullptr,
                                  nullptr};
  return &module;
}
