// The plug-in: registers the elements and the tracer, nothing else.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include "conflicting_plugins.hpp"
#include "core/infer/module/host.hpp"
#include "core/process/process_object.hpp"
#include "gstcpp/element/documentation.hpp"
#include "gstcpp/element/log.hpp"
#include "library/process.h"

// One line for each folder in src/elements.
#define WEIR_ELEMENTS(X) \
  X(datareposink)        \
  X(datareposrc)         \
  X(join)                \
  X(tensor_aggregator)   \
  X(tensor_converter)    \
  X(tensor_crop)         \
  X(tensor_debug)        \
  X(tensor_decoder)      \
  X(tensor_demux)        \
  X(tensor_filter)       \
  X(tensor_from_roi)     \
  X(tensor_if)           \
  X(tensor_merge)        \
  X(tensor_mux)          \
  X(tensor_overlay)      \
  X(tensor_preprocess)   \
  X(tensor_rate)         \
  X(tensor_reposink)     \
  X(tensor_reposrc)      \
  X(tensor_sink)         \
  X(tensor_sparse_dec)   \
  X(tensor_sparse_enc)   \
  X(tensor_split)        \
  X(tensor_to_roi)       \
  X(tensor_tracker)      \
  X(tensor_transform)    \
  X(tensor_zones)

namespace weir {
#define WEIR_DECLARE(name) bool register_##name(GstPlugin*);
WEIR_ELEMENTS(WEIR_DECLARE)
bool register_tracer(GstPlugin*);
}  // namespace weir

static gboolean plugin_init(GstPlugin* plugin) {
  // Before the first use of a process-wide object.
  weir::process::take_objects_from(weir_process_object);
  weir::infer::set_log_function(weir::gst::log_module_line);
  const bool yields_to = weir::plugin::yields_to(plugin);
  bool registered = weir::register_tracer(plugin);
#define WEIR_REGISTER(name)                                   \
  if (!yields_to || weir::plugin::is_only_of_weir(#name)) {   \
    weir::plugin::warn_of_another(plugin, #name);             \
    registered = registered && weir::register_##name(plugin); \
  }
  WEIR_ELEMENTS(WEIR_REGISTER)
  return registered;
}

GST_PLUGIN_DEFINE(GST_VERSION_MAJOR, GST_VERSION_MINOR, weir,
                  "Neural networks as filters of streams", plugin_init, VERSION, "LGPL", PACKAGE,
                  weir::gst::documentation_link("README.md"))
