// The tracer `weir`: a GObject that owns a PipelineTracer and registers its hooks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#define GST_USE_UNSTABLE_API
#include <gst/gst.h>
#include <gst/gsttracer.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>

#include "core/trace/options.hpp"
#include "core/trace/trace_events.hpp"
#include "tracer/pipeline_tracer.hpp"

namespace weir::tracer {
namespace {

struct State {
  trace::Options options;
  std::unique_ptr<PipelineTracer> tracer;
  bool written = false;
};

struct Instance {
  GstTracer parent;
  State* state;  // null when memory runs out
};
struct Class {
  GstTracerClass parent;
};

gpointer parent_class = nullptr;
enum Property { kSummary = 1 };

// An exception in a hook must not reach the pipeline; the record is lost then.
template <auto Method, class... Words>
void hook(GObject* self, GstClockTime time, Words... words) noexcept {
  PipelineTracer* tracer = reinterpret_cast<Instance*>(self)->state->tracer.get();
  try {
    (tracer->*Method)(static_cast<int64_t>(time), words...);
  } catch (...) {
  }
}

void push_ends(GObject* self, GstClockTime time, GstPad* pad, GstFlowReturn result) noexcept {
  hook<&PipelineTracer::push_ends>(self, time, pad, result);
}
void pull_begins(GObject* self, GstClockTime time, GstPad* pad, guint64, guint) noexcept {
  hook<&PipelineTracer::pull_begins>(self, time, pad);
}
void event_ends(GObject* self, GstClockTime time, GstPad* pad, gboolean good) noexcept {
  hook<&PipelineTracer::event_ends>(self, time, pad, good != FALSE);
}
void state_ends(GObject* self, GstClockTime time, GstElement* element, GstStateChange,
                GstStateChangeReturn result) noexcept {
  hook<&PipelineTracer::state_ends>(self, time, element, result != GST_STATE_CHANGE_FAILURE);
}
void element_added(GObject* self, GstClockTime time, GstBin*, GstElement* element,
                   gboolean good) noexcept {
  if (good) hook<&PipelineTracer::element_is_new>(self, time, element);
}
void element_removed(GObject* self, GstClockTime time, GstBin*, GstElement* element,
                     gboolean good) noexcept {
  if (good) hook<&PipelineTracer::element_is_removed>(self, time, element);
}
void pads_linked(GObject* self, GstClockTime time, GstPad* source, GstPad* sink,
                 GstPadLinkReturn result) noexcept {
  if (result == GST_PAD_LINK_OK) hook<&PipelineTracer::pads_are_linked>(self, time, source, sink);
}
void pads_unlinked(GObject* self, GstClockTime time, GstPad* source, GstPad* sink,
                   gboolean good) noexcept {
  if (good) hook<&PipelineTracer::pads_are_unlinked>(self, time, source, sink);
}
void object_destroyed(GObject* self, GstClockTime time, GstObject* object) noexcept {
  hook<&PipelineTracer::object_is_destroyed>(self, time, static_cast<const void*>(object));
}

template <class... Words>
using Method = void (PipelineTracer::*)(int64_t, Words...);

void register_hooks(GstTracer* self) {
  const auto add = [self](const char* name, auto* function) {
    gst_tracing_register_hook(self, name, reinterpret_cast<GCallback>(function));
  };
  constexpr Method<GstPad*, GstBuffer*> kPush = &PipelineTracer::push_begins;
  constexpr Method<GstPad*, GstBufferList*> kPushList = &PipelineTracer::push_begins;
  add("pad-push-pre", hook<kPush, GstPad*, GstBuffer*>);
  add("pad-push-post", push_ends);
  add("pad-push-list-pre", hook<kPushList, GstPad*, GstBufferList*>);
  add("pad-push-list-post", push_ends);
  add("pad-pull-range-pre", pull_begins);
  add("pad-pull-range-post", hook<&PipelineTracer::pull_ends, GstPad*, GstBuffer*, GstFlowReturn>);
  add("pad-push-event-pre", hook<&PipelineTracer::event_begins, GstPad*, GstEvent*>);
  add("pad-push-event-post", event_ends);
  add("element-change-state-pre", hook<&PipelineTracer::state_begins, GstElement*, GstStateChange>);
  add("element-change-state-post", state_ends);
  add("element-new", hook<&PipelineTracer::element_is_new, GstElement*>);
  add("element-add-pad", hook<&PipelineTracer::pad_is_added, GstElement*, GstPad*>);
  add("bin-add-post", element_added);
  add("bin-remove-post", element_removed);
  add("pad-link-post", pads_linked);
  add("pad-unlink-post", pads_unlinked);
  add("object-destroyed", object_destroyed);
}

void write_file(State* state) noexcept {
  if (state->written || state->options.file.empty()) return;
  state->written = true;
  try {
    std::ofstream file(state->options.file);
    trace::write_trace_events(state->tracer->trace(), file);
    file.close();
    if (file) return;
    const Error error{.code = Code::FILE_NOT_WRITTEN,
                      .what = "the trace cannot be written",
                      .offered = state->options.file,
                      .needed = "a writable path",
                      .difference = std::string(std::strerror(errno)),
                      .fix = "GST_TRACERS=\"weir(file=/tmp/trace.json)\""};
    std::fprintf(stderr, "%s\n", error.message().c_str());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "weir: the trace cannot be written: %s\n", error.what());
  }
}

// If a program does not call gst_deinit(), its tracers exist until it exits, so the pointers stay
// valid.
std::vector<State*>& with_files() {
  static auto* all = new std::vector<State*>;
  return *all;
}
void write_all() {
  for (State* state : with_files()) write_file(state);
}

void constructed(GObject* object) {
  G_OBJECT_CLASS(parent_class)->constructed(object);
  auto* self = reinterpret_cast<Instance*>(object);
  char* params = nullptr;
  g_object_get(object, "params", &params, nullptr);
  try {
    auto state = std::make_unique<State>();
    auto options = trace::read_options(params ? params : "");
    if (options)
      state->options = *options;
    else
      std::fprintf(stderr, "%s\n", options.error().message().c_str());
    state->tracer = std::make_unique<PipelineTracer>(state->options.limit);
    if (!state->options.file.empty()) {
      static const int registered = std::atexit(write_all);
      static_cast<void>(registered);
      with_files().push_back(state.get());
    }
    self->state = state.release();
    register_hooks(&self->parent);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "weir: nothing is traced: %s\n", error.what());
  }
  g_free(params);
}

void finalize(GObject* object) {
  auto* self = reinterpret_cast<Instance*>(object);
  if (self->state) {
    write_file(self->state);
    std::erase(with_files(), self->state);
    delete self->state;
  }
  G_OBJECT_CLASS(parent_class)->finalize(object);
}

void get_property(GObject* object, guint id, GValue* value, GParamSpec* spec) {
  const auto* self = reinterpret_cast<Instance*>(object);
  if (id != kSummary) {
    G_OBJECT_WARN_INVALID_PROPERTY_ID(object, id, spec);
    return;
  }
  try {
    if (!self->state) return;
    const trace::Trace trace = self->state->tracer->trace();
    g_value_set_string(value, trace::to_json(trace::summarise(trace), trace).c_str());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "weir: the trace cannot be summarised: %s\n", error.what());
  }
}

void class_init(gpointer klass, gpointer) {
  parent_class = g_type_class_peek_parent(klass);
  auto* object_class = G_OBJECT_CLASS(klass);
  object_class->constructed = constructed;
  object_class->finalize = finalize;
  object_class->get_property = get_property;
  g_object_class_install_property(
      object_class, kSummary,
      g_param_spec_string("summary", "summary",
                          "Summary of the records so far, as JSON; read it while no pipeline plays",
                          nullptr,
                          static_cast<GParamFlags>(G_PARAM_READABLE | G_PARAM_STATIC_STRINGS)));
}

}  // namespace
}  // namespace weir::tracer

namespace weir {

bool register_tracer(GstPlugin* plugin) {
  static const GType type = g_type_register_static_simple(
      GST_TYPE_TRACER, "WeirTracer", sizeof(tracer::Class), tracer::class_init,
      sizeof(tracer::Instance), nullptr, static_cast<GTypeFlags>(0));
  return gst_tracer_register(plugin, "weir", type);
}

}  // namespace weir
