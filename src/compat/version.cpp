// The release of the interface.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <glib.h>

#include "nnstreamer_plugin_api_util.h"
#include "nnstreamer_version.h"

gchar* nnstreamer_version_string(void) {
  return g_strdup("NNStreamer " NNSTREAMER_VERSION);
}

void nnstreamer_version_fetch(guint* major, guint* minor, guint* micro) {
  if (major) *major = NNSTREAMER_VERSION_MAJOR;
  if (minor) *minor = NNSTREAMER_VERSION_MINOR;
  if (micro) *micro = NNSTREAMER_VERSION_MICRO;
}
