// Queues, sinks, live sources, and elements that synchronise to the clock or gather inputs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracer/waits.hpp"

#include <gst/base/gstbasesink.h>
#include <gst/base/gstbasesrc.h>

#include "tracer/queue_sampler.hpp"

namespace weir::tracer {
namespace {

bool is_set(GstElement* element, const char* property) {
  GParamSpec* spec = g_object_class_find_property(G_OBJECT_GET_CLASS(element), property);
  if (!spec || spec->value_type != G_TYPE_BOOLEAN || !(spec->flags & G_PARAM_READABLE))
    return false;
  gboolean value = FALSE;
  g_object_get(element, property, &value, nullptr);
  return value != FALSE;
}

bool has_several_inputs(GstElement* element) {
  GST_OBJECT_LOCK(element);
  const bool several = element->numsinkpads > 1;
  GST_OBJECT_UNLOCK(element);
  return several;
}

}  // namespace

trace::Waits waits_of(GstElement* element) {
  if (!element || GST_IS_BIN(element)) return trace::Waits::Never;
  if (WatchedQueue::can_be_watched(element)) return trace::Waits::Room;
  if (GST_IS_BASE_SRC(element))
    return gst_base_src_is_live(GST_BASE_SRC(element)) ? trace::Waits::Device : trace::Waits::Never;
  if (is_set(element, "sync")) return trace::Waits::Clock;
  if (GST_IS_BASE_SINK(element)) return trace::Waits::Start;
  return has_several_inputs(element) ? trace::Waits::Inputs : trace::Waits::Never;
}

}  // namespace weir::tracer
