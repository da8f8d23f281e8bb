// Handles conflicting plug-ins: others that have elements with the same names.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

namespace weir::plugin {

// Reads [plugin] prefer_nnstreamer of weir.ini or WEIR_PLUGIN_PREFER_NNSTREAMER: whether names that
// NNStreamer has are left to it. GStreamer's registry reloads the plug-in when the setting changes.
bool yields_to(GstPlugin* plugin);
// Whether NNStreamer has no element of this name.
bool is_only_of_weir(const char* element) noexcept;
// Logs a warning when another plug-in of this process has the name, which Weir now replaces.
void warn_of_another(GstPlugin* plugin, const char* element);

}  // namespace weir::plugin
