// suspend=MS. The tests wait until it sleeps, whenever that is; it may have slept before the caps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/adder_harness.hpp"

namespace {

using namespace weir::test;

std::string line(const AdderFiles& files, const Pipe& tell, const std::string& more = "") {
  return adder(files.model(1), "suspend=1 custom=tell:" + tell.writer() + more);
}

TEST(ModelSuspend, AnIdleModelIsClosedAndOpenedForTheNextFrame) {
  const AdderFiles files;
  const Pipe tell;
  auto h = harness_of(line(files, tell), kAdderCaps);
  const auto filter = element_of(h, "tensor_filter");
  for (int i = 0; i < 3; ++i) {
    wait_until_suspended(filter.get());
    EXPECT_EQ(stat(filter.get(), "weights-bytes"), 0u);
    EXPECT_EQ(pushed_sum(h), 1);
  }
  EXPECT_EQ(stat(filter.get(), "received"), 3u);
  EXPECT_EQ(stat(filter.get(), "pushed"), 3u);
  h.reset();
  const std::string told = tell.all();
  EXPECT_GE(told.size(), 8u) << "opened at the start and for each of the frames";
  for (size_t i = 0; i < told.size(); ++i) EXPECT_EQ(told[i], i % 2 == 0 ? 'o' : 'c') << told;
}

TEST(ModelSuspend, AnEngineThatCanSleepKeepsItsModel) {
  const AdderFiles files;
  const Pipe tell;
  auto h = harness_of(line(files, tell, ",sleeps:yes"), kAdderCaps);
  const auto filter = element_of(h, "tensor_filter");
  for (int i = 0; i < 3; ++i) {
    wait_until_suspended(filter.get());
    EXPECT_EQ(stat(filter.get(), "weights-bytes"), 1000u);
    EXPECT_EQ(pushed_sum(h), 1);
  }
  h.reset();
  const std::string told = tell.all();
  EXPECT_EQ(told.find('o'), told.rfind('o')) << told;
  EXPECT_EQ(told.find('c'), told.size() - 1) << told;
  EXPECT_GE(std::count(told.begin(), told.end(), 'r'), 3) << told;
}

TEST(ModelSuspend, AUserOfTheKeyThatWorksKeepsTheModelOpen) {
  const AdderFiles files;
  const Pipe tell;
  const std::string key = " shared-tensor-filter-key=s";
  auto busy = harness_of(adder(files.model(1), "custom=tell:" + tell.writer() + key), kAdderCaps);
  auto idle = harness_of(line(files, tell) + key, kAdderCaps);
  const auto filter = element_of(idle, "tensor_filter");
  wait_until_suspended(filter.get());
  EXPECT_EQ(stat(filter.get(), "weights-bytes"), 1000u);
  EXPECT_EQ(pushed_sum(busy), 1);
  EXPECT_EQ(pushed_sum(idle), 1);
  EXPECT_EQ(tell.next(), 'o');
  idle.reset();
  busy.reset();
  EXPECT_EQ(tell.next(), 'c') << "opened once, closed once";
}

TEST(ModelSuspend, AModelThatIsGoneWhenItIsNeededIsAnError) {
  const AdderFiles files;
  const Pipe tell;
  auto h = harness_of(line(files, tell), kAdderCaps);
  Errors messages(h);
  wait_until_suspended(element_of(h, "tensor_filter").get());
  std::filesystem::remove(files.model(1));
  EXPECT_EQ(gst_harness_push(h.get(), frame<float>({0, 0, 0, 0})), GST_FLOW_ERROR);
  EXPECT_SAYS(messages.next(), "WEIR-3003: the model file is not there");
  files.model(1);
  EXPECT_EQ(pushed_sum(h), 1) << "the next frame finds it";
  EXPECT_EQ(stat(h, "tensor_filter", "dropped-error"), 1u);
}

TEST(ModelSuspend, AModelThatCameWhileItSleptIsTheOneThatWakes) {
  const AdderFiles files;
  const Pipe tell;
  auto h = harness_of(line(files, tell) + " is-updatable=true", kAdderCaps);
  const auto filter = element_of(h, "tensor_filter");
  wait_until_suspended(filter.get());
  g_object_set(filter.get(), "model", files.model(9).c_str(), nullptr);
  EXPECT_EQ(pushed_sum(h), 9);
}

TEST(ModelSuspend, WithoutThePropertyNothingSleeps) {
  const AdderFiles files;
  auto h = harness_of(adder(files.model(1)), kAdderCaps);
  EXPECT_FALSE(is_suspended(element_of(h, "tensor_filter").get()));
}

}  // namespace
