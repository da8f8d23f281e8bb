// The plug-in weirnet: registers what needs gRPC, nothing else.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include <string>

#include "conflicting_plugins.hpp"
#include "core/process/process_object.hpp"
#include "gstcpp/element/documentation.hpp"
#include "gstcpp/element/log.hpp"
#include "library/process.h"
#include "net-elements/oip_query_server.hpp"
#include "net/client/link.hpp"
#include "weir/abi.h"

#ifdef WEIR_GRPC_ELEMENTS
namespace weir {
bool register_tensor_sink_grpc(GstPlugin*);
bool register_tensor_src_grpc(GstPlugin*);
}  // namespace weir
#endif

// Those that need the libraries of both schemas of messages.
static bool register_grpc_elements([[maybe_unused]] GstPlugin* plugin) {
#ifdef WEIR_GRPC_ELEMENTS
  weir::plugin::warn_of_another(plugin, "tensor_sink_grpc");
  weir::plugin::warn_of_another(plugin, "tensor_src_grpc");
  return weir::register_tensor_sink_grpc(plugin) && weir::register_tensor_src_grpc(plugin);
#else
  return true;
#endif
}

// gRPC prints its log on standard error, also what elements report as errors.
static void take_log_of_grpc() {
  weir::net::Link::set_log([](bool error, const std::string& text) {
    weir::gst::log_module_line(error ? WEIR_LOG_INFO : WEIR_LOG_DEBUG, "net", text.c_str());
  });
}

static gboolean plugin_init(GstPlugin* plugin) {
  // Before the first use of a process-wide object.
  weir::process::take_objects_from(weir_process_object);
  if (weir::plugin::yields_to(plugin)) return TRUE;  // so does weiredge
  take_log_of_grpc();
  weir::register_oip_query_server();
  return register_grpc_elements(plugin);
}

GST_PLUGIN_DEFINE(GST_VERSION_MAJOR, GST_VERSION_MINOR, weirnet,
                  "Pipelines as models for clients on other machines", plugin_init, VERSION, "LGPL",
                  PACKAGE, weir::gst::documentation_link("README.md"))
