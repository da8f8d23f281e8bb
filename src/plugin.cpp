// The plug-in: registers the elements and the tracer, nothing else.
#include <gst/gst.h>

namespace weir {
bool register_tensor_converter(GstPlugin*);
bool register_tensor_decoder(GstPlugin*);
bool register_tensor_demux(GstPlugin*);
bool register_tensor_filter(GstPlugin*);
bool register_tensor_preprocess(GstPlugin*);
bool register_tensor_sink(GstPlugin*);
bool register_tensor_split(GstPlugin*);
bool register_tensor_transform(GstPlugin*);
bool register_tracer(GstPlugin*);
}  // namespace weir

static gboolean plugin_init(GstPlugin* plugin) {
  return weir::register_tensor_converter(plugin) && weir::register_tensor_decoder(plugin) &&
         weir::register_tensor_demux(plugin) && weir::register_tensor_filter(plugin) &&
         weir::register_tensor_preprocess(plugin) && weir::register_tensor_sink(plugin) &&
         weir::register_tensor_split(plugin) && weir::register_tensor_transform(plugin) &&
         weir::register_tracer(plugin);
}

GST_PLUGIN_DEFINE(GST_VERSION_MAJOR, GST_VERSION_MINOR, weir,
                  "Neural networks as filters of streams", plugin_init, VERSION, "LGPL", PACKAGE,
                  "https://gstreamer.freedesktop.org")
