// Runs the element tests of the files that it is given, or all; at the end the leaks tracer must
// report nothing.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>

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

// Folder and name: what is before them depends on where a compiler ran.
std::string short_path(const char* file) {
  const std::filesystem::path path(file);
  return path.parent_path().filename() / path.filename();
}

// False if the file has no test.
bool add_tests(const std::string& file, std::string* filter) {
  const auto size = filter->size();
  const auto& tests = *testing::UnitTest::GetInstance();
  for (int i = 0; i < tests.total_test_suite_count(); ++i) {
    const auto& suite = *tests.GetTestSuite(i);
    for (int j = 0; j < suite.total_test_count(); ++j) {
      const auto& test = *suite.GetTestInfo(j);
      if (short_path(test.file()) == file)
        *filter += std::string(suite.name()) + '.' + test.name() + ':';
    }
  }
  return filter->size() > size;
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  std::string filter;
  for (int i = 1; i < argc; ++i) {
    const auto file = short_path(argv[i]);
    if (file.ends_with("_test.cpp") && !add_tests(file, &filter)) {
      std::fprintf(stderr, "%s: no tests of this file\n", argv[i]);
      return 1;
    }
  }
  // A death test starts the program again with a filter of its own.
  if (!filter.empty() && GTEST_FLAG_GET(filter) == "*") GTEST_FLAG_SET(filter, filter);
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
