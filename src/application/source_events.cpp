// SPDX-License-Identifier: LGPL-2.1-or-later
#include "source_events.hpp"

#include <memory>
#include <utility>

#include "sink_callbacks.hpp"

namespace weir::application {
namespace {

using Shared = std::shared_ptr<SourceEvents>;

void release(gpointer data, GClosure*) {
  delete static_cast<Shared*>(data);
}

}  // namespace

void SourceEvents::set(const ml_pipeline_src_callbacks_s& functions, ml_pipeline_src_h handle,
                       void* data) {
  std::lock_guard lock(mutex_);
  functions_ = {functions, handle, data};
}

void SourceEvents::connect(GstElement* element) {
  const Shared self = shared_from_this();  // the handlers may hold the other references
  std::lock_guard lock(mutex_);
  for (const gulong handler : handlers_) g_signal_handler_disconnect(element_, handler);
  handlers_.clear();
  if (element) gst_object_ref(element);
  if (GstElement* const before = std::exchange(element_, element)) gst_object_unref(before);
  if (!element) return;
  const auto add = [&](const char* signal, GCallback function) {
    handlers_.push_back(g_signal_connect_data(
        element, signal, function, new Shared(shared_from_this()), release, GConnectFlags(0)));
  };
  add("need-data", G_CALLBACK(on_need_data));
  add("enough-data", G_CALLBACK(on_enough_data));
  add("seek-data", G_CALLBACK(on_seek_data));
}

void SourceEvents::close() {
  gate_.close();
  connect(nullptr);
}

SourceEvents::Functions SourceEvents::functions() const {
  std::lock_guard lock(mutex_);
  return functions_;
}

template <class Body>
void SourceEvents::call(Body&& body) {
  const infer::CallGate::Visit visit(gate_);
  if (!visit) return;
  const InCallback here(pipeline_);
  body(functions());
}

void SourceEvents::on_need_data(GstElement*, guint length, gpointer data) {
  const Shared self = *static_cast<Shared*>(data);
  self->call([length](const Functions& f) {
    if (f.functions.need_data) f.functions.need_data(f.handle, length, f.data);
  });
}

void SourceEvents::on_enough_data(GstElement*, gpointer data) {
  const Shared self = *static_cast<Shared*>(data);
  self->call([](const Functions& f) {
    if (f.functions.enough_data) f.functions.enough_data(f.handle, f.data);
  });
}

gboolean SourceEvents::on_seek_data(GstElement*, guint64 offset, gpointer data) {
  const Shared self = *static_cast<Shared*>(data);
  self->call([offset](const Functions& f) {
    if (f.functions.seek_data) f.functions.seek_data(f.handle, offset, f.data);
  });
  return TRUE;
}

}  // namespace weir::application
