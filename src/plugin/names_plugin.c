/* An empty plug-in with the name of one of NNStreamer's, for programs and scripts that look for the
 * plug-in and not for its elements, such as `gst-inspect-1.0 nnstreamer`. The file is not called
 * as NNStreamer's is, so that both can be installed.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <gst/gst.h>

#define NAME_OF_FUNCTION(file) gst_plugin_##file##_get_desc
#define FUNCTION_OF(file) NAME_OF_FUNCTION(file)

static gboolean plugin_init(GstPlugin* plugin) {
  (void)plugin;
  return TRUE;
}

static const GstPluginDesc desc = {GST_VERSION_MAJOR,
                                   GST_VERSION_MINOR,
                                   WEIR_PLUGIN_NAME,
                                   "The name of a plug-in of NNStreamer; Weir's have the elements",
                                   plugin_init,
                                   VERSION,
                                   "LGPL",
                                   PACKAGE,
                                   "weir",
                                   "https://gstreamer.freedesktop.org",
                                   NULL,
                                   GST_PADDING_INIT};

/* GStreamer derives the name of the function from that of the file. */
__attribute__((visibility("default"))) const GstPluginDesc* FUNCTION_OF(WEIR_PLUGIN_FILE)(void);
const GstPluginDesc* FUNCTION_OF(WEIR_PLUGIN_FILE)(void) {
  return &desc;
}
