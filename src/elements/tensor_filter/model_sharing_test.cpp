// Filters that share a model by a key.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/adder_test_support.hpp"

namespace model_sharing_test {

using namespace weir::test;

constexpr char kKey[] = " is-updatable=true shared-tensor-filter-key=k";

TEST(ModelSharing, TheSameKeyOpensTheModelOnce) {
  const AdderFiles files;
  const Pipe events;
  const auto line = adder(files.model(1), "custom=events:" + events.writer() + kKey);
  {
    auto first = make_harness(line, kAdderCaps), second = make_harness(line, kAdderCaps);
    auto third = make_harness(line, kAdderCaps);
    EXPECT_EQ(pushed_sum(first), 1);
    EXPECT_EQ(pushed_sum(second), 1);
    const auto filter = find_element(second, "tensor_filter");
    EXPECT_EQ(stat(filter.get(), "shared-by"), 3u);
    EXPECT_EQ(stat(filter.get(), "weights-bytes"), 1000u);
    EXPECT_EQ(events.next(), 'o');
    first.reset();
    EXPECT_EQ(stat(filter.get(), "shared-by"), 2u);
    EXPECT_EQ(pushed_sum(second), 1);
  }
  EXPECT_EQ(events.next(), 'c') << "closed with its last user and not reopened before";
}

TEST(ModelSharing, WithoutAKeyEachFilterOpensAModel) {
  const AdderFiles files;
  const Pipe events;
  const auto line = adder(files.model(1), "custom=events:" + events.writer());
  auto first = make_harness(line, kAdderCaps), second = make_harness(line, kAdderCaps);
  EXPECT_EQ(events.next(), 'o');
  EXPECT_EQ(events.next(), 'o');
  EXPECT_EQ(stat(first, "tensor_filter", "shared-by"), 1u);
}

TEST(ModelSharing, AnEngineWithOneSessionServesAllFiltersOfTheKey) {
  const AdderFiles files;
  const auto line = adder(files.model(1), std::string("custom=sessions:1") + kKey);
  auto first = make_harness(line, kAdderCaps), second = make_harness(line, kAdderCaps);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(pushed_sum(first), 1);
    EXPECT_EQ(pushed_sum(second), 1);
  }
}

TEST(ModelSharing, ADifferentModelUnderTheKeyIsReportedAndNotShared) {
  const AdderFiles files;
  auto first = make_harness(adder(files.model(1), kKey), kAdderCaps);
  const auto second = lone_element(adder(files.model(2), kKey));
  Errors messages(second.get());
  EXPECT_EQ(gst_element_set_state(second.get(), GST_STATE_PAUSED), GST_STATE_CHANGE_SUCCESS);
  const auto text = messages.next_warning();
  EXPECT_SAYS(text, "WEIR-3012: the model with this key is a different one and is not shared");
  EXPECT_SAYS(text, "offered: model=" + files.model(2) + " framework=adder");
  EXPECT_SAYS(text, "needed: shared-tensor-filter-key=k: model=" + files.model(1));
  EXPECT_EQ(stat(second.get(), "shared-by"), 1u);
  gst_element_set_state(second.get(), GST_STATE_NULL);
  EXPECT_EQ(pushed_sum(first), 1);
}

TEST(ModelSharing, AReloadReplacesTheModelOfAllFilters) {
  const AdderFiles files;
  const auto line = adder(files.model(1), kKey);
  auto first = make_harness(line, kAdderCaps), second = make_harness(line, kAdderCaps);
  EXPECT_EQ(pushed_sum(first), 1);
  EXPECT_EQ(pushed_sum(second), 1);
  g_object_set(find_element(first, "tensor_filter").get(), "model", files.model(7).c_str(),
               nullptr);
  EXPECT_EQ(pushed_sum(first), 7);
  EXPECT_EQ(pushed_sum(second), 7);
  EXPECT_EQ(stat(second, "tensor_filter", "reloads"), 1u);
}

TEST(ModelSharing, AReloadThatDoesNotFitOneFilterReplacesNone) {
  const AdderFiles files;
  const auto line = adder(files.model(1), kKey);
  auto first = make_harness(line, kAdderCaps), second = make_harness(line, kAdderCaps);
  Errors messages(first);
  g_object_set(find_element(first, "tensor_filter").get(), "model", files.model(7, "8").c_str(),
               nullptr);
  EXPECT_SAYS(messages.next_warning(), "WEIR-3012");
  EXPECT_EQ(pushed_sum(first), 1);
  EXPECT_EQ(pushed_sum(second), 1);
}

}  // namespace model_sharing_test
