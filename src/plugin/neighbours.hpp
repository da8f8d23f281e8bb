// Living beside another plug-in that has elements of the same names.
#pragma once
#include <gst/gst.h>

namespace weir::plugin {

// [plugin] give_way of weir.ini, WEIR_PLUGIN_GIVE_WAY: names that NNStreamer has are left to it.
// GStreamer's registry looks at the plug-in again when the setting changes.
bool gives_way(GstPlugin* plugin);
// Names that no element of NNStreamer has.
bool is_only_of_weir(const char* element) noexcept;
// A line in GStreamer's log when another plug-in of this process has the name, which it loses now.
void tell_of_another(GstPlugin* plugin, const char* element);

}  // namespace weir::plugin
