/* Another plug-in with an element named tensor_filter, for the tests of `weir doctor`. */
#include <gst/gst.h>

typedef GstBin Decoy;
typedef GstBinClass DecoyClass;
GType decoy_get_type(void);
G_DEFINE_TYPE(Decoy, decoy, GST_TYPE_BIN)

static void decoy_class_init(DecoyClass* klass) {
  gst_element_class_set_static_metadata(GST_ELEMENT_CLASS(klass), "Decoy", "Test", "Takes a name",
                                        "The Weir developers");
}
static void decoy_init(Decoy* self) {
  (void)self;
}
static gboolean plugin_init(GstPlugin* plugin) {
  return gst_element_register(plugin, "tensor_filter", GST_RANK_NONE, decoy_get_type());
}

#define PACKAGE "decoy"
GST_PLUGIN_DEFINE(GST_VERSION_MAJOR, GST_VERSION_MINOR, decoy, "Takes a name", plugin_init, "1",
                  "LGPL", "decoy", "https://gstreamer.freedesktop.org")
