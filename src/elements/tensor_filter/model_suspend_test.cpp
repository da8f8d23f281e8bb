// suspend=MS. The tests wait until the model is suspended, which may happen before the caps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/adder_test_support.hpp"

namespace model_suspend_test {

using namespace weir::test;

std::string line(const AdderFiles& files, const Pipe& pipe, const std::string& more = "") {
  return adder(files.model(1), "suspend=1 custom=events:" + pipe.writer() + more);
}

TEST(ModelSuspend, ClosesAnIdleModelAndReopensItForTheNextFrame) {
  const AdderFiles files;
  const Pipe pipe;
  auto h = make_harness(line(files, pipe), kAdderCaps);
  const auto filter = find_element(h, "tensor_filter");
  for (int i = 0; i < 3; ++i) {
    wait_until_suspended(filter.get());
    EXPECT_EQ(stat(filter.get(), "weights-bytes"), 0u);
    EXPECT_EQ(pushed_sum(h), 1);
  }
  EXPECT_EQ(stat(filter.get(), "received"), 3u);
  EXPECT_EQ(stat(filter.get(), "pushed"), 3u);
  h.reset();
  const std::string calls = pipe.all();
  EXPECT_GE(calls.size(), 8u) << "opened at the start and for each of the frames";
  for (size_t i = 0; i < calls.size(); ++i) EXPECT_EQ(calls[i], i % 2 == 0 ? 'o' : 'c') << calls;
}

TEST(ModelSuspend, KeepsTheModelOfAnEngineThatCanSuspend) {
  const AdderFiles files;
  const Pipe pipe;
  auto h = make_harness(line(files, pipe, ",sleeps:yes"), kAdderCaps);
  const auto filter = find_element(h, "tensor_filter");
  for (int i = 0; i < 3; ++i) {
    wait_until_suspended(filter.get());
    EXPECT_EQ(stat(filter.get(), "weights-bytes"), 1000u);
    EXPECT_EQ(pushed_sum(h), 1);
  }
  h.reset();
  const std::string calls = pipe.all();
  EXPECT_EQ(calls.find('o'), calls.rfind('o')) << calls;
  EXPECT_EQ(calls.find('c'), calls.size() - 1) << calls;
  EXPECT_GE(std::count(calls.begin(), calls.end(), 'r'), 3) << calls;
}

TEST(ModelSuspend, ABusyFilterOfTheKeyKeepsTheModelOpen) {
  const AdderFiles files;
  const Pipe pipe;
  const std::string key = " shared-tensor-filter-key=s";
  auto busy =
      make_harness(adder(files.model(1), "custom=events:" + pipe.writer() + key), kAdderCaps);
  auto idle = make_harness(line(files, pipe) + key, kAdderCaps);
  const auto filter = find_element(idle, "tensor_filter");
  wait_until_suspended(filter.get());
  EXPECT_EQ(stat(filter.get(), "weights-bytes"), 1000u);
  EXPECT_EQ(pushed_sum(busy), 1);
  EXPECT_EQ(pushed_sum(idle), 1);
  EXPECT_EQ(pipe.next(), 'o');
  idle.reset();
  busy.reset();
  EXPECT_EQ(pipe.next(), 'c') << "opened once, closed once";
}

TEST(ModelSuspend, ReportsAModelFileThatWasRemovedMeanwhile) {
  const AdderFiles files;
  const Pipe pipe;
  auto h = make_harness(line(files, pipe), kAdderCaps);
  Errors messages(h);
  wait_until_suspended(find_element(h, "tensor_filter").get());
  std::filesystem::remove(files.model(1));
  EXPECT_EQ(gst_harness_push(h.get(), frame<float>({0, 0, 0, 0})), GST_FLOW_ERROR);
  EXPECT_SAYS(messages.next(), "WEIR-3003: the model file does not exist");
  files.model(1);
  EXPECT_EQ(pushed_sum(h), 1) << "the next frame uses it";
  EXPECT_EQ(stat(h, "tensor_filter", "dropped-error"), 1u);
}

TEST(ModelSuspend, OpensAModelThatWasSetWhileSuspended) {
  const AdderFiles files;
  const Pipe pipe;
  auto h = make_harness(line(files, pipe) + " is-updatable=true", kAdderCaps);
  const auto filter = find_element(h, "tensor_filter");
  wait_until_suspended(filter.get());
  g_object_set(filter.get(), "model", files.model(9).c_str(), nullptr);
  EXPECT_EQ(pushed_sum(h), 9);
}

TEST(ModelSuspend, NeverSuspendsByDefault) {
  const AdderFiles files;
  auto h = make_harness(adder(files.model(1)), kAdderCaps);
  EXPECT_FALSE(is_suspended(find_element(h, "tensor_filter").get()));
}

}  // namespace model_suspend_test
