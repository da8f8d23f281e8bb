// tensor_filter whose properties change while frames flow, and downstream that requests other caps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/adder_test_support.hpp"
#include "elements/tests/tuning_test_support.hpp"

namespace weir::test {
namespace tensor_filter_tuning_test {

using Floats = std::vector<float>;
const Floats kFour{1, 2, 3, 4};

Tuned tuned(const std::string& line) {
  return {"tensor_filter", line, kAdderCaps};
}

TEST(FilterPropertyChange, ADownstreamSwitchToFlexibleAppliesToTheNextFrame) {
  AdderFiles files;
  auto t =
      tuned("tensor_filter framework=adder model=" + files.model(1) + " ! capsfilter name=wanted");
  EXPECT_EQ((t.push<float, float>(kFour)), (Floats{2, 3, 4, 5}));
  const auto wanted = find_element(t.harness, "capsfilter");
  const auto ask = [&](const char* caps) {
    gst_util_set_object_arg(G_OBJECT(wanted.get()), "caps", caps);
  };
  ask("other/tensors,format=flexible");
  EXPECT_EQ((t.push<float, float>(kFour).size()), 4u + 32u) << "a header and four numbers";
  EXPECT_SAYS(t.caps(), "format=(string)flexible");
  ask("other/tensor; other/tensors,format=static");
  EXPECT_EQ((t.push<float, float>(kFour)), (Floats{2, 3, 4, 5}));
  EXPECT_EQ(t.messages.next(), "");
}

TEST(FilterPropertyChange, NewOutputCombinationAppliesToTheNextFrame) {
  AdderFiles files;
  auto t = tuned("tensor_filter framework=adder model=" + files.model(1));
  EXPECT_EQ((t.push<float, float>(kFour)), (Floats{2, 3, 4, 5}));
  t.set("output-combination", "i0,o0");
  EXPECT_EQ((t.push<float, float>(kFour)), (Floats{1, 2, 3, 4, 2, 3, 4, 5}));
  EXPECT_SAYS(t.caps(), "num_tensors=(int)2");
  t.set("invoke-dynamic", "true");
  t.set("output-combination", "");
  EXPECT_EQ((t.push<float, float>(kFour).size()), 4u + 32u);
  EXPECT_EQ(t.messages.next_warning(), "");
}

TEST(FilterPropertyChange, InvalidValuesAreRejectedAndRestored) {
  AdderFiles files;
  auto t = tuned("tensor_filter framework=adder model=" + files.model(1));
  EXPECT_EQ((t.push<float, float>(kFour)), (Floats{2, 3, 4, 5}));
  const std::pair<const char*, const char*> refused[] = {{"input", "5"},
                                                         {"outputtype", "int8"},
                                                         {"framework", "no_such_engine"},
                                                         {"output-combination", "o7"}};
  for (const auto& [property, value] : refused) {
    const auto before = t.get(property);
    t.set(property, value);
    EXPECT_EQ((t.push<float, float>(kFour)), (Floats{2, 3, 4, 5})) << property;
    EXPECT_SAYS(t.messages.next_warning(), "WEIR-") << property;
    EXPECT_EQ(t.get(property), before);
  }
  t.set("input", "a:b");
  EXPECT_SAYS(t.messages.next_warning(), "WEIR-");
  t.set("inputtype", "float33");
  EXPECT_SAYS(t.messages.next_warning(), "float33");
  t.set("workers", "2");
  EXPECT_SAYS(t.messages.next_warning(), "workers cannot change while the element runs");
  EXPECT_EQ(t.get("workers"), "1");
  EXPECT_EQ(t.messages.next(), "") << "no error";
}

TEST(FilterPropertyChange, AConfigFileIsReadOrRejected) {
  AdderFiles files;
  auto t = tuned("tensor_filter framework=adder model=" + files.model(1));
  EXPECT_EQ((t.push<float, float>(kFour)), (Floats{2, 3, 4, 5}));
  t.set("config-file", "/nowhere/f.conf");
  EXPECT_SAYS(t.messages.next_warning(), "WEIR-4001: the property file cannot be read");
  EXPECT_EQ(t.get("config-file"), "");
  const auto path =
      files.write("tuned.conf", "output-combination=i0,o0\nframwork=x\nwhen-busy=drop-old\n");
  t.set("config-file", path.c_str());
  EXPECT_EQ(t.get("config-file"), path);
  const std::vector<std::string> warnings{t.messages.next_warning(), t.messages.next_warning()};
  EXPECT_SAYS(warnings[0], "when-busy cannot change while the element runs");
  EXPECT_SAYS(warnings[1], "did you mean framework?");
  EXPECT_EQ((t.push<float, float>(kFour)), (Floats{1, 2, 3, 4, 2, 3, 4, 5}));
  EXPECT_EQ(t.messages.next(), "") << "no error";
}

TEST(FilterPropertyChange, CustomSuspendAndLayoutsApply) {
  AdderFiles files;
  auto t = tuned("tensor_filter framework=adder model=" + files.model(1));
  EXPECT_EQ((t.push<float, float>(kFour)), (Floats{2, 3, 4, 5}));
  t.set("suspend", "100000");
  t.set("inputlayout", "nhwc");
  t.set("inputname", "mine");
  EXPECT_EQ((t.push<float, float>(kFour)), (Floats{2, 3, 4, 5}));
  EXPECT_EQ(t.get("suspend"), "100000");
  EXPECT_EQ(t.get("inputname"), "mine");
  EXPECT_EQ(t.messages.next_warning(), "");
}

// The engine "fake" rejects frames of four rows with this option, which "adder" ignores.
TEST(FilterPropertyChange, ASecondWriteCompletesTheFirst) {
  AdderFiles files;
  auto t = tuned("tensor_filter framework=fake model=" + files.model(2));
  const auto before = t.push<float, float>(kFour);
  EXPECT_NE(before, (Floats{3, 4, 5, 6}));
  t.set("custom", "rows:7");
  EXPECT_EQ((t.push<float, float>(kFour)), before);
  EXPECT_SAYS(t.messages.next_warning(), "WEIR-");
  EXPECT_EQ(t.get("custom"), "");
  t.set("framework", "adder");
  EXPECT_EQ((t.push<float, float>(kFour)), (Floats{3, 4, 5, 6}));
  EXPECT_EQ(t.get("custom"), "rows:7");
  EXPECT_EQ(t.get("framework"), "adder");
  EXPECT_EQ(t.messages.next_warning(), "");
}

}  // namespace tensor_filter_tuning_test
}  // namespace weir::test
