// The table of engines (docs/compatibility/filter.md 4.2 lists the extensions).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/known_engines.hpp"

#include <algorithm>
#include <array>

#include "core/text/text.hpp"

namespace weir::infer {
namespace {

constexpr std::string_view kOpencvInstall = "apt-get install libopencv-dnn-dev";

constexpr std::array kEngines{
    KnownEngine{"onnxruntime", "onnx", "onnx", "tools/setup --engine onnxruntime"},
    KnownEngine{"tensorflow-lite", "tensorflow2-lite,tensorflow1-lite,tflite", "tflite",
                "tools/setup --engine tensorflow-lite"},
    KnownEngine{"tensorflow", "", "pb", kOpencvInstall},
    KnownEngine{"pytorch", "torch,libtorch", "pt,pth,torchscript",
                "apt-get install libtorch-dev libopenblas0-pthread"},
    KnownEngine{"caffe", "", "caffemodel,prototxt", kOpencvInstall},
    KnownEngine{"darknet", "", "weights,cfg", kOpencvInstall},
    KnownEngine{"python3", "python", "py", "apt-get install libpython3.11 python3-numpy"},
    KnownEngine{"lua", "", "lua", "apt-get install libluajit-5.1-2"},
    KnownEngine{"oip", "", "", "apt-get install libgrpc++-dev"},
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
    KnownEngine{"caffe2", "", "", ""},
    KnownEngine{"armnn", "", "", ""},
    KnownEngine{"edgetpu", "", "", ""},
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

std::vector<std::string_view> preferred_engines(std::string_view extension) {
  if (extension == "tflite") return {"tensorflow-lite", "nnfw", "armnn", "edgetpu"};
  return {};
}

const KnownEngine* known_engine_for(std::string_view extension) noexcept {
  for (const auto& engine : kEngines)
    if (lists(engine.extensions, extension)) return &engine;
  return nullptr;
}

}  // namespace weir::infer
