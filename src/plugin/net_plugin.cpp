// The plug-in weirnet: registers what needs gRPC, nothing else.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include "conflicting_plugins.hpp"
#include "core/process/process_object.hpp"
#include "elements/oip_query_server/oip_query_server.hpp"
#include "library/process.h"

static gboolean plugin_init(GstPlugin* plugin) {
  // Before the first use of a process-wide object.
  weir::process::take_objects_from(weir_process_object);
  if (weir::plugin::yields_to(plugin)) return TRUE;  // so does weiredge
  weir::register_oip_query_server();
  return TRUE;
}

GST_PLUGIN_DEFINE(GST_VERSION_MAJOR, GST_VERSION_MINOR, weirnet,
                  "Pipelines as models for clients on other machines", plugin_init, VERSION, "LGPL",
                  PACKAGE, "https://gstreamer.freedesktop.org")
