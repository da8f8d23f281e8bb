/* Another plug-in with an element named tensor_filter and the meta of query clients, for the tests
 * of conflicting plug-ins.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
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
typedef struct {
  GstMeta meta;
  gint64 client;
} DecoyMeta;

static gboolean meta_init(GstMeta* meta, gpointer params, GstBuffer* buffer) {
  (void)params, (void)buffer;
  ((DecoyMeta*)meta)->client = 0;
  return TRUE;
}

static gboolean plugin_init(GstPlugin* plugin) {
  static const gchar* tags[] = {NULL};
  const GType api = gst_meta_api_type_register("GstMetaQueryAPI", tags);
  return gst_meta_register(api, "GstMetaQuery", sizeof(DecoyMeta), meta_init, NULL, NULL) &&
         gst_element_register(plugin, "tensor_filter", GST_RANK_NONE, decoy_get_type()) &&
         gst_element_register(plugin, "decoy_bin", GST_RANK_NONE, decoy_get_type());
}

#define PACKAGE "decoy"
GST_PLUGIN_DEFINE(GST_VERSION_MAJOR, GST_VERSION_MINOR, decoy, "Takes a name", plugin_init, "1",
                  "LGPL", "decoy", "https://gstreamer.freedesktop.org")
