// Filter descriptors of version 1 that open and invoke a model without a pipeline. Programs may
// call invoke, getModelInfo and eventHandler without the descriptor and without properties.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>

#include "compat/builtin.hpp"
#include "compat/builtin_engine.hpp"
#include "compat/descriptor_slots.hpp"
#include "compat/guard.hpp"
#include "core/infer/module/module_library.hpp"

namespace weir::compat {
namespace {

using Framework = GstTensorFilterFramework;

Slots<Framework, weir_engine>& filter_slots();

int open(const weir_engine& engine, const GstTensorFilterProperties* prop, void** priv) {
  if (!given("open", {prop, priv})) return -EINVAL;
  *priv = nullptr;
  return or_else("open", -EINVAL, [&] {
    *priv = BuiltinModel::open(engine, *prop).release();
    return *priv ? 0 : -EINVAL;
  });
}

int get_model_info(const Framework*, const GstTensorFilterProperties*, void* priv,
                   model_info_ops op, GstTensorsInfo* in, GstTensorsInfo* out) {
  if (!given("getModelInfo", {priv, in, out})) return -EINVAL;
  return or_else("getModelInfo", -EINVAL, [&] {
    auto& model = *opened_filter(priv);
    if (op == SET_INPUT_INFO) return model.set_inputs(*in, out);
    if (op != GET_IN_OUT_INFO) return -ENOENT;
    if (const int result = model.get_inputs(nullptr); result < 0) return result;
    if (const int result = model.get_outputs(out); result < 0) return result;
    return model.get_inputs(in);
  });
}

int invoke(const Framework*, GstTensorFilterProperties* prop, void* priv,
           const GstTensorMemory* input, GstTensorMemory* output) {
  if (!given("invoke", {priv, input, output})) return -EINVAL;
  return or_else("invoke", -EINVAL,
                 [&] { return opened_filter(priv)->invoke(prop, input, output); });
}

int get_framework_info(const Framework* self, const GstTensorFilterProperties*, void*,
                       GstTensorFilterFrameworkInfo* info) {
  if (!given("getFrameworkInfo", {self, info})) return -EINVAL;
  return or_else("getFrameworkInfo", -EINVAL, [&] {
    const auto& engine = *static_cast<const weir_engine*>(self->subplugin_data);
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

int reload(void* priv, const GstTensorFilterFrameworkEventData& data) {
  if (!given("eventHandler", {priv})) return -EINVAL;
  auto& model = *opened_filter(priv);
  auto other = model.open_other(file_paths(data.model_files, data.num_models));
  if (!other) return -EINVAL;
  model = std::move(*other);
  return 0;
}

int handle_event(const weir_engine& engine, void* priv, event_ops op,
                 GstTensorFilterFrameworkEventData* data) {
  if (!given("eventHandler", {data})) return -EINVAL;
  if (op == DESTROY_NOTIFY) {
    g_free(data->data);
    return 0;
  }
  return or_else("eventHandler", -EINVAL, [&] {
    if (op == RELOAD_MODEL) return reload(priv, *data);
    if (op == CHECK_HW_AVAILABILITY) return runs_on(engine, data->hw) ? 0 : -EINVAL;
    return -ENOENT;
  });
}

template <size_t Number>
Framework descriptor() {
  Framework framework{};
  framework.version = GST_TENSOR_FILTER_FRAMEWORK_V1;
  framework.open = [](const GstTensorFilterProperties* prop, void** priv) {
    return open(filter_slots().type(Number), prop, priv);
  };
  framework.close = close_filter;
  framework.invoke = invoke;
  framework.getFrameworkInfo = get_framework_info;
  framework.getModelInfo = get_model_info;
  framework.eventHandler = [](const Framework*, const GstTensorFilterProperties*, void* priv,
                              event_ops op, GstTensorFilterFrameworkEventData* data) {
    return handle_event(filter_slots().type(Number), priv, op, data);
  };
  return framework;
}

Slots<Framework, weir_engine>& filter_slots() {
  using Numbers = std::make_index_sequence<Slots<Framework, weir_engine>::kMax>;
  const auto make = []<size_t Number>() { return descriptor<Number>(); };
  static auto& all = *new Slots<Framework, weir_engine>(slot_table(make, Numbers()));
  return all;
}

}  // namespace

Result<const Framework*> builtin_filter(const char* name) {
  const auto engine = infer::ModuleLibrary::instance().engine(name);
  if (!engine) return engine.error();
  if (const auto* members = find_v0_members((*engine)->name))
    return builtin_filter_v0(**engine, *members);
  return filter_slots().of(**engine, [&](Framework& framework, size_t) {
    framework.subplugin_data = const_cast<weir_engine*>(*engine);
  });
}

}  // namespace weir::compat
