// The module of the engine TensorFlow Lite.
#include "engine_table.hpp"
#include "tensorflow-lite/tflite_runner.hpp"

namespace weir::engine {
namespace {

struct TensorflowLiteEngine {
  using Model = TfliteModel;
  using Session = TfliteRunner;

  static int probe(const std::string&, std::span<const unsigned char> head) {
    return tflite_score(head);
  }
  // "weir.library/1": const char* const[2] = path and version of the engine's library; null when
  // it is not installed.
  static const void* extension(const char* id) {
    if (!id || std::string_view(id) != "weir.library/1") return nullptr;
    const auto api = TfliteApi::instance();
    if (!api) return nullptr;
    static const char* const library[] = {(*api)->path.c_str(), (*api)->version_text.c_str()};
    return library;
  }
};

}  // namespace
}  // namespace weir::engine

extern "C" __attribute__((visibility("default"))) const weir_module* weir_module_entry(
    const weir_host* host) {
  using namespace weir::engine;
  if (!weir::accept_host(host)) return nullptr;
  module_name = "tensorflow-lite";
  static const weir_engine engine = EngineTable<TensorflowLiteEngine>::make(
      "tensorflow-lite", "1", "tensorflow2-lite,tensorflow1-lite,tflite", "tflite");
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
