// Filter descriptors of version 0. Programs that know a framework call the members of the version
// that it has in NNStreamer without looking at the descriptor's.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <map>
#include <mutex>

#include "compat/builtin_engine.hpp"
#include "compat/descriptor_slots.hpp"
#include "compat/guard.hpp"
#include "compat/tensors.hpp"
#include "core/infer/module/accelerator.hpp"
#include "core/infer/module/module_library.hpp"
#include "nnstreamer_plugin_api_util.h"

namespace weir::compat {
namespace {

using Framework = GstTensorFilterFramework;
using Prop = GstTensorFilterProperties;

constexpr int kInvalidProperties = -1, kNotLoaded = -2;  // results of open that programs compare

// clang-format off
constexpr V0Members kMembers[] = {
    // engine, name, allocates, verifies, sets_inputs, resizes_inputs, reloads, lists_hardware, has_statistics
    {"tensorflow-lite", "tensorflow2-lite", false, true, true, true, true, true, true},
    {"pytorch", "pytorch", false, true, false, false, false, true, false},
    {"custom", "custom", true, false, true, false, false, true, false},
    {"cpp", "cpp", false, false, true, false, false, false, false},
    {"tensorflow", "tensorflow", false, true, true, false, false, true, false},
    {"caffe2", "caffe2", false, true, true, false, false, true, false},
    {"armnn", "armnn", false, true, true, false, false, true, false},
    {"openvino", "openvino", false, true, true, false, false, true, false},
    {"nnfw", "nnfw", false, true, true, false, false, true, false},
    {"movidius-ncsdk2", "movidius-ncsdk2", false, true, true, false, false, true, false},
    {"vivante", "vivante", false, true, true, false, false, true, false},
};
// clang-format on

// A custom filter has either fixed tensors or a function that sets them.
bool declares_inputs(const BuiltinModel& model) {
  return !model.model().inputs().empty();
}

int open_v0_filter(const weir_engine& engine, const V0Members& members, const Prop* prop,
                   void** priv) {
  if (!given("open", {prop, priv})) return kInvalidProperties;
  return or_else("open", kNotLoaded, [&] {
    const auto paths = file_paths(prop->model_files, prop->num_models);
    if (*priv && members.allocates) return -EINVAL;
    if (*priv && opened_filter(*priv)->paths() == paths) return 1;
    delete opened_filter(std::exchange(*priv, nullptr));
    if (paths.empty()) return kInvalidProperties;
    *priv = BuiltinModel::open(engine, *prop).release();
    return *priv ? 0 : kNotLoaded;
  });
}

bool is_open(const char* function, void** priv, std::initializer_list<const void*> pointers) {
  return given(function, {priv}) && given(function, {*priv}) && given(function, pointers);
}

int invoke_nn(const Prop* prop, void** priv, const GstTensorMemory* in, GstTensorMemory* out) {
  if (!is_open("invoke_NN", priv, {in, out})) return -EINVAL;
  return or_else("invoke_NN", -EINVAL,
                 [&] { return opened_filter(*priv)->invoke(const_cast<Prop*>(prop), in, out); });
}

int get_inputs(const Prop*, void** priv, GstTensorsInfo* info) {
  if (!is_open("getInputDimension", priv, {info})) return -EINVAL;
  return or_else("getInputDimension", -EINVAL, [&] {
    auto& model = *opened_filter(*priv);
    return declares_inputs(model) ? model.get_inputs(info) : -ENOENT;
  });
}

int get_outputs(const Prop*, void** priv, GstTensorsInfo* info) {
  if (!is_open("getOutputDimension", priv, {info})) return -EINVAL;
  return or_else("getOutputDimension", -EINVAL, [&] {
    auto& model = *opened_filter(*priv);
    if (!declares_inputs(model)) return -ENOENT;
    if (const int result = model.get_inputs(nullptr); result < 0) return result;
    return model.get_outputs(info);
  });
}

int set_inputs(const Prop*, void** priv, const GstTensorsInfo* in, GstTensorsInfo* out) {
  if (!is_open("setInputDimension", priv, {in, out})) return -EINVAL;
  return or_else("setInputDimension", -EINVAL,
                 [&] { return opened_filter(*priv)->set_inputs(*in, out); });
}

int set_custom_inputs(const Prop* prop, void** priv, const GstTensorsInfo* in,
                      GstTensorsInfo* out) {
  if (!is_open("setInputDimension", priv, {in, out})) return -EINVAL;
  return declares_inputs(*opened_filter(*priv)) ? -ENOENT : set_inputs(prop, priv, in, out);
}

int resize_inputs(const Prop*, void** priv, const GstTensorsInfo* in, GstTensorsInfo* out) {
  if (!is_open("setInputDimension", priv, {in, out})) return -EINVAL;
  return or_else("setInputDimension", -EINVAL,
                 [&] { return opened_filter(*priv)->resize_inputs(*in, out); });
}

bool have_equal_tensors(BuiltinModel& one, BuiltinModel& other) {
  OwnedTensorsInfo in[2], out[2];
  return one.get_inputs(in[0].get()) == 0 && other.get_inputs(in[1].get()) == 0 &&
         one.get_outputs(out[0].get()) == 0 && other.get_outputs(out[1].get()) == 0 &&
         gst_tensors_info_is_equal(in[0].get(), in[1].get()) &&
         gst_tensors_info_is_equal(out[0].get(), out[1].get());
}

int reload_v0_filter(const Prop* prop, void** priv) {
  if (!is_open("reloadModel", priv, {prop})) return -EINVAL;
  return or_else("reloadModel", -EINVAL, [&] {
    const auto paths = file_paths(prop->model_files, prop->num_models);
    if (paths.size() != 1) return kInvalidProperties;
    auto& model = *opened_filter(*priv);
    auto other = model.open_other(paths);
    if (!other) return kNotLoaded;
    if (!have_equal_tensors(model, *other)) {
      warn("reloadModel", "the tensors of " + paths[0] + " differ from those of the model");
      return -EINVAL;
    }
    model = std::move(*other);
    return 0;
  });
}

void destroy(void**, void* data) {
  g_free(data);
}

int allocates(void** priv) {
  if (!is_open("allocateInInvoke", priv, {})) return -EINVAL;
  const auto flags = opened_filter(*priv)->model().info().flags;
  return flags & WEIR_MODEL_ALLOCATES_OUTPUT ? 0 : -EINVAL;
}

Slots<Framework, weir_engine>& v0_slots();

template <size_t Number>
Framework v0_descriptor() {
  Framework framework{};
  framework.version = GST_TENSOR_FILTER_FRAMEWORK_V0;
  framework.open = [](const Prop* prop, void** priv) {
    const auto& engine = v0_slots().type(Number);
    return open_v0_filter(engine, *find_v0_members(engine.name), prop, priv);
  };
  framework.close = close_filter;
  framework.invoke_NN = invoke_nn;
  framework.getInputDimension = get_inputs;
  framework.getOutputDimension = get_outputs;
  framework.checkAvailability = [](accl_hw hw) {
    return runs_on(v0_slots().type(Number), hw) ? 0 : -ENOENT;
  };
  return framework;
}

Slots<Framework, weir_engine>& v0_slots() {
  using Numbers = std::make_index_sequence<Slots<Framework, weir_engine>::kMax>;
  const auto make = []<size_t Number>() { return v0_descriptor<Number>(); };
  static auto& all = *new Slots<Framework, weir_engine>(slot_table(make, Numbers()));
  return all;
}

void apply(const V0Members& members, Framework* framework) {
  static const GstTensorFilterFrameworkStatistics kStatistics{};
  framework->name = const_cast<char*>(members.name);
  framework->allocate_in_invoke = members.allocates;
  framework->verify_model_path = members.verifies;
  if (members.has_statistics) framework->statistics = &kStatistics;
  if (members.sets_inputs) framework->setInputDimension = set_inputs;
  if (members.resizes_inputs) framework->setInputDimension = resize_inputs;
  if (members.reloads) framework->reloadModel = reload_v0_filter;
  if (!members.lists_hardware) framework->checkAvailability = nullptr;
  if (!members.allocates) return;
  framework->setInputDimension = set_custom_inputs;
  framework->destroyNotify = destroy;
  framework->allocateInInvoke = allocates;
}

}  // namespace

std::vector<std::string> file_paths(const char* const* files, int count) {
  std::vector<std::string> out;
  for (int i = 0; files && i < count; ++i)
    if (files[i]) out.emplace_back(files[i]);
  return out;
}

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

bool runs_on(const weir_engine& engine, accl_hw hw) {
  const auto& hardware = list_hardware(engine);
  return std::find(hardware.begin(), hardware.end(), hw) != hardware.end();
}

const V0Members* find_v0_members(std::string_view engine) {
  const auto* found =
      std::find_if(std::begin(kMembers), std::end(kMembers),
                   [&](const V0Members& members) { return members.engine == engine; });
  return found == std::end(kMembers) ? nullptr : found;
}

Result<const Framework*> builtin_filter_v0(const weir_engine& engine, const V0Members& members) {
  return v0_slots().of(engine, [&](Framework& framework, size_t) { apply(members, &framework); });
}

}  // namespace weir::compat
