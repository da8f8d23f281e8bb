// The table of engines (specification 4.2: the extensions; engines.md: how they are had).
#include "core/infer/known_engines.hpp"

#include <algorithm>
#include <array>

#include "core/text/text.hpp"

namespace weir::infer {
namespace {

constexpr std::array kEngines{
    KnownEngine{"onnxruntime", "onnx", "onnx", "tools/setup --engine onnxruntime"},
    KnownEngine{"tensorflow-lite", "tensorflow2-lite,tensorflow1-lite,tflite", "tflite",
                "tools/setup --engine tensorflow-lite"},
    KnownEngine{"tensorflow", "", "pb", ""},
    KnownEngine{"pytorch", "", "pt", ""},
    KnownEngine{"caffe", "", "caffemodel,prototxt", ""},
    KnownEngine{"python3", "python", "py", ""},
    KnownEngine{"lua", "", "lua", ""},
    KnownEngine{"custom", "", "so", ""},
    KnownEngine{"custom-easy", "", "", ""},
    KnownEngine{"cpp", "", "", ""},
    KnownEngine{"snpe", "", "dlc", ""},
    KnownEngine{"movidius-ncsdk2", "", "graph", ""},
    KnownEngine{"nntrainer", "", "ini", ""},
    KnownEngine{"nnfw", "", "circle", ""},
    KnownEngine{"openvino", "", "bin,xml", ""},
    KnownEngine{"trix-engine", "srnpu", "tvn", ""},
    KnownEngine{"vivante", "", "nb", ""},
    KnownEngine{"llamacpp", "", "gguf", ""},
};

bool lists(std::string_view list, std::string_view word) {
  const auto parts = split(list, ",");
  return !word.empty() && std::find(parts.begin(), parts.end(), word) != parts.end();
}

}  // namespace

std::span<const KnownEngine> known_engines() noexcept {
  return kEngines;
}

const KnownEngine* known_engine(std::string_view word) noexcept {
  for (const auto& engine : kEngines)
    if (engine.name == word || lists(engine.aliases, word)) return &engine;
  return nullptr;
}

const KnownEngine* known_engine_for(std::string_view extension) noexcept {
  for (const auto& engine : kEngines)
    if (lists(engine.extensions, extension)) return &engine;
  return nullptr;
}

}  // namespace weir::infer
