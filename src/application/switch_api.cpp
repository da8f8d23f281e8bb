// ml_pipeline_switch_* and ml_pipeline_valve_*.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdlib>
#include <cstring>
#include <vector>

#include "pipeline_part.hpp"

namespace {

using namespace weir;
using namespace weir::application;

class Switch : public PipelinePart {
 public:
  static constexpr const char* kKind = "switch";
  using PipelinePart::PipelinePart;
  const char* kind() const noexcept override { return kKind; }
};

class Valve : public PipelinePart {
 public:
  static constexpr const char* kKind = "valve";
  using PipelinePart::PipelinePart;
  const char* kind() const noexcept override { return kKind; }
};

constexpr const char* kInput = "input-selector";

struct PadNames {
  bool sources;  // true: source pads, false: sink pads
  std::vector<std::string> names;
};

void add_pad(const char* name, int source, void* data) {
  auto* pads = static_cast<PadNames*>(data);
  if ((source != 0) == pads->sources) pads->names.emplace_back(name);
}

// Makes a NULL-terminated list for free(); NULL when memory runs out.
// NOLINTBEGIN(cppcoreguidelines-no-malloc): the caller calls free()
char** c_list(const std::vector<std::string>& names) {
  auto** list = static_cast<char**>(std::calloc(names.size() + 1, sizeof(char*)));
  for (size_t i = 0; list && i < names.size(); ++i) {
    list[i] = strdup(names[i].c_str());
    if (list[i]) continue;
    for (size_t k = 0; k < i; ++k) std::free(list[k]);
    std::free(list);
    return nullptr;
  }
  return list;
}
// NOLINTEND(cppcoreguidelines-no-malloc)

}  // namespace

int ml_pipeline_switch_get_handle(ml_pipeline_h pipe, const char* switch_name,
                                  ml_pipeline_switch_e* type, ml_pipeline_switch_h* switch_handle) {
  const int result =
      get_part<Switch>(pipe, switch_name, "input-selector or output-selector", switch_handle);
  if (result != ML_ERROR_NONE || !type) return result;
  return guarded([&] {
    const auto pipeline = use_pipeline(pipe);
    if (!pipeline) return fail(pipeline.error());
    *type = (*pipeline)->get_kind(switch_name) == kInput ? ML_PIPELINE_SWITCH_INPUT_SELECTOR
                                                         : ML_PIPELINE_SWITCH_OUTPUT_SELECTOR;
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_pipeline_switch_release_handle(ml_pipeline_switch_h switch_handle) {
  return release_part<Switch>(switch_handle, "switch_handle");
}

int ml_pipeline_switch_select(ml_pipeline_switch_h switch_handle, const char* pad_name) {
  return with_part<Switch>(switch_handle, "switch_handle",
                           [&](weir_pipeline* pipeline, const char* name, weir_error** error) {
                             return weir_pipeline_select(pipeline, name, pad_name, error);
                           });
}

int ml_pipeline_switch_get_pad_list(ml_pipeline_switch_h switch_handle, char*** list) {
  if (!list) return fail(null_pointer("list"));
  PadNames pads{};
  const auto ask = [&](weir_pipeline* pipeline, const char* name, weir_error** error) {
    const int type = weir_pipeline_property_type(pipeline, name, "sync-streams", nullptr);
    pads.sources = type < 0;  // an input-selector has this property
    return weir_pipeline_pads(pipeline, name, add_pad, &pads, error);
  };
  const int result = with_part<Switch>(switch_handle, "switch_handle", ask);
  if (result != ML_ERROR_NONE) return result;
  return guarded([&] {
    char** const names = c_list(pads.names);
    if (!names) throw std::bad_alloc();
    *list = names;
    return static_cast<int>(ML_ERROR_NONE);
  });
}

int ml_pipeline_valve_get_handle(ml_pipeline_h pipe, const char* valve_name,
                                 ml_pipeline_valve_h* valve_handle) {
  return get_part<Valve>(pipe, valve_name, "valve", valve_handle);
}

int ml_pipeline_valve_release_handle(ml_pipeline_valve_h valve_handle) {
  return release_part<Valve>(valve_handle, "valve_handle");
}

int ml_pipeline_valve_set_open(ml_pipeline_valve_h valve_handle, bool open) {
  return with_part<Valve>(valve_handle, "valve_handle",
                          [&](weir_pipeline* pipeline, const char* name, weir_error** error) {
                            return weir_pipeline_set_valve(pipeline, name, open ? 1 : 0, error);
                          });
}
