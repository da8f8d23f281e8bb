// A filter descriptor of version 1 that opens and invokes a model without a pipeline.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstring>
#include <map>
#include <memory>

#include "compat/builtin.hpp"
#include "compat/descriptor_slots.hpp"
#include "compat/guard.hpp"
#include "compat/tensors.hpp"
#include "core/direct/direct_model.hpp"
#include "core/infer/module/accelerator.hpp"
#include "core/infer/module/custom_options.hpp"
#include "core/infer/module/module_library.hpp"
#include "weir/model.h"

namespace weir::compat {
namespace {

using Framework = GstTensorFilterFramework;
using Infos = std::vector<weir_tensor_info>;
using Pairs = std::vector<std::pair<std::string, std::string>>;

Slots<Framework, weir_engine>& filter_slots();

struct BuiltinModel {
  std::unique_ptr<direct::DirectModel> model;
};
BuiltinModel* opened_filter(void* priv) {
  return static_cast<BuiltinModel*>(priv);
}

// Declares tensors as tensor_filter's properties would.
void declare(const char* role, const GstTensorsInfo& meta, Pairs* out) {
  const auto tensors = to_spec(meta).tensors;
  if (tensors.empty()) return;
  out->emplace_back(role, join_shapes(tensors));
  out->emplace_back(std::string(role) + "type", join_types(tensors));
  const auto names = join_names(tensors);
  if (names.find_first_not_of(',') != std::string::npos)
    out->emplace_back(std::string(role) + "name", names);
}

infer::OpenOptions make_request(const weir_engine& engine, const GstTensorFilterProperties& prop) {
  infer::OpenOptions request;
  for (int i = 0; prop.model_files && i < prop.num_models; ++i)
    if (prop.model_files[i]) request.paths.emplace_back(prop.model_files[i]);
  const std::string custom = prop.custom_properties ? prop.custom_properties : "";
  const std::string accelerator = prop.accl_str ? prop.accl_str : "";
  request.options = infer::custom_options(custom);
  declare("input", prop.input_meta, &request.declared);
  declare("output", prop.output_meta, &request.declared);
  if (!custom.empty()) request.declared.emplace_back("custom", custom);
  if (!accelerator.empty()) request.declared.emplace_back("accelerator", accelerator);
  if (prop.invoke_dynamic) request.declared.emplace_back("invoke-dynamic", "true");
  request.accelerator = infer::choose_accelerator(infer::parse_accelerator(accelerator),
                                                  infer::list_accelerators(engine));
  return request;
}

bool is_known(const weir_tensor_info& info) {
  return info.type < WEIR_TYPE_END && info.rank <= WEIR_RANK_LIMIT &&
         std::all_of(info.shape, info.shape + info.rank, [](int64_t n) { return n > 0; });
}
bool are_known(const Infos& infos) {
  return !infos.empty() && std::all_of(infos.begin(), infos.end(), is_known);
}

// The caller may have left it uninitialised.
void write(const Infos& infos, GstTensorsInfo* to) {
  gst_tensors_info_init(to);
  assign(infos, to);
}

// Returns the caller's description with the model's rank, if only 1s are added or removed.
weir_tensor_info to_info(const GstTensorInfo& tensor, const Infos& model, size_t index) {
  const Shape shape = to_shape(tensor.dimension);
  weir_tensor_info info{};
  info.type = static_cast<uint32_t>(tensor.type);
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  info.rank = static_cast<uint32_t>(shape.rank());
  if (index < model.size() && model[index].rank <= WEIR_RANK_LIMIT &&
      shape.min_rank() <= model[index].rank)
    info.rank = model[index].rank;
  for (uint32_t i = 0; i < info.rank; ++i)
    info.shape[i] = std::max<int64_t>(1, shape[info.rank - 1 - i]);
  return info;
}

int no(const char* function, const Error& error) {
  warn(function, error);
  return -EINVAL;
}

int open(const weir_engine& engine, const GstTensorFilterProperties* prop, void** priv) {
  if (!given("open", {prop, priv})) return -EINVAL;
  *priv = nullptr;
  if (!can_be("open", prop->input_meta) || !can_be("open", prop->output_meta)) return -EINVAL;
  return or_else("open", -EINVAL, [&] {
    const auto request = make_request(engine, *prop);
    if (request.paths.empty() && !(engine.flags & WEIR_ENGINE_NEEDS_NO_MODEL))
      return no("open", {.code = Code::MODEL_NOT_FOUND,
                         .what = "no model is set",
                         .offered = "no model_files",
                         .needed = "the path of a model file"});
    auto model = direct::DirectModel::open(engine, request);
    if (!model) return no("open", model.error());
    *priv = new BuiltinModel{*std::move(model)};
    return 0;
  });
}

void close(const GstTensorFilterProperties*, void** priv) {
  if (!priv) return;
  const std::unique_ptr<BuiltinModel> owner(opened_filter(std::exchange(*priv, nullptr)));
}

// Open extents of the model are 1 until the caller sets them.
int model_tensors(direct::DirectModel& model, GstTensorsInfo* in, GstTensorsInfo* out) {
  auto inputs = model.inputs();
  if (!are_known(inputs)) {
    for (auto& info : inputs) {
      if (info.rank > WEIR_RANK_LIMIT || info.type >= WEIR_TYPE_END) return -ENOENT;
      std::replace_if(
          info.shape, info.shape + info.rank, [](int64_t n) { return n <= 0; }, 1);
    }
    if (inputs.empty() || !model.reshape(inputs)) return -ENOENT;
  }
  const auto outputs = model.outputs();
  if (!are_known(outputs)) return -ENOENT;
  write(model.inputs(), in);
  write(outputs, out);
  return 0;
}

int set_inputs(direct::DirectModel& model, const GstTensorsInfo& in, GstTensorsInfo* out) {
  if (!can_be("getModelInfo", in)) return -EINVAL;
  const auto now = model.inputs();
  Infos wanted;
  for (size_t i = 0; i < in.num_tensors; ++i)
    if (const auto* tensor = tensor_at(in, i)) wanted.push_back(to_info(*tensor, now, i));
  if (auto status = model.reshape(wanted); !status) return no("getModelInfo", status.error());
  const auto outputs = model.outputs();
  if (!are_known(outputs)) return -ENOENT;
  write(outputs, out);
  return 0;
}

int get_model_info(const Framework*, const GstTensorFilterProperties*, void* priv,
                   model_info_ops op, GstTensorsInfo* in, GstTensorsInfo* out) {
  if (!given("getModelInfo", {priv, in, out})) return -EINVAL;
  return or_else("getModelInfo", -EINVAL, [&] {
    auto& model = *opened_filter(priv)->model;
    if (op == GET_IN_OUT_INFO) return model_tensors(model, in, out);
    return op == SET_INPUT_INFO ? set_inputs(model, *in, out) : -ENOENT;
  });
}

// Copies into the caller's memory; allocates where it has none.
int hand_over(const direct::Results& results, GstTensorFilterProperties* prop,
              GstTensorMemory* output) {
  Infos infos;
  for (size_t i = 0; i < results.tensors().size(); ++i) {
    const weir_tensor& tensor = results.tensors()[i];
    infos.push_back(tensor.info);
    if (!output[i].data) {
      output[i].data = g_memdup2(tensor.data, tensor.bytes);
      output[i].size = tensor.bytes;
    } else if (output[i].size == tensor.bytes) {
      std::memcpy(output[i].data, tensor.data, tensor.bytes);
    } else {
      return no("invoke",
                {.code = Code::FRAME_SIZE,
                 .what = "the memory for output " + std::to_string(i) + " has the wrong size",
                 .offered = std::to_string(output[i].size) + " bytes",
                 .needed = std::to_string(tensor.bytes) + " bytes"});
    }
  }
  if (prop->invoke_dynamic) assign(infos, &prop->output_meta);
  return 0;
}

// Returns the model's type if it is known, else that of the stream; bytes where neither is.
uint32_t type_of_input(const Infos& model, size_t i, const GstTensorInfo* meta) {
  if (i < model.size() && model[i].type < WEIR_TYPE_END) return model[i].type;
  return meta ? static_cast<uint32_t>(meta->type) : uint32_t{WEIR_UINT8};
}

std::vector<weir_tensor> input_tensors(const Infos& model, const GstTensorsInfo& metas,
                                       const GstTensorMemory* input) {
  const size_t count = model.empty() ? metas.num_tensors : model.size();
  std::vector<weir_tensor> out;
  for (size_t i = 0; i < count; ++i) {
    const auto* meta = i < metas.num_tensors ? tensor_at(metas, i) : nullptr;
    out.push_back(weir_tensor_of(input[i].data, input[i].size, type_of_input(model, i, meta)));
    if (meta && gst_tensor_info_validate(meta) && gst_tensor_info_get_size(meta) == input[i].size)
      out.back().info = to_info(*meta, model, i);
  }
  return out;
}

int invoke(const Framework*, GstTensorFilterProperties* prop, void* priv,
           const GstTensorMemory* input, GstTensorMemory* output) {
  if (!given("invoke", {prop, priv, input, output})) return -EINVAL;
  if (!can_be("invoke", prop->input_meta)) return -EINVAL;
  return or_else("invoke", -EINVAL, [&] {
    auto& model = *opened_filter(priv)->model;
    const auto outcome = model.invoke(input_tensors(model.inputs(), prop->input_meta, input));
    if (!outcome) return no("invoke", outcome.error());
    return outcome->dropped ? 1 : hand_over(outcome->results, prop, output);
  });
}

const weir_engine& engine_of_slot(const Framework* self) {
  return *static_cast<const weir_engine*>(self->subplugin_data);
}

// One list per engine, never freed.
const std::vector<accl_hw>& list_hardware(const weir_engine& engine) {
  struct Lists {
    std::mutex mutex;  // guards all
    std::map<const weir_engine*, std::vector<accl_hw>> all;
  };
  static auto& lists = *new Lists;
  std::lock_guard lock(lists.mutex);
  const auto [place, is_new] = lists.all.try_emplace(&engine);
  if (is_new) {
    for (const auto& name : infer::list_accelerators(engine))
      place->second.push_back(get_accl_hw_type(name.c_str()));
    if (place->second.empty()) place->second = {ACCL_CPU};
  }
  return place->second;
}

int get_framework_info(const Framework* self, const GstTensorFilterProperties*, void*,
                       GstTensorFilterFrameworkInfo* info) {
  if (!given("getFrameworkInfo", {self, info})) return -EINVAL;
  return or_else("getFrameworkInfo", -EINVAL, [&] {
    const auto& engine = engine_of_slot(self);
    const auto& hardware = list_hardware(engine);
    *info = {};
    info->name = engine.name;
    info->run_without_model = (engine.flags & WEIR_ENGINE_NEEDS_NO_MODEL) != 0;
    info->verify_model_path = !(engine.flags & WEIR_ENGINE_MODEL_IS_NO_FILE);
    info->hw_list = hardware.data();
    info->num_hw = static_cast<int>(hardware.size());
    info->accl_auto = info->accl_default = hardware[0];
    return 0;
  });
}

int handle_event(const Framework* self, const GstTensorFilterProperties* prop, void* priv,
                 event_ops op, GstTensorFilterFrameworkEventData* data) {
  if (!given("eventHandler", {self, data})) return -EINVAL;
  if (op == DESTROY_NOTIFY) {
    g_free(data->data);
    return 0;
  }
  return or_else("eventHandler", -EINVAL, [&] {
    if (op == CHECK_HW_AVAILABILITY) {
      const auto& hardware = list_hardware(engine_of_slot(self));
      const bool there = std::find(hardware.begin(), hardware.end(), data->hw) != hardware.end();
      return there ? 0 : -EINVAL;
    }
    if (op != RELOAD_MODEL || !prop || !priv) return -ENOENT;
    auto properties = *prop;
    properties.model_files = data->model_files;
    properties.num_models = data->num_models;
    void* reopened = nullptr;
    const int result = open(engine_of_slot(self), &properties, &reopened);
    if (result < 0) return result;
    const std::unique_ptr<BuiltinModel> old(opened_filter(reopened));
    std::swap(old->model, opened_filter(priv)->model);
    return 0;
  });
}

template <size_t Number>
struct FilterFunctions {
  static Framework descriptor() {
    Framework framework{};
    framework.version = GST_TENSOR_FILTER_FRAMEWORK_V1;
    framework.open = [](const GstTensorFilterProperties* prop, void** priv) {
      return open(filter_slots().type(Number), prop, priv);
    };
    framework.close = close;
    framework.invoke = invoke;
    framework.getFrameworkInfo = get_framework_info;
    framework.getModelInfo = get_model_info;
    framework.eventHandler = handle_event;
    return framework;
  }
};

Slots<Framework, weir_engine>& filter_slots() {
  using Numbers = std::make_index_sequence<Slots<Framework, weir_engine>::kMax>;
  const auto make = []<size_t Number>() { return FilterFunctions<Number>::descriptor(); };
  static auto& all = *new Slots<Framework, weir_engine>(slot_table(make, Numbers()));
  return all;
}

}  // namespace

Result<const Framework*> builtin_filter(const char* name) {
  const auto engine = infer::ModuleLibrary::instance().engine(name);
  if (!engine) return engine.error();
  return filter_slots().of(**engine, [&](Framework& framework, size_t) {
    framework.subplugin_data = const_cast<weir_engine*>(*engine);
  });
}

}  // namespace weir::compat
