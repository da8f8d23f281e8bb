// Opens a model only to read its tensors; reads the extensions weir.statistics/1 and
// weir.servers/1 of an engine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/model_report.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "core/infer/module/module_library.hpp"
#include "core/text/text.hpp"
#include "elements/tensor_filter/filter_properties.hpp"
#include "elements/tensor_filter/model_config.hpp"
#include "elements/tensor_filter/open_model.hpp"
#include "weir/abi.h"
#include "weir/join.hpp"

namespace weir {
namespace {

// Whether the settings open a model with the same tensors.
bool same_model(const FilterSettings& a, const FilterSettings& b) {
  bool same = a.model == b.model;
  each_flagged([&](const auto& p) {
    if (p.flags.reopens) same = same && a.*p.field == b.*p.field;
  });
  return same;
}

// The dimensions of each tensor as the user wrote them; none if the user did not.
std::vector<std::string_view> spelled_dimensions(const FilterSettings& settings, bool inputs) {
  const std::string& text = inputs ? settings.input : settings.output;
  return strip(text).empty() ? std::vector<std::string_view>() : split(text, ",.");
}

// The counts that the engine has of its own.
void add_counts(const infer::Model& model, GstStructure* stats) {
  const weir_engine& engine = model.engine();
  const auto* calls =
      engine.extension
          ? static_cast<const weir_engine_statistics*>(engine.extension(WEIR_ENGINE_STATISTICS))
          : nullptr;
  if (!calls || calls->struct_size < sizeof *calls) return;
  std::array<weir_statistic, 64> all{};
  const int count = calls->read(model.handle(), all.data(), all.size());
  for (int i = 0; i < std::min<int>(count, all.size()); ++i)
    gst_structure_set(stats, all[i].name, G_TYPE_UINT64, guint64{all[i].value}, nullptr);
}

const char* name_of_circuit(int32_t circuit) {
  if (circuit == WEIR_CIRCUIT_CLOSED) return "closed";
  return circuit == WEIR_CIRCUIT_OPEN ? "open" : "half-open";
}

GstStructure* to_structure(const weir_server& server) {
  GstStructure* out = gst_structure_new(
      "server", "address", G_TYPE_STRING, server.address, "circuit", G_TYPE_STRING,
      name_of_circuit(server.circuit), "in-flight", G_TYPE_UINT64, guint64{server.in_flight},
      "answered", G_TYPE_UINT64, guint64{server.answered}, "late", G_TYPE_UINT64,
      guint64{server.late}, "refused", G_TYPE_UINT64, guint64{server.refused}, "lost",
      G_TYPE_UINT64, guint64{server.lost}, "bytes-sent", G_TYPE_UINT64, guint64{server.bytes_sent},
      "bytes-received", G_TYPE_UINT64, guint64{server.bytes_received}, nullptr);
  const auto add = [out](const char* name, int64_t value, bool is_known) {
    if (is_known) gst_structure_set(out, name, G_TYPE_INT64, gint64{value}, nullptr);
  };
  for (const auto& [name, value] : {std::pair{"p50-us", server.p50_us},
                                    {"p95-us", server.p95_us},
                                    {"p99-us", server.p99_us},
                                    {"queue-us", server.queue_us},
                                    {"compute-us", server.compute_us}})
    add(name, value, value >= 0);
  add("clock-offset-ns", server.clock_offset_ns, server.clock_error_ns >= 0);
  add("clock-error-ns", server.clock_error_ns, server.clock_error_ns >= 0);
  return out;
}

// The servers that the model is on, as an array of structures.
void add_servers(const infer::Model& model, GstStructure* stats) {
  const auto* calls = model.servers();
  if (!calls) return;
  std::array<weir_server, 64> all{};
  const int count = calls->read(model.handle(), all.data(), all.size());
  if (count <= 0) return;
  GValue list = G_VALUE_INIT;
  gst_value_array_init(&list, static_cast<guint>(count));
  for (int i = 0; i < std::min<int>(count, all.size()); ++i) {
    GValue one = G_VALUE_INIT;
    g_value_init(&one, GST_TYPE_STRUCTURE);
    g_value_take_boxed(&one, to_structure(all[i]));
    gst_value_array_append_and_take_value(&list, &one);
  }
  gst_structure_take_value(stats, "servers", &list);
}

}  // namespace

std::string ModelReport::framework() const {
  const auto model = opened();
  return model ? model->engine() : framework_name(current_settings());
}

std::string ModelReport::sub_plugins() const {
  return join(infer::ModuleLibrary::instance().engine_names(), ",");
}

int ModelReport::latency() const {
  return current_settings().latency ? statistics_.latency_us() : -1;
}

int ModelReport::throughput() const {
  return current_settings().throughput ? statistics_.throughput_milli() : -1;
}

void ModelReport::report(ModelTensors tensors) {
  std::lock_guard lock(mutex_);
  stream_ = std::make_shared<const ModelTensors>(std::move(tensors));
}

void ModelReport::forget() {
  std::lock_guard lock(mutex_);
  stream_.reset();
}

std::vector<ModelTensor> ModelReport::tensors(const FilterSettings& settings, bool inputs) const {
  std::shared_ptr<const ModelTensors> known;
  {
    std::lock_guard lock(mutex_);
    known = stream_;
  }
  if (!known) {
    if (const auto model = opened()) return inputs ? model->inputs() : model->outputs();
    known = tensors_of_unopened(settings);
  }
  if (!known) return {};
  return inputs ? known->inputs : known->outputs;
}

std::string ModelReport::names(const FilterSettings& settings, bool inputs) const {
  const auto known = tensors(settings, inputs);
  if (!known.empty()) return names_text(known);
  const auto own = spelled_dimensions(settings, inputs);
  return std::string(own.empty() ? 0 : own.size() - 1, ',');
}

std::string ModelReport::layouts(const FilterSettings& settings, bool inputs) const {
  const auto own = spelled_dimensions(settings, inputs);
  const size_t count = own.empty() ? tensors(settings, inputs).size() : own.size();
  return layouts_text(std::vector<uint32_t>(count, WEIR_LAYOUT_ANY));
}

std::string ModelReport::ranks(const FilterSettings& settings, bool inputs) const {
  const auto own = spelled_dimensions(settings, inputs);
  if (own.empty()) return ranks_text(tensors(settings, inputs));
  return join(own, ",", [](const std::string_view dimension) {
    return std::to_string(1 + std::count(dimension.begin(), dimension.end(), ':'));
  });
}

// The model is opened for this, once for the same settings. Null without a model, or if it cannot
// be opened.
std::shared_ptr<const ModelTensors> ModelReport::tensors_of_unopened(
    const FilterSettings& settings) const {
  // Reading a property does not start a worker process.
  if (settings.model.empty() || settings.isolate != IsolateChoice::None) return nullptr;
  FilterSettings alone = settings;
  alone.workers = 1;
  alone.batch_size = 1;
  alone.invoke_async = false;
  std::lock_guard lock(opening_);
  if (known_ && same_model(alone, known_of_)) return known_;
  std::vector<Error> warnings;
  const auto opened = OpenModel::open(alone, nullptr, &warnings);
  if (!opened) return nullptr;
  known_ =
      std::make_shared<const ModelTensors>(ModelTensors{(*opened)->inputs(), (*opened)->outputs()});
  known_of_ = std::move(alone);
  return known_;
}

void add_engine_stats(const infer::Model& model, GstStructure* stats) {
  add_counts(model, stats);
  add_servers(model, stats);
}

void set_answered_by(GstBuffer* buffer, GstElement* element, const std::string& who) {
  if (who.empty()) return;
  static constexpr char kName[] = "WeirAnsweredBy";
  [[maybe_unused]] static const auto* const registered = [] {
    static const gchar* tags[] = {nullptr};
    return gst_meta_register_custom(kName, tags, nullptr, nullptr, nullptr);
  }();
  GstCustomMeta* meta = gst_buffer_get_custom_meta(buffer, kName);
  if (!meta) meta = gst_buffer_add_custom_meta(buffer, kName);
  if (!meta) return;
  gst_structure_set(gst_custom_meta_get_structure(meta), GST_OBJECT_NAME(element), G_TYPE_STRING,
                    who.c_str(), nullptr);
}

}  // namespace weir
