// Tests of filter sub-plugins whose models are opened, suspended, replaced and shared.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/adder_test_support.hpp"
#include "filter_lines_test_support.hpp"

namespace filter_life_test {

using namespace weir::test;

// Runs with both versions of the descriptor.
class CompatFilterLife : public ::testing::TestWithParam<const char*> {
 protected:
  static std::string life(const std::string& model, const std::string& custom,
                          const std::string& more = "") {
    return std::string("tensor_filter framework=") + GetParam() + " model=" + model +
           " custom=" + custom + " " + more;
  }
};
INSTANTIATE_TEST_SUITE_P(Versions, CompatFilterLife, testing::Values("life", "life1"),
                         [](const auto& version) { return std::string(version.param); });

TEST_P(CompatFilterLife, OpensOnceAndClosesOnce) {
  const AdderFiles files;
  const Pipe events;
  auto h = make_harness(life(files.model(5), events.writer()), kAdderCaps);
  EXPECT_EQ(pushed_sum(h), 5);
  h.reset();
  EXPECT_EQ(events.all(), "oc");
}

TEST_P(CompatFilterLife, IsSuspendedIfItCan) {
  const AdderFiles files;
  const Pipe events;
  auto h = make_harness(life(files.model(1), "+" + events.writer(), "suspend=1"), kAdderCaps);
  for (int i = 0; i < 2; ++i) {
    wait_until_suspended(find_element(h, "tensor_filter").get());
    EXPECT_EQ(pushed_sum(h), 1);
  }
  h.reset();
  const auto reported = events.all();
  EXPECT_EQ(std::count(reported.begin(), reported.end(), 'o'), 1) << reported;
  EXPECT_GE(std::count(reported.begin(), reported.end(), 'r'), 2) << reported;
  EXPECT_EQ(reported.back(), 'c');
}

TEST_P(CompatFilterLife, IsClosedIfItCannotSuspend) {
  const AdderFiles files;
  const Pipe events;
  auto h = make_harness(life(files.model(1), events.writer(), "suspend=1"), kAdderCaps);
  wait_until_suspended(find_element(h, "tensor_filter").get());
  EXPECT_EQ(pushed_sum(h), 1);
  h.reset();
  const auto reported = events.all();
  EXPECT_EQ(reported.substr(0, 3), "oco");
  EXPECT_EQ(reported.find('s'), std::string::npos);
}

// The sub-plugin's reload function is not called: it would write R to the pipe
// (docs/guide/from-nnstreamer.md).
TEST_P(CompatFilterLife, ANewModelIsOpenedBesideTheCurrentOne) {
  const AdderFiles files;
  const Pipe events;
  auto h = make_harness(life(files.model(1), events.writer(), "is-updatable=true"), kAdderCaps);
  const auto filter = find_element(h, "tensor_filter");
  EXPECT_EQ(pushed_sum(h), 1);
  g_object_set(filter.get(), "model", files.model(2).c_str(), nullptr);
  EXPECT_EQ(pushed_sum(h), 2);
  EXPECT_EQ(stat(filter.get(), "reloads"), 1u);
  g_object_set(filter.get(), "model", files.write("broken", "no number").c_str(), nullptr);
  EXPECT_EQ(pushed_sum(h), 2) << "the old one stays";
  h.reset();
  EXPECT_EQ(events.all(), "oocc");
}

TEST_P(CompatFilterLife, AModelOfOtherSizesIsClosedAndTheOldOneContinues) {
  const AdderFiles files;
  const Pipe events;
  auto h = make_harness(life(files.model(1), events.writer(), "is-updatable=true"), kAdderCaps);
  const auto filter = find_element(h, "tensor_filter");
  Errors messages(h);
  EXPECT_EQ(pushed_sum(h), 1);
  g_object_set(filter.get(), "model", files.model(2, "5").c_str(), nullptr);
  const auto message = messages.next_warning();
  EXPECT_SAYS(message, "WEIR-3012: the new model cannot replace the one that runs");
  EXPECT_SAYS(message, "offered: " + files.model(2, "5") + ": in 1 tensor: float32 5");
  EXPECT_SAYS(message, "needed: " + files.model(1) + ": in 1 tensor: float32 4");
  EXPECT_EQ(pushed_sum(h), 1);
  EXPECT_EQ(messages.next(), "") << "the stream goes on";
  EXPECT_EQ(text_property(filter.get(), "model"), files.model(1));
  EXPECT_EQ(stat(filter.get(), "reloads"), 0u);
  h.reset();
  EXPECT_EQ(events.all(), "oocc");
}

TEST_P(CompatFilterLife, AModelThatDoesNotOpenIsReportedAndTheOldOneContinues) {
  const AdderFiles files;
  const Pipe events;
  auto h = make_harness(life(files.model(1), events.writer(), "is-updatable=true"), kAdderCaps);
  const auto filter = find_element(h, "tensor_filter");
  Errors messages(h);
  g_object_set(filter.get(), "model", files.write("broken", "no number").c_str(), nullptr);
  const auto message = messages.next_warning();
  EXPECT_SAYS(message, std::string("the filter ") + GetParam() + " cannot open its model");
  EXPECT_SAYS(message, "open returned -5 (Input/output error)");
  EXPECT_EQ(pushed_sum(h), 1);
  g_object_set(filter.get(), "model", "/no/such/file", nullptr);
  EXPECT_SAYS(messages.next_warning(), "WEIR-3003");
  EXPECT_EQ(pushed_sum(h), 1);
  EXPECT_EQ(messages.next(), "");
  h.reset();
  EXPECT_EQ(events.all(), "oc");
}

TEST_P(CompatFilterLife, OneModelForTwoElementsThatMeasureDifferently) {
  const AdderFiles files;
  const Pipe events;
  const std::string key = " shared-tensor-filter-key=one";
  auto first = make_harness(life(files.model(4), events.writer(), "latency=1" + key), kAdderCaps);
  auto second =
      make_harness(life(files.model(4), events.writer(), "suspend=60000" + key), kAdderCaps);
  EXPECT_EQ(pushed_sum(first), 4);
  EXPECT_EQ(pushed_sum(second), 4);
  EXPECT_EQ(stat(second, "tensor_filter", "shared-by"), 2u);
  first.reset();
  EXPECT_EQ(pushed_sum(second), 4);
  second.reset();
  EXPECT_EQ(events.all(), "oc");
}

TEST_P(CompatFilterLife, ModelFilesAreCheckedOrOptionalAsTheFrameworkDeclares) {
  EXPECT_SAYS(start_error(life("/no/such/file", "1")), "WEIR-3003");
  EXPECT_SAYS(start_error(std::string("tensor_filter framework=") + GetParam()), "no model is set");
  const AdderFiles files;
  const auto message = start_error(life(files.write("empty", ""), "1"));
  EXPECT_SAYS(message, std::string("the filter ") + GetParam() + " cannot open its model");
  EXPECT_SAYS(message, "open returned -5 (Input/output error)");
}

}  // namespace filter_life_test
