// SPDX-License-Identifier: LGPL-2.1-or-later
#include "compat/properties.hpp"

#include <algorithm>

#include "core/infer/module/accelerator.hpp"
#include "core/text/text.hpp"
#include "nnstreamer_plugin_api_filter.h"
#include "nnstreamer_plugin_api_util.h"

namespace weir::compat {

namespace {

std::string option(const OpenRequest& request, const char* name) {
  return std::string(request.options.get(name).value_or(""));
}
bool is_on(const OpenRequest& request, const char* name) {
  return request.options.get(name).value_or("") == "true";
}
int number(const OpenRequest& request, const char* name) {
  return static_cast<int>(parse_unsigned(option(request, name)).value_or(0));
}

void read_tensors(const OpenRequest& request, const std::string& role, GstTensorsInfo* info,
                  unsigned* ranks) {
  const auto dimensions = option(request, role.c_str());
  const auto types = option(request, (role + "type").c_str());
  const auto names = option(request, (role + "name").c_str());
  const guint counts[] = {gst_tensors_info_parse_dimensions_string(info, dimensions.c_str()),
                          gst_tensors_info_parse_types_string(info, types.c_str()),
                          gst_tensors_info_parse_names_string(info, names.c_str())};
  info->num_tensors = *std::max_element(std::begin(counts), std::end(counts));
  for (size_t i = 0; i < info->num_tensors; ++i)
    ranks[i] = gst_tensor_info_get_rank(room_at(*info, i));
}

void read_layouts(const std::string& text, tensors_layout layouts) {
  const auto parts = split(text, ",.");
  for (size_t i = 0; i < parts.size() && i < NNS_TENSOR_SIZE_LIMIT; ++i) {
    const auto word = strip(parts[i]);
    layouts[i] = word.empty() || equal_ignoring_case(word, "any") ? _NNS_LAYOUT_ANY
                 : equal_ignoring_case(word, "nhwc")              ? _NNS_LAYOUT_NHWC
                 : equal_ignoring_case(word, "nchw")              ? _NNS_LAYOUT_NCHW
                                                                  : _NNS_LAYOUT_NONE;
  }
}

}  // namespace

Properties::Properties(std::string name, std::string shown, const OpenRequest& request)
    : name_(std::move(name)),
      shown_(std::move(shown)),
      custom_(option(request, "custom")),
      accelerator_(option(request, "accelerator")),
      key_(option(request, "shared-tensor-filter-key")),
      models_(request.paths.begin(), request.paths.end()),
      async_timeout_(number(request, "async-timeout")) {
  for (const auto& model : models_) model_files_.push_back(model.c_str());
  value_.fwname = name_.c_str();
  value_.num_models = static_cast<int>(model_files_.size());
  model_files_.push_back(nullptr);
  value_.model_files = model_files_.data();
  gst_tensors_info_init(&value_.input_meta);
  gst_tensors_info_init(&value_.output_meta);
  read_tensors(request, "input", &value_.input_meta, value_.input_ranks);
  read_tensors(request, "output", &value_.output_meta, value_.output_ranks);
  value_.invoke_dynamic = is_on(request, "invoke-dynamic");
  for (size_t i = 0; value_.invoke_dynamic && i < value_.output_meta.num_tensors; ++i)
    g_free(std::exchange(tensor_at(value_.output_meta, i)->name, nullptr));
  value_.input_configured = gst_tensors_info_validate(&value_.input_meta);
  value_.output_configured = gst_tensors_info_validate(&value_.output_meta);
  read_layouts(option(request, "inputlayout"), value_.input_layout);
  read_layouts(option(request, "outputlayout"), value_.output_layout);
  value_.custom_properties = custom_.empty() ? nullptr : custom_.c_str();
  value_.accl_str = accelerator_.empty() ? nullptr : accelerator_.c_str();
  value_.shared_tensor_filter_key = key_.empty() ? nullptr : key_.data();
  value_.latency = number(request, "latency");
  value_.throughput = number(request, "throughput");
  value_.suspend = static_cast<uint32_t>(number(request, "suspend"));
  value_.invoke_async = is_on(request, "invoke-async");
}

Properties::~Properties() {
  gst_tensors_info_free(&value_.input_meta);
  gst_tensors_info_free(&value_.output_meta);
}

void Properties::choose_hardware(const std::vector<accl_hw>& supported, accl_hw automatic,
                                 accl_hw standard, bool whole_list) {
  const auto request = infer::parse_accelerator(accelerator_);
  const auto number = [](const std::string& name) {
    return static_cast<accl_hw>(infer::accelerator_number(name).value_or(ACCL_NONE));
  };
  const auto is_supported = [&](accl_hw hw) {
    return supported.empty() ||
           std::find(supported.begin(), supported.end(), hw) != supported.end();
  };
  const auto excluded = [&](accl_hw hw) {
    return std::any_of(request.excluded.begin(), request.excluded.end(),
                       [&](const auto& name) { return number(name) == hw; });
  };
  hardware_.clear();
  if (request.kind == infer::AcceleratorRequest::Kind::EngineDefault) hardware_ = {standard};
  if (request.kind == infer::AcceleratorRequest::Kind::None) hardware_ = {ACCL_NONE};
  if (request.kind == infer::AcceleratorRequest::Kind::Hardware)
    for (const auto& name : request.names)
      if (const auto hw = number(name); is_supported(hw) && !excluded(hw)) hardware_.push_back(hw);
  if (hardware_.empty())
    hardware_ = {automatic != ACCL_NONE || supported.empty() ? automatic : supported[0]};
  if (!whole_list) hardware_.resize(1);
  value_.hw_list = hardware_.data();
  value_.num_hw = static_cast<int>(hardware_.size());
}

void Properties::configure_inputs(std::span<const weir_tensor_info> inputs) {
  assign(inputs, &value_.input_meta);
  for (size_t i = 0; i < inputs.size(); ++i)
    value_.input_ranks[i] = gst_tensor_info_get_rank(tensor_at(value_.input_meta, i));
  value_.input_configured = TRUE;
}

void Properties::configure_outputs(std::span<const weir_tensor_info> outputs) {
  assign(outputs, &value_.output_meta);
  for (size_t i = 0; i < outputs.size(); ++i)
    value_.output_ranks[i] = gst_tensor_info_get_rank(tensor_at(value_.output_meta, i));
  value_.output_configured = TRUE;
}

void Properties::forget_output_names() noexcept {
  for (size_t i = 0; i < NNS_TENSOR_SIZE_LIMIT; ++i)
    if (auto* tensor = tensor_at(value_.output_meta, i)) tensor->name = nullptr;
}

}  // namespace weir::compat
