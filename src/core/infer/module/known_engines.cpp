// The table of engines (docs/compatibility/filter.md 4.2 lists the extensions).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/known_engines.hpp"

#include <algorithm>
#include <array>

#include "core/text/text.hpp"
#include "machine/install_command.hpp"

namespace weir::infer {
namespace {

constexpr std::string_view kOpencvInstall = install_command(
    "apt-get install gstreamer1.0-weir-opencv", "apt-get install libopencv-dnn-dev && make build");

// What runs the same network, for engines that Weir has no module for.
constexpr std::string_view kOnnx = "the model as .onnx, with framework=onnxruntime";
constexpr std::string_view kTflite = "the model as .tflite, with framework=tensorflow-lite";
constexpr std::string_view kOnnxOrTflite =
    "the .onnx or .tflite file that the model was compiled from";
constexpr std::string_view kTorchScript = "the model as TorchScript, with framework=pytorch";

constexpr std::array kEngines{
    KnownEngine{"onnxruntime", "onnx", "onnx",
                install_command("apt-get install gstreamer1.0-weir-onnxruntime",
                                "tools/setup --engine onnxruntime && make build")},
    KnownEngine{"tensorflow-lite", "tensorflow2-lite,tensorflow1-lite,tflite", "tflite",
                install_command("apt-get install gstreamer1.0-weir-tensorflow-lite",
                                "tools/setup --engine tensorflow-lite && make build")},
    KnownEngine{"tensorflow", "", "pb", kOpencvInstall},
    KnownEngine{"pytorch", "torch,libtorch", "pt,pth,torchscript",
                install_command("apt-get install gstreamer1.0-weir-pytorch",
                                "apt-get install libtorch-dev libopenblas0-pthread && make build")},
    KnownEngine{"caffe", "", "caffemodel,prototxt", kOpencvInstall},
    KnownEngine{"darknet", "", "weights,cfg", kOpencvInstall},
    KnownEngine{"python3", "python", "py",
                install_command("apt-get install gstreamer1.0-weir-python3",
                                "apt-get install libpython3-dev python3-numpy && make build")},
    KnownEngine{"lua", "", "lua",
                install_command("apt-get install gstreamer1.0-weir libluajit-5.1-2",
                                "apt-get install libluajit-5.1-2 && make build")},
    KnownEngine{"oip", "", "",
                install_command("apt-get install gstreamer1.0-weir-net",
                                "apt-get install libgrpc++-dev && make build")},
    KnownEngine{"custom", "", "so", ""},
    KnownEngine{"custom-easy", "", "", ""},
    KnownEngine{"cpp", "", "", ""},
    // NNStreamer's, which Weir has no module for.
    KnownEngine{"snpe", "", "dlc", "", kOnnxOrTflite},
    KnownEngine{"movidius-ncsdk2", "", "graph", "", kOnnxOrTflite},
    KnownEngine{"nntrainer", "", "ini", "", ""},
    KnownEngine{"nnfw", "", "circle", "", kTflite},
    KnownEngine{"openvino", "", "bin,xml", "", kOnnx},
    KnownEngine{"trix-engine", "srnpu", "tvn", "", kOnnxOrTflite},
    KnownEngine{"vivante", "", "nb", "", kOnnxOrTflite},
    KnownEngine{"caffe2", "", "", "", kOnnx},
    KnownEngine{"armnn", "", "", "", kTflite},
    KnownEngine{"edgetpu", "", "", "", kTflite},
    KnownEngine{"llamacpp", "", "gguf", "", ""},
    KnownEngine{"llama2c", "", "", "", ""},
    KnownEngine{"executorch", "", "pte", "", kTorchScript},
    KnownEngine{"executorch-llama", "", "", "", ""},
    KnownEngine{"ncnn", "", "", "", kOnnx},
    KnownEngine{"tvm", "", "", "", kOnnx},
    KnownEngine{"tensorrt", "", "uff", "", kOnnx},
    KnownEngine{"tensorrt10", "", "", "", kOnnx},
    KnownEngine{"qnn", "", "", "", kOnnxOrTflite},
    KnownEngine{"mxnet", "", "", "", kOnnx},
    KnownEngine{"mediapipe", "", "", "", kTflite},
    KnownEngine{"deepview-rt", "", "", "", kOnnxOrTflite},
    KnownEngine{"snap", "", "", "", kOnnxOrTflite},
    KnownEngine{"tizen-hal", "", "", "", kOnnxOrTflite},
    KnownEngine{"dali", "", "", "", ""},
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
