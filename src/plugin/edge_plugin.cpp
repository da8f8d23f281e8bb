// The plug-in weiredge: registers the elements that talk to other processes and machines and need
// no gRPC, nothing else.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include "conflicting_plugins.hpp"
#include "core/process/process_object.hpp"
#include "gstcpp/element/documentation.hpp"
#include "library/process.h"

#ifdef WEIR_HAS_MQTT
#define WEIR_MQTT_ELEMENTS(X) \
  X(mqttsink)                 \
  X(mqttsrc)
#else
#define WEIR_MQTT_ELEMENTS(X)
#endif

// One line for each element.
#define WEIR_EDGE_ELEMENTS(X) \
  X(edgesink)                 \
  X(edgesrc)                  \
  X(tensor_query_client)      \
  X(tensor_query_serversink)  \
  X(tensor_query_serversrc)   \
  WEIR_MQTT_ELEMENTS(X)

namespace weir {
#define WEIR_DECLARE(name) bool register_##name(GstPlugin*);
WEIR_EDGE_ELEMENTS(WEIR_DECLARE)
}  // namespace weir

static gboolean plugin_init(GstPlugin* plugin) {
  // Before the first use of a process-wide object.
  weir::process::take_objects_from(weir_process_object);
  if (weir::plugin::yields_to(plugin)) return TRUE;  // NNStreamer has all of them
  bool registered = true;
#define WEIR_REGISTER(name)                     \
  weir::plugin::warn_of_another(plugin, #name); \
  registered = registered && weir::register_##name(plugin);
  WEIR_EDGE_ELEMENTS(WEIR_REGISTER)
  return registered;
}

GST_PLUGIN_DEFINE(GST_VERSION_MAJOR, GST_VERSION_MINOR, weiredge,
                  "Streams of tensors between processes and machines", plugin_init, VERSION, "LGPL",
                  PACKAGE, weir::gst::documentation_link("README.md"))
