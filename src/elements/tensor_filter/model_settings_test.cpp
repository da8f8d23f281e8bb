// How the properties of tensor_filter select engine, accelerator and layouts; config-file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/adder_test_support.hpp"

namespace model_settings_test {

using namespace weir::test;

std::string get_accelerator(GstElement* filter) {
  const auto all = stats(filter);
  const char* text = gst_structure_get_string(all.get(), "accelerator");
  return text ? text : "none there";
}
// A running element and its warnings.
struct Started {
  explicit Started(const std::string& launch) : element(lone_element(launch)) {
    Errors messages(element.get());
    EXPECT_EQ(gst_element_set_state(element.get(), GST_STATE_PAUSED), GST_STATE_CHANGE_SUCCESS);
    warning = messages.next_warning();
  }
  ~Started() { gst_element_set_state(element.get(), GST_STATE_NULL); }
  Ref<GstElement> element;
  std::string warning;
};

TEST(ModelSettings, ChoosesAnAcceleratorThatTheEngineSupports) {
  const AdderFiles files;
  const std::pair<const char*, const char*> cases[] = {
      {"", ""},
      {"false", "none"},
      {"true", "gpu"},
      {"true:cpu", "cpu"},
      {"true:npu,cpu,gpu", "cpu"},
      {"TRUE:npu,auto,!gpu", "cpu"},
  };
  for (const auto& [text, chosen] : cases) {
    const Started filter(adder(files.model(1), std::string("accelerator=\"") + text + "\""));
    EXPECT_EQ(get_accelerator(filter.element.get()), chosen) << text;
    EXPECT_EQ(text_property(filter.element.get(), "accelerator"), text) << "reads as it was set";
    EXPECT_EQ(filter.warning, "");
  }
}

TEST(ModelSettings, WarnsAboutHardwareThatTheEngineDoesNotHave) {
  const AdderFiles files;
  const Started filter(adder(files.model(1), "accelerator=true:npu,!gpu"));
  EXPECT_EQ(get_accelerator(filter.element.get()), "cpu");
  EXPECT_SAYS(filter.warning, "WEIR-1004: the engine adder has no accelerator npu: cpu is used");
  EXPECT_SAYS(filter.warning, "fix: accelerator=true:cpu");
}

// The worker process alone knows what the engine has.
TEST(ModelSettings, WarnAboutHardwareThatTheEngineOfAWorkerProcessDoesNotHave) {
  const AdderFiles files;
  const Started filter(adder(files.model(1), "isolate=process accelerator=true:npu,!gpu"));
  EXPECT_EQ(get_accelerator(filter.element.get()), "cpu");
  EXPECT_SAYS(filter.warning, "WEIR-1004: the engine adder has no accelerator npu: cpu is used");
  EXPECT_SAYS(filter.warning, "fix: accelerator=true:cpu");
  const Started other(adder(files.model(1), "isolate=process accelerator=true:npu,cpu"));
  EXPECT_EQ(get_accelerator(other.element.get()), "cpu");
  EXPECT_EQ(other.warning, "");
  EXPECT_EQ(get_accelerator(Started(adder(files.model(1), "isolate=process")).element.get()), "");
}

TEST(ModelSettings, WarnsAboutAnUnreadableAccelerator) {
  const AdderFiles files;
  const Started filter(adder(files.model(1), "accelerator=true:gqu"));
  EXPECT_EQ(get_accelerator(filter.element.get()), "none");
  EXPECT_SAYS(filter.warning, "at \"gqu\", did you mean gpu?");
}

// Programs take a warning on the bus for a failure.
TEST(ModelSettings, LogAnUnknownLayout) {
  const AdderFiles files;
  testing::internal::CaptureStderr();
  EXPECT_EQ(Started(adder(files.model(1), "inputlayout=nhwc outputlayout=ANY")).warning, "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  testing::internal::CaptureStderr();
  EXPECT_EQ(Started(adder(files.model(1), "outputlayout=HWC")).warning, "");
  EXPECT_SAYS(testing::internal::GetCapturedStderr(), "offered: outputlayout=HWC");
}

TEST(ModelSettings, FindsTheFrameworkByTheModelBeforeOpening) {
  for (const char* launch :
       {"tensor_filter model=a.tflite", "tensor_filter model=a.tflite framework=auto",
        "tensor_filter framework=auto model=a.tflite",
        "tensor_filter framework=ANY model=a.tflite"})
    EXPECT_EQ(text_property(lone_element(launch).get(), "framework"), "tensorflow-lite") << launch;
  EXPECT_EQ(text_property(lone_element("tensor_filter model=a.x").get(), "framework"), "auto");
  EXPECT_EQ(text_property(lone_element("tensor_filter model=a.tflite framework=adder").get(),
                          "framework"),
            "adder");
}

TEST(ModelSettings, AcceptsFrameworkAndModelInAnyOrder) {
  const AdderFiles files;
  const std::string model = " model=" + files.model(3), framework = " framework=adder";
  for (const auto& launch :
       {"tensor_filter" + model + framework, "tensor_filter" + framework + model}) {
    auto h = make_harness(launch, kAdderCaps);
    EXPECT_EQ(pushed_sum(h), 3);
    EXPECT_EQ(text_property(find_element(h, "tensor_filter").get(), "framework"), "adder");
  }
}

TEST(ModelSettings, ShowsTheEnginesThreadsInStats) {
  const AdderFiles files;
  for (const std::string where : {"", " isolate=process"}) {
    auto h =
        make_harness("tensor_filter framework=adder model=" + files.model(3) + where, kAdderCaps);
    const auto shown = stats(find_element(h, "tensor_filter").get());
    int threads = 0;
    gboolean spinning = FALSE;
    EXPECT_TRUE(gst_structure_get_int(shown.get(), "threads", &threads)) << where;
    EXPECT_TRUE(gst_structure_get_boolean(shown.get(), "spinning", &spinning)) << where;
    EXPECT_EQ(threads, 3) << where;
    EXPECT_TRUE(spinning) << where;
  }
}

TEST(ModelSettings, ConfigFileSetsPropertiesOfEachKind) {
  const AdderFiles files;
  const auto path = files.write("filter.conf", "framework=adder\n model = " + files.model(4) +
                                                   "\nis-updatable=TRUE\nsuspend=70000\nlatency=1\n"
                                                   "a line without a sign\n");
  auto h = make_harness("tensor_filter config-file=" + path, kAdderCaps);
  const auto filter = find_element(h, "tensor_filter");
  EXPECT_EQ(pushed_sum(h), 4);
  gboolean updatable = FALSE;
  guint suspend = 0;
  g_object_get(filter.get(), "is-updatable", &updatable, "suspend", &suspend, nullptr);
  EXPECT_TRUE(updatable);
  EXPECT_EQ(suspend, 70000u);
}

TEST(ModelSettings, ConfigFileWarnsAboutUnknownKeys) {
  const AdderFiles files;
  const auto path = files.write("filter.conf", "framwork=adder\n");
  const Started filter(adder(files.model(4), "config-file=" + path));
  EXPECT_SAYS(filter.warning, "did you mean framework?");
}

TEST(ModelSettings, ConfigFileWarnsAboutInvalidValues) {
  const AdderFiles files;
  const auto path = files.write("filter.conf", "when-busy=drop-odl\n");
  const Started filter(adder(files.model(4), "config-file=" + path));
  EXPECT_SAYS(filter.warning,
              "WEIR-1004: tensor_filter does not accept this value for when-busy\n"
              "  offered: drop-odl\n  needed: one of: unset, block, drop-new, drop-old\n"
              "  first difference: did you mean drop-old?");
  const auto right = files.write("filter.conf", "when-busy=drop-old\n");
  EXPECT_EQ(Started(adder(files.model(4), "config-file=" + right)).warning, "");
}

TEST(ModelSettings, ReportsAConfigFileThatIsMissingOrAFolder) {
  const AdderFiles files;
  const auto missing = start_error(adder(files.model(4), "config-file=/nowhere/f.conf"));
  EXPECT_SAYS(missing, "WEIR-4001: the property file cannot be read");
  EXPECT_SAYS(missing, "first difference: it does not exist");
  EXPECT_SAYS(start_error(adder(files.model(4), "config-file=/tmp")),
              "first difference: it is a folder");
}

}  // namespace model_settings_test
