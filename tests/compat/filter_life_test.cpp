// Filter sub-plugins whose models are opened, put to sleep, replaced and shared.
#include "elements/tensor_filter/adder_harness.hpp"
#include "filter_lines.hpp"

namespace {

using namespace weir::test;

std::string life(const std::string& model, const std::string& custom,
                 const std::string& more = "") {
  return "tensor_filter framework=life model=" + model + " custom=" + custom + " " + more;
}

TEST(CompatFilterLife, OpensOnceAndClosesOnce) {
  const AdderFiles files;
  const Pipe tell;
  auto h = harness_of(life(files.model(5), tell.writer()), kAdderCaps);
  EXPECT_EQ(pushed_sum(h), 5);
  h.reset();
  EXPECT_EQ(tell.all(), "oc");
}

TEST(CompatFilterLife, SleepsWhereItCan) {
  const AdderFiles files;
  const Pipe tell;
  auto h = harness_of(life(files.model(1), "+" + tell.writer(), "suspend=1"), kAdderCaps);
  for (int i = 0; i < 2; ++i) {
    wait_until_suspended(element_of(h, "tensor_filter").get());
    EXPECT_EQ(pushed_sum(h), 1);
  }
  h.reset();
  const auto told = tell.all();
  EXPECT_EQ(std::count(told.begin(), told.end(), 'o'), 1) << told;
  EXPECT_GE(std::count(told.begin(), told.end(), 'r'), 2) << told;
  EXPECT_EQ(told.back(), 'c');
}

TEST(CompatFilterLife, IsClosedWhereItCannotSleep) {
  const AdderFiles files;
  const Pipe tell;
  auto h = harness_of(life(files.model(1), tell.writer(), "suspend=1"), kAdderCaps);
  wait_until_suspended(element_of(h, "tensor_filter").get());
  EXPECT_EQ(pushed_sum(h), 1);
  h.reset();
  const auto told = tell.all();
  EXPECT_EQ(told.substr(0, 3), "oco");
  EXPECT_EQ(told.find('s'), std::string::npos);
}

TEST(CompatFilterLife, AnotherModelIsOpenedBesideThePresentOne) {
  const AdderFiles files;
  const Pipe tell;
  auto h = harness_of(life(files.model(1), tell.writer(), "is-updatable=true"), kAdderCaps);
  const auto filter = element_of(h, "tensor_filter");
  EXPECT_EQ(pushed_sum(h), 1);
  g_object_set(filter.get(), "model", files.model(2).c_str(), nullptr);
  EXPECT_EQ(pushed_sum(h), 2);
  EXPECT_EQ(stat(filter.get(), "reloads"), 1u);
  g_object_set(filter.get(), "model", files.write("broken", "no number").c_str(), nullptr);
  EXPECT_EQ(pushed_sum(h), 2) << "the old one stays";
  h.reset();
  EXPECT_EQ(tell.all(), "oocc");
}

TEST(CompatFilterLife, OneModelForTwoElementsThatMeasureDifferently) {
  const AdderFiles files;
  const Pipe tell;
  const std::string key = " shared-tensor-filter-key=one";
  auto first = harness_of(life(files.model(4), tell.writer(), "latency=1" + key), kAdderCaps);
  auto second = harness_of(life(files.model(4), tell.writer(), "suspend=60000" + key), kAdderCaps);
  EXPECT_EQ(pushed_sum(first), 4);
  EXPECT_EQ(pushed_sum(second), 4);
  EXPECT_EQ(stat(second, "tensor_filter", "shared-by"), 2u);
  first.reset();
  EXPECT_EQ(pushed_sum(second), 4);
  second.reset();
  EXPECT_EQ(tell.all(), "oc");
}

TEST(CompatFilterLife, ModelsAreLookedForAndMayBeLeftOutAsTheFrameworkSays) {
  EXPECT_SAYS(start_error(life("/no/such/file", "1")), "WEIR-3003");
  EXPECT_SAYS(start_error("tensor_filter framework=life"), "no model is set");
  const AdderFiles files;
  const auto said = start_error(life(files.write("empty", ""), "1"));
  EXPECT_SAYS(said, "the filter life does not open its model");
  EXPECT_SAYS(said, "open returned -5 (Input/output error)");
}

}  // namespace
