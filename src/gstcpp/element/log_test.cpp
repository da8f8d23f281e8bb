// Log lines of modules: category, level, and standard error for errors that GST_DEBUG hides.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/log.hpp"

#include <gtest/gtest.h>

#include <string>

#include "weir/abi.h"

namespace weir::gst {
namespace log_test {

// The lines that GStreamer logs while the object exists: "LEVEL category: text".
class Lines {
 public:
  explicit Lines(const char* thresholds) {
    (gst_debug_remove_log_function)(nullptr);  // the default one
    (gst_debug_add_log_function)(add, this, nullptr);
    gst_debug_set_active(TRUE);
    gst_debug_set_threshold_from_string(thresholds, TRUE);
  }
  Lines(const Lines&) = delete;
  Lines& operator=(const Lines&) = delete;
  ~Lines() {
    gst_debug_remove_log_function_by_data(this);
    gst_debug_set_threshold_from_string("0", TRUE);
  }
  std::string text;

 private:
  static void add(GstDebugCategory* category, GstDebugLevel level, const char*, const char*, gint,
                  GObject*, GstDebugMessage* message, gpointer self) {
    const std::string name = gst_debug_category_get_name(category);
    if (name.starts_with("weir") && level <= gst_debug_category_get_threshold(category))
      static_cast<Lines*>(self)->text += std::string(gst_debug_level_get_name(level)) + " " + name +
                                         ": " + gst_debug_message_get(message) + "\n";
  }
};

std::string printed(const char* thresholds, int level, const char* module, std::string* logged) {
  testing::internal::CaptureStderr();
  Lines lines(thresholds);
  log_module_line(level, module, "a line");
  *logged = lines.text;
  return testing::internal::GetCapturedStderr();
}

TEST(ModuleLog, HasACategoryForEachModule) {
  std::string logged;
  EXPECT_EQ(printed("weir-python3:5", WEIR_LOG_DEBUG, "python3", &logged), "");
  EXPECT_EQ(logged.substr(logged.find("weir-")), "weir-python3: a line\n");
  EXPECT_EQ(printed("weir-python3:5", WEIR_LOG_DEBUG, "lua", &logged), "");
  EXPECT_EQ(logged, "") << "another module is not selected";
}

TEST(ModuleLog, ReachesGstDebugAtEachLevel) {
  for (const int level : {WEIR_LOG_ERROR, WEIR_LOG_WARNING, WEIR_LOG_INFO, WEIR_LOG_DEBUG}) {
    std::string logged;
    EXPECT_EQ(printed("weir*:5", level, "onnxruntime", &logged), "") << level;
    EXPECT_NE(logged.find("weir-onnxruntime: a line"), std::string::npos) << level;
  }
}

TEST(ModuleLog, UsesTheLibraryCategoryForInvalidModuleNames) {
  std::string logged;
  EXPECT_EQ(printed("weir:4", WEIR_LOG_INFO, "libweir-converter-x.so", &logged), "");
  EXPECT_NE(logged.find("weir: libweir-converter-x.so: a line"), std::string::npos) << logged;
}

TEST(ModuleLog, WritesHiddenWarningsToStandardError) {
  std::string logged;
  EXPECT_EQ(printed("0", WEIR_LOG_WARNING, "lua", &logged), "weir: lua: a line\n");
  EXPECT_EQ(logged, "");
  EXPECT_EQ(printed("0", WEIR_LOG_INFO, "lua", &logged), "") << "INFO is only for GST_DEBUG";
}

TEST(ElementLog, UsesTheLibraryCategoryForTypesWithoutCategory) {
  GstElement* const element = gst_element_factory_make("bin", nullptr);
  ASSERT_TRUE(element);
  EXPECT_STREQ(gst_debug_category_get_name(get_category(element)), "weir");
  set_category(G_OBJECT_TYPE(element), debug_category("test-bin", "a test"));
  EXPECT_STREQ(gst_debug_category_get_name(get_category(element)), "test-bin");
  set_category(G_OBJECT_TYPE(element), nullptr);  // the type lives as long as the process
  EXPECT_STREQ(gst_debug_category_get_name(get_category(element)), "weir");
  gst_object_unref(element);
}

}  // namespace log_test
}  // namespace weir::gst
