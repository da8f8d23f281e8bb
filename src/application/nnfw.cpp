// SPDX-License-Identifier: LGPL-2.1-or-later
#include "nnfw.hpp"

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <string_view>
#include <utility>

#include "core/infer/module/accelerator.hpp"
#include "core/infer/module/known_engines.hpp"
#include "core/subplugin/loader.hpp"
#include "core/text/text.hpp"

namespace weir::application {
namespace {

constexpr std::pair<ml_nnfw_type_e, const char*> kFrameworks[]{
    {ML_NNFW_TYPE_ANY, ""},
    {ML_NNFW_TYPE_CUSTOM_FILTER, "custom"},
    {ML_NNFW_TYPE_TENSORFLOW_LITE, "tensorflow-lite"},
    {ML_NNFW_TYPE_TENSORFLOW, "tensorflow"},
    {ML_NNFW_TYPE_NNFW, "nnfw"},
    {ML_NNFW_TYPE_MVNC, "movidius-ncsdk2"},
    {ML_NNFW_TYPE_OPENVINO, "openvino"},
    {ML_NNFW_TYPE_VIVANTE, "vivante"},
    {ML_NNFW_TYPE_EDGE_TPU, "edgetpu"},
    {ML_NNFW_TYPE_ARMNN, "armnn"},
    {ML_NNFW_TYPE_SNPE, "snpe"},
    {ML_NNFW_TYPE_PYTORCH, "pytorch"},
    {ML_NNFW_TYPE_NNTR_INF, "nntrainer"},
    {ML_NNFW_TYPE_VD_AIFW, "vd_aifw"},
    {ML_NNFW_TYPE_TRIX_ENGINE, "trix-engine"},
    {ML_NNFW_TYPE_MXNET, "mxnet"},
    {ML_NNFW_TYPE_TVM, "tvm"},
    {ML_NNFW_TYPE_ONNX_RUNTIME, "onnxruntime"},
    {ML_NNFW_TYPE_NCNN, "ncnn"},
    {ML_NNFW_TYPE_TENSORRT, "tensorrt"},
    {ML_NNFW_TYPE_QNN, "qnn"},
    {ML_NNFW_TYPE_LLAMACPP, "llamacpp"},
    {ML_NNFW_TYPE_TIZEN_HAL, "tizen-hal"},
    {ML_NNFW_TYPE_SNAP, "snap"},
    {ML_NNFW_TYPE_EXECUTORCH, "executorch"}};

constexpr std::pair<ml_nnfw_hw_e, const char*> kAccelerators[]{
    {ML_NNFW_HW_ANY, "default"},
    {ML_NNFW_HW_AUTO, "auto"},
    {ML_NNFW_HW_CPU, "cpu"},
    {ML_NNFW_HW_CPU_SIMD, "cpu.simd"},
    {ML_NNFW_HW_GPU, "gpu"},
    {ML_NNFW_HW_NPU, "npu"},
    {ML_NNFW_HW_NPU_MOVIDIUS, "npu.movidius"},
    {ML_NNFW_HW_NPU_EDGE_TPU, "npu.edgetpu"},
    {ML_NNFW_HW_NPU_VIVANTE, "npu.vivante"},
    {ML_NNFW_HW_NPU_SLSI, "npu.slsi"},
    {ML_NNFW_HW_NPU_SR, "npu.sr"}};

bool is_one_of(ml_nnfw_type_e type, std::initializer_list<ml_nnfw_type_e> types) {
  return std::find(types.begin(), types.end(), type) != types.end();
}

// The extensions of frameworks that read files of others too; empty for the rest.
std::string_view extensions(ml_nnfw_type_e type) {
  switch (type) {
    case ML_NNFW_TYPE_VD_AIFW:
      return "nb,ncp,tvn,bin";
    case ML_NNFW_TYPE_ARMNN:
      return "caffemodel,tflite,pb,prototxt";
    case ML_NNFW_TYPE_MXNET:
      return "params,json";
    default: {
      const auto name = framework_name(type);
      const auto* engine = name ? infer::known_engine(*name) : nullptr;
      return engine ? engine->extensions : std::string_view();
    }
  }
}

bool reads_any_file(ml_nnfw_type_e type) {
  return is_one_of(type, {ML_NNFW_TYPE_ANY, ML_NNFW_TYPE_NNFW, ML_NNFW_TYPE_TVM,
                          ML_NNFW_TYPE_ONNX_RUNTIME, ML_NNFW_TYPE_NCNN, ML_NNFW_TYPE_TENSORRT,
                          ML_NNFW_TYPE_QNN, ML_NNFW_TYPE_LLAMACPP, ML_NNFW_TYPE_TIZEN_HAL});
}

}  // namespace

Result<std::string> framework_name(ml_nnfw_type_e type) {
  for (const auto& [number, name] : kFrameworks)
    if (number == type) return std::string(name);
  return Error{.code = Code::OPTION_VALUE,
               .what = "nnfw is not a value of ml_nnfw_type_e",
               .offered = std::to_string(static_cast<int>(type)),
               .needed = "a value from ml-api-common.h, such as ML_NNFW_TYPE_ANY"};
}

ml_nnfw_type_e framework_number(const std::string& name) {
  const auto* engine = infer::known_engine(name);
  for (const auto& [number, known] : kFrameworks)
    if (name == known || (engine && engine->name == known)) return number;
  return ML_NNFW_TYPE_ANY;
}

std::string accelerator_name(ml_nnfw_hw_e hardware) {
  for (const auto& [number, name] : kAccelerators)
    if (number == hardware) return name;
  return "auto";
}

Status check_model_name(ml_nnfw_type_e type, std::span<const std::string> paths) {
  if (reads_any_file(type)) return ok();
  const auto allowed = extensions(type);
  const auto list = split(allowed, ",");
  for (const auto& path : paths) {
    const std::string extension = std::filesystem::path(path).extension().string();
    const bool is_listed = std::any_of(list.begin(), list.end(), [&](std::string_view known) {
      return extension.size() > 1 && equal_ignoring_case(extension.substr(1), known);
    });
    if (is_listed) return ok();
  }
  return Error{.code = Code::OPTION_VALUE,
               .what = "the framework " + *framework_name(type) + " does not read this model file",
               .offered = paths.empty() ? "" : paths.front(),
               .needed = allowed.empty()
                             ? "a file that it reads"
                             : "a file with one of the extensions " + std::string(allowed),
               .fix = "ML_NNFW_TYPE_ANY, which chooses the framework by the name of the file"};
}

bool is_unsupported(ml_nnfw_type_e type) {
  return is_one_of(
      type, {ML_NNFW_TYPE_MVNC, ML_NNFW_TYPE_OPENVINO, ML_NNFW_TYPE_EDGE_TPU, ML_NNFW_TYPE_SNAP});
}

bool needs_infos(ml_nnfw_type_e type) {
  return is_one_of(type, {ML_NNFW_TYPE_TENSORFLOW, ML_NNFW_TYPE_SNAP, ML_NNFW_TYPE_PYTORCH,
                          ML_NNFW_TYPE_TRIX_ENGINE, ML_NNFW_TYPE_NCNN});
}

Status check_available(const std::string& framework, const std::string& accelerator,
                       const char* custom) {
  const auto number = infer::accelerator_number(accelerator).value_or(0);
  auto status = subplugin::check_available(framework, number, custom);
  if (status || status.error().code != Code::OPTION_VALUE) return status;
  Error error = status.error();
  error.offered = accelerator;
  error.needed = "ML_NNFW_HW_ANY, or hardware that it supports";
  return error;
}

}  // namespace weir::application
