// Runs the element tests; at the end the leaks tracer must report nothing.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>

namespace {

int leaks = 0;

void count_leak(GstDebugCategory*, GstDebugLevel, const gchar*, const gchar*, gint, GObject*,
                GstDebugMessage* message, gpointer) {
  const char* text = gst_debug_message_get(message);
  if (text && std::strstr(text, "object-alive")) {
    ++leaks;
    std::fprintf(stderr, "leaked: %s\n", text);
  }
}

bool has_tracer(const char* name) {
  GstPluginFeature* feature =
      gst_registry_find_feature(gst_registry_get(), name, GST_TYPE_TRACER_FACTORY);
  if (feature) gst_object_unref(feature);
  return feature != nullptr;
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  gst_init(&argc, &argv);
  int result = RUN_ALL_TESTS();
  const char* tracers = std::getenv("GST_TRACERS");
  if (tracers && std::strstr(tracers, "leaks")) {
    if (!has_tracer("leaks")) {
      std::fprintf(stderr, "the tracer leaks is not there: libgstcoretracers.so is missing\n");
      result = 1;
    }
    (gst_debug_remove_log_function)(gst_debug_log_default);
    (gst_debug_add_log_function)(count_leak, nullptr, nullptr);
    gst_debug_set_threshold_for_name("GST_TRACER", GST_LEVEL_TRACE);
    gst_deinit();
    if (leaks > 0) {
      std::fprintf(stderr, "%d GStreamer objects leaked\n", leaks);
      result = 1;
    }
  }
  return result;
}
