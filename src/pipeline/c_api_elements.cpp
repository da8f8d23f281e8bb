// The C API of a pipeline's elements: lists, valves, selectors, properties.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pipeline/c_api.hpp"
#include "pipeline/element_access.hpp"
#include "pipeline/element_list.hpp"

namespace {

using namespace weir;
using pipeline::Pipeline;
using pipeline::with;
using pipeline::with_element;

template <class Get>
int get_text(weir_pipeline* pipeline, const char* name, const char* property, char** text,
             weir_error** error, Get get) {
  const auto copy = [&](GstElement* e) -> Status {
    const auto got = get(e, property);
    if (!got) return got.error();
    *text = g_strdup(got->c_str());
    return ok();
  };
  if (text) *text = nullptr;
  return with_element(pipeline, name, error, copy, property, text);
}

}  // namespace

int weir_pipeline_elements(weir_pipeline* pipeline, weir_element_function function, void* data,
                           weir_error** error) {
  const auto list = [&](Pipeline& p) {
    for (const auto& element : pipeline::element_list(p.bin()))
      function(element.name.c_str(), element.kind.c_str(), element.depth, data);
    return ok();
  };
  const void* given = function ? pipeline : nullptr;
  return with(pipeline, error, list, static_cast<const char*>(given));
}

GstElement* weir_pipeline_get_element(weir_pipeline* pipeline, const char* name) {
  if (!pipeline) return nullptr;
  const Pipeline& p = *pipeline->pipeline;
  if (!name) return GST_ELEMENT(gst_object_ref(p.bin()));
  auto found = p.element(name);
  return found ? found->release() : nullptr;
}

int weir_pipeline_pads(weir_pipeline* pipeline, const char* name, weir_pad_function function,
                       void* data, weir_error** error) {
  const auto list = [&](GstElement* e) {
    for (const auto& pad : pipeline::pad_list(e)) function(pad.name.c_str(), pad.source, data);
    return ok();
  };
  const void* given = function ? name : nullptr;
  return with_element(pipeline, name, error, list, static_cast<const char*>(given));
}

int weir_pipeline_property_type(weir_pipeline* pipeline, const char* name, const char* property,
                                weir_error** error) {
  int type = 0;
  const auto ask = [&](GstElement* e) -> Status {
    const auto found = pipeline::property_type(e, property);
    if (found) type = *found;
    return found ? ok() : Status(found.error());
  };
  const int result = with_element(pipeline, name, error, ask, property);
  return result < 0 ? result : type;
}

int weir_pipeline_get_enum(weir_pipeline* pipeline, const char* name, const char* property,
                           int32_t* value, weir_error** error) {
  const auto ask = [&](GstElement* e) -> Status {
    const auto found = pipeline::get_enum(e, property);
    if (found) *value = *found;
    return found ? ok() : Status(found.error());
  };
  return with_element(pipeline, name, error, ask, property, value);
}

int weir_pipeline_set_valve(weir_pipeline* pipeline, const char* name, int open,
                            weir_error** error) {
  return with_element(pipeline, name, error,
                      [&](GstElement* e) { return pipeline::set_valve(e, open != 0); });
}

int weir_pipeline_select(weir_pipeline* pipeline, const char* name, const char* pad,
                         weir_error** error) {
  return with_element(
      pipeline, name, error, [&](GstElement* e) { return pipeline::select_pad(e, pad); }, pad);
}

int weir_pipeline_set(weir_pipeline* pipeline, const char* name, const char* property,
                      const char* value, weir_error** error) {
  return with(
      pipeline, error, [&](Pipeline& p) { return p.set(name, property, value); }, name, property,
      value);
}

int weir_pipeline_get(weir_pipeline* pipeline, const char* name, const char* property, char** value,
                      weir_error** error) {
  return get_text(pipeline, name, property, value, error, pipeline::get_property);
}

int weir_pipeline_get_json(weir_pipeline* pipeline, const char* name, const char* property,
                           char** json, weir_error** error) {
  return get_text(pipeline, name, property, json, error, pipeline::get_property_json);
}

void weir_pipeline_text_free(char* text) {
  g_free(text);
}
