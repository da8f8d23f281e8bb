// Finds the tracer by its name, because a plug-in provides it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/trace_session.hpp"

#define GST_USE_UNSTABLE_API
#include <gst/gsttracer.h>
#include <gst/gsttracerfactory.h>

namespace weir::app {
namespace {

gst::Ref<GstObject> running_tracer(GType type) {
  gst::Ref<GstObject> found;
  GList* all = gst_tracing_get_active_tracers();
  for (GList* item = all; item; item = item->next)
    if (!found && G_OBJECT_TYPE(item->data) == type)
      found = gst::Ref<GstObject>::share(GST_OBJECT(item->data));
  g_list_free_full(all, gst_object_unref);
  return found;
}

}  // namespace

Result<TraceSession> TraceSession::start() {
  const auto feature = gst::Ref<GstPluginFeature>::adopt(
      gst_registry_find_feature(gst_registry_get(), "weir", GST_TYPE_TRACER_FACTORY));
  const auto loaded =
      gst::Ref<GstPluginFeature>::adopt(feature ? gst_plugin_feature_load(feature.get()) : nullptr);
  if (!loaded)
    return Error{.code = Code::FILE_NOT_FOUND,
                 .what = "the tracer weir is not found",
                 .needed = "the plug-in libgstweir.so of this version",
                 .fix = "weir doctor"};
  const GType type =
      gst_tracer_factory_get_tracer_type(reinterpret_cast<GstTracerFactory*>(loaded.get()));
  auto tracer = running_tracer(type);
  if (!tracer)
    tracer = gst::Ref<GstObject>::adopt(
        GST_OBJECT(g_object_ref_sink(g_object_new(type, "params", "file=", nullptr))));
  return TraceSession(std::move(tracer));
}

Json TraceSession::summary() const {
  char* raw = nullptr;
  g_object_get(tracer_.get(), "summary", &raw, nullptr);
  const gst::UniqueText text(raw);
  Json out = text ? Json::parse(text.get(), nullptr, false) : Json();
  return out.is_object() ? out : Json::object();
}

}  // namespace weir::app
