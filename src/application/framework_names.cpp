// Maps the numbers of the C API to names of engines and accelerators.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework_names.hpp"

#include <array>
#include <filesystem>
#include <utility>

namespace weir::application {

std::optional<std::string> framework_name(ml_nnfw_type_e type, const std::string& model) {
  constexpr std::array kNames{"",
                              "custom-easy",
                              "tensorflow-lite",
                              "tensorflow",
                              "nnfw",
                              "movidius-ncsdk2",
                              "openvino",
                              "vivante",
                              "edgetpu",
                              "armnn",
                              "snpe",
                              "pytorch",
                              "trix-engine",
                              "tvm",
                              "onnxruntime",
                              "ncnn",
                              "tensorrt",
                              "executorch"};
  static_assert(kNames.size() == ML_NNFW_TYPE_EXECUTORCH + 1);
  const auto number = static_cast<size_t>(type);
  if (number >= kNames.size()) return std::nullopt;
  std::error_code ignored;
  if (type == ML_NNFW_TYPE_CUSTOM_FILTER && std::filesystem::is_regular_file(model, ignored))
    return "custom";
  return kNames[number];
}

std::optional<std::string> accelerator_name(ml_nnfw_hw_e hardware) {
  constexpr std::pair<ml_nnfw_hw_e, const char*> kNames[]{{ML_NNFW_HW_ANY, ""},
                                                          {ML_NNFW_HW_AUTO, "auto"},
                                                          {ML_NNFW_HW_DEFAULT, ""},
                                                          {ML_NNFW_HW_CPU, "cpu"},
                                                          {ML_NNFW_HW_CPU_SIMD, "cpu.simd"},
                                                          {ML_NNFW_HW_GPU, "gpu"},
                                                          {ML_NNFW_HW_NPU, "npu"},
                                                          {ML_NNFW_HW_NPU_MOVIDIUS, "npu.movidius"},
                                                          {ML_NNFW_HW_NPU_EDGE_TPU, "npu.edgetpu"},
                                                          {ML_NNFW_HW_NPU_VIVANTE, "npu.vivante"},
                                                          {ML_NNFW_HW_NPU_SLSI, "npu.slsi"},
                                                          {ML_NNFW_HW_NPU_SR, "npu.sr"}};
  for (const auto& [number, name] : kNames)
    if (number == hardware) return name;
  return std::nullopt;
}

}  // namespace weir::application
