// The GStreamer base classes that an element may use; binds their slots by method name.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/base/gstbasesink.h>
#include <gst/base/gstbasetransform.h>
#include <gst/base/gstpushsrc.h>

#include "gstcpp/element/element.hpp"
#include "gstcpp/element/own_thread_query.hpp"

namespace weir::gst {

#define WEIR_BIND_SLOT(name) \
  if constexpr (requires { &Impl::name; }) E::template bind<&Impl::name>(k->name)

struct BaseTransform {
  using Instance = GstBaseTransform;
  using Class = GstBaseTransformClass;
  static GType type() { return GST_TYPE_BASE_TRANSFORM; }

  template <class Impl>
  static void bind_all(Class* k) {
    using E = Element<Impl, BaseTransform>;
    WEIR_BIND_SLOT(start);
    WEIR_BIND_SLOT(stop);
    WEIR_BIND_SLOT(set_caps);
    WEIR_BIND_SLOT(transform_caps);
    WEIR_BIND_SLOT(fixate_caps);
    WEIR_BIND_SLOT(transform_size);
    WEIR_BIND_SLOT(get_unit_size);
    WEIR_BIND_SLOT(decide_allocation);
    WEIR_BIND_SLOT(propose_allocation);
    WEIR_BIND_SLOT(prepare_output_buffer);
    WEIR_BIND_SLOT(before_transform);
    WEIR_BIND_SLOT(submit_input_buffer);
    WEIR_BIND_SLOT(transform);
    WEIR_BIND_SLOT(transform_ip);
    WEIR_BIND_SLOT(sink_event);
    WEIR_BIND_SLOT(src_event);
    WEIR_BIND_SLOT(query);
    keep_queries_on_own_thread_in<Impl>(k);
  }

 private:
  // The base class sends the query after new caps, and when its source pad needs to reconfigure:
  // before a buffer, or before it handles an ALLOCATION query.
  template <class Impl>
  static void keep_queries_on_own_thread_in(Class* k) {
    static const auto event = k->sink_event;
    static const auto submit = k->submit_input_buffer;
    static const auto query = k->query;
    k->sink_event = [](Instance* self, GstEvent* e) {
      if (GST_EVENT_TYPE(e) == GST_EVENT_CAPS) keep_queries<Impl>(self);
      CapsTrial trial(GST_ELEMENT_CAST(self), e);
      return trial.ended(event(self, e));
    };
    k->submit_input_buffer = [](Instance* self, gboolean discont, GstBuffer* buffer) {
      Element<Impl, BaseTransform>::log_buffer(self, buffer);
      if (GST_PAD_NEEDS_RECONFIGURE(GST_BASE_TRANSFORM_SRC_PAD(self))) keep_queries<Impl>(self);
      return submit(self, discont, buffer);
    };
    k->query = [](Instance* self, GstPadDirection direction, GstQuery* q) {
      if (GST_QUERY_TYPE(q) == GST_QUERY_ALLOCATION) keep_queries<Impl>(self);
      const CapsTrial trial(GST_ELEMENT_CAST(self), q);
      return query(self, direction, q);
    };
  }
  // Installed only once frames flow: a probe costs each frame as much as a push.
  template <class Impl>
  static void keep_queries(Instance* self) {
    const Ledger* ledger = Element<Impl, BaseTransform>::get_ledger(self);
    if (ledger && frames_flow(*ledger))
      keep_queries_on_own_thread(GST_BASE_TRANSFORM_SRC_PAD(self), ledger);
  }
};

struct BaseSink {
  using Instance = GstBaseSink;
  using Class = GstBaseSinkClass;
  static GType type() { return GST_TYPE_BASE_SINK; }

  template <class Impl>
  static void bind_all(Class* k) {
    using E = Element<Impl, BaseSink>;
    WEIR_BIND_SLOT(start);
    WEIR_BIND_SLOT(stop);
    WEIR_BIND_SLOT(set_caps);
    WEIR_BIND_SLOT(event);
    WEIR_BIND_SLOT(query);
    WEIR_BIND_SLOT(propose_allocation);
    WEIR_BIND_SLOT(render);
    static const auto render = k->render;
    k->render = [](Instance* self, GstBuffer* buffer) {
      E::log_buffer(self, buffer);
      return render(self, buffer);
    };
    WEIR_BIND_SLOT(unlock);
    WEIR_BIND_SLOT(unlock_stop);
    static const auto handler = k->event;
    k->event = [](Instance* self, GstEvent* e) {
      CapsTrial trial(GST_ELEMENT_CAST(self), e);
      return trial.ended(handler(self, e));
    };
  }
};

// A source that makes its buffers in create(), one at a time.
struct PushSource {
  using Instance = GstPushSrc;
  using Class = GstPushSrcClass;
  static GType type() { return GST_TYPE_PUSH_SRC; }

  template <class Impl>
  static void bind_all(Class* push) {
    using E = Element<Impl, PushSource>;
    if constexpr (requires { &Impl::create; }) E::template bind<&Impl::create>(push->create);
    GstBaseSrcClass* k = &push->parent_class;
    WEIR_BIND_SLOT(start);
    WEIR_BIND_SLOT(stop);
    WEIR_BIND_SLOT(get_caps);
    WEIR_BIND_SLOT(negotiate);
    WEIR_BIND_SLOT(decide_allocation);
    WEIR_BIND_SLOT(unlock);
    WEIR_BIND_SLOT(unlock_stop);
  }
};

// A plain GstElement: Impl makes its pads in constructed() or on request.
struct PlainElement {
  using Instance = GstElement;
  using Class = GstElementClass;
  static GType type() { return GST_TYPE_ELEMENT; }

  template <class Impl>
  static void bind_all([[maybe_unused]] Class* k) {
    using E = Element<Impl, PlainElement>;
    WEIR_BIND_SLOT(request_new_pad);
    WEIR_BIND_SLOT(release_pad);
  }
};

#undef WEIR_BIND_SLOT

}  // namespace weir::gst
