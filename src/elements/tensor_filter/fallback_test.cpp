// tensor_filter fallback=...: a second model computes the frames for which the first has no result.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <chrono>
#include <cstdlib>

#include "elements/tensor_filter/adder_test_support.hpp"
#include "elements/tensor_filter/filter_log_test_support.hpp"
#include "gate.hpp"

namespace weir::test {
namespace fallback_test {

using Numbers = std::vector<float>;
constexpr float kLate = -1, kRefused = -2, kLost = -3;

// The model adds 5 and has no result for the three numbers above; the fallback adds 90.
class FilterFallback : public testing::Test {
 protected:
  FilterFallback() {
    const auto ini =
        files_.write("weir.ini", "[filter]\npriority_add = adder\npriority_gate = gated\n");
    setenv("WEIR_CONFIG", ini.c_str(), 1);
  }
  ~FilterFallback() override { setenv("WEIR_CONFIG", "", 1); }

  std::string filter(const std::string& more = "") const {
    return adder(files_.model(5), "custom=outcomes:yes " + more);
  }
  std::string with_fallback(const std::string& more = "") const {
    return filter("fallback=" + files_.model(90) + " " + more);
  }
  // The first numbers of the outputs.
  static Numbers pass(const Harness& h, const Numbers& frames, size_t outputs) {
    for (const float first : frames)
      EXPECT_EQ(gst_harness_push(h.get(), frame<float>({first, 0, 0, 0})), GST_FLOW_OK);
    Numbers out;
    for (size_t i = 0; i < outputs; ++i) {
      const auto buffer = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
      out.push_back(buffer ? values<float>(buffer.get())[0] : -1);
    }
    return out;
  }
  static uint64_t stat(const Harness& h, const char* name) {
    return test::stat(h, "tensor_filter", name);
  }
  const AdderFiles files_;
};

TEST_F(FilterFallback, CountsFramesWithoutAResultByTheirReason) {
  auto h = make_harness(filter(), kAdderCaps);
  EXPECT_EQ(pass(h, {1, kLate, kRefused, kRefused, kLost, kLost, kLost, 2}, 2), (Numbers{6, 7}));
  EXPECT_EQ(stat(h, "dropped-late"), 1u);
  EXPECT_EQ(stat(h, "dropped-refused"), 2u);
  EXPECT_EQ(stat(h, "dropped-lost"), 3u);
  EXPECT_EQ(stat(h, "dropped-policy"), 0u);
  EXPECT_EQ(stat(h, "received"), stat(h, "consumed") + stat(h, "dropped"));
}

TEST_F(FilterFallback, CountsThemByTheirReasonInBatchesAndParts) {
  for (const char* mode : {"batch-size=2", "invoke-rows=1", "workers=2"}) {
    auto h = make_harness(filter(mode), kAdderCaps);
    EXPECT_EQ(pass(h, {kLost, kLost, 2, 2}, 2), (Numbers{7, 7})) << mode;
    EXPECT_EQ(stat(h, "dropped-lost"), 2u) << mode;
    EXPECT_EQ(stat(h, "dropped"), 2u) << mode;
  }
}

TEST_F(FilterFallback, AnswersInTheOrderOfTheFrames) {
  for (const char* mode : {"", "workers=3", "invoke-rows=1"}) {
    auto h = make_harness(with_fallback(mode), kAdderCaps);
    EXPECT_EQ(pass(h, {1, kLate, 2, kRefused, kLost, kLost, 3}, 7),
              (Numbers{6, 89, 7, 88, 87, 87, 8}))
        << mode;
    EXPECT_EQ(stat(h, "fallback-frames"), 4u) << mode;
    EXPECT_EQ(stat(h, "dropped"), 0u) << mode;
    EXPECT_EQ(stat(h, "bytes-copied"), 0u) << mode;
  }
}

// What the meta says about the one filter; "" without the meta.
std::string answered_by(GstBuffer* buffer) {
  GstCustomMeta* meta = gst_buffer_get_custom_meta(buffer, "WeirAnsweredBy");
  if (!meta) return "";
  const GstStructure* fields = gst_custom_meta_get_structure(meta);
  EXPECT_EQ(gst_structure_n_fields(fields), 1);
  const char* who = gst_structure_get_string(fields, gst_structure_nth_field_name(fields, 0));
  return who ? who : "no text";
}

TEST_F(FilterFallback, ReportsWhoAnsweredEachFrame) {
  const std::string file = files_.model(90);
  for (const char* mode : {"", "workers=3", "invoke-rows=1"}) {
    auto h = make_harness(with_fallback(mode), kAdderCaps);
    for (const float first : {1.F, kLost, 2.F, kLate})
      EXPECT_EQ(gst_harness_push(h.get(), frame<float>({first, 0, 0, 0})), GST_FLOW_OK);
    for (const auto& who : {std::string(), file, std::string(), file}) {
      const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
      EXPECT_EQ(answered_by(out.get()), who) << mode;
    }
  }
}

// Both frames are late. The second one waits until the fallback has run for the first one.
TEST_F(FilterFallback, DropsAFrameThatWaitsForTheFallbackBeyondItsDeadline) {
  Gate& gate = Gate::of_process();
  gate.reset(true);  // for the dry run
  auto h = make_harness(filter("workers=2 fallback=" + files_.write("slow.gate", "x")), kAdderCaps);
  gate.reset();
  const auto push = [&h](float second) {
    EXPECT_EQ(gst_harness_push(h.get(), frame<float>({kLate, second, 0, 0}, 0)), GST_FLOW_OK);
  };
  push(1);
  EXPECT_EQ(gate.wait_for_entered(1).size(), 1u);
  g_object_set(find_element(h, "tensor_filter").get(), "deadline", guint64{20 * GST_MSECOND},
               nullptr);
  push(2);
  const auto expired = std::chrono::steady_clock::now() + std::chrono::milliseconds(20);
  ASSERT_TRUE(becomes_true([&] { return std::chrono::steady_clock::now() > expired; },
                           "the deadline of the second frame"));
  gate.open();
  const auto first = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  ASSERT_TRUE(first);
  EXPECT_EQ(values<float>(first.get())[1], 2);
  EXPECT_TRUE(wait_for_stat(h, "tensor_filter", "held", 0));
  EXPECT_EQ(gate.entered().size(), 1u) << "the fallback does not run on the second frame";
  EXPECT_EQ(stat(h, "fallback-frames"), 1u);
  EXPECT_EQ(stat(h, "dropped-late"), 1u);
  EXPECT_EQ(stat(h, "received"), stat(h, "consumed") + stat(h, "dropped"));
}

TEST_F(FilterFallback, KeepsTheTimesOfTheFrame) {
  auto h = make_harness(with_fallback(), kAdderCaps);
  gst_harness_push(h.get(), frame<float>({kLost, 0, 0, 0}, 7 * GST_SECOND));
  const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 7 * GST_SECOND);
}

TEST_F(FilterFallback, LogsEachChangeOnce) {
  const FilterLog log;
  const std::string file = files_.model(90);
  auto h = make_harness(with_fallback(), kAdderCaps);
  pass(h, {1, kLost, kLost, 2, 3, kLate}, 6);
  const auto first =
      log.text().find("the fallback " + file + " answers: the result of the model is lost\n");
  const auto back =
      log.text().find("the model answers again; the fallback " + file + " has answered 2 frames\n");
  const auto again =
      log.text().find("the fallback " + file + " answers: the result of the model is late\n");
  EXPECT_LT(first, back) << log.text();
  EXPECT_LT(back, again) << log.text();
  EXPECT_NE(again, std::string::npos) << log.text();
  EXPECT_EQ(log.text().find("answers", again + 10), log.text().rfind("answers")) << log.text();
}

TEST_F(FilterFallback, RefusesAnotherShapeAtTheStart) {
  const std::string other = files_.write("other.add", "90 6");
  const std::string error = start_error(filter("fallback=" + other));
  EXPECT_SAYS(error, "the fallback has other tensors than the model");
  EXPECT_SAYS(error, "offered: fallback=" + other +
                         ": inputs 1 tensor: float32 6:?; outputs 1 tensor: float32 6:?");
  EXPECT_SAYS(error, "needed: inputs 1 tensor: float32 4:?; outputs 1 tensor: float32 4:?");
  EXPECT_SAYS(error, "first difference: input 0");
  EXPECT_SAYS(error, "fix: set fallback to a model with the same inputs and outputs");
}

TEST_F(FilterFallback, RefusesWhatCannotBeOpened) {
  EXPECT_SAYS(start_error(filter("fallback=/nowhere/model.add")), "/nowhere/model.add");
  EXPECT_SAYS(start_error(filter("fallback=model.unknown")),
              "the model file does not exist\n  offered: model.unknown");
  const std::string text = files_.write("model.unknown", "x");
  EXPECT_SAYS(start_error(filter("fallback=" + text)),
              "no engine can be selected for this model\n  offered: " + text);
}

TEST_F(FilterFallback, RefusesBatchesAndAsynchronousEngines) {
  for (const char* mode : {"batch-size=2", "invoke-async=true"}) {
    const std::string error = start_error(with_fallback(mode));
    EXPECT_SAYS(error, "these properties cannot be combined");
    EXPECT_SAYS(error, std::string("offered: ") + mode + " with fallback=" + files_.model(90));
    EXPECT_SAYS(error, "fix: tensor_filter batch-size=1 invoke-async=false fallback=");
  }
}

TEST_F(FilterFallback, LeavesTheModelsErrorsAlone) {
  auto h = make_harness(adder(files_.model(5), "custom=fail:5 fallback=" + files_.model(90)),
                        kAdderCaps);
  EXPECT_EQ(gst_harness_push(h.get(), frame<float>({1, 0, 0, 0})), GST_FLOW_ERROR);
  EXPECT_EQ(stat(h, "fallback-frames"), 0u);
  EXPECT_EQ(stat(h, "dropped-error"), 1u);
}

TEST_F(FilterFallback, AnEngineChoosesHowManyFramesRunAtATime) {
  const std::string parallel = adder(files_.model(5), "custom=parallel:3 ");
  const auto workers = [](const std::string& launch) {
    auto h = make_harness(launch, kAdderCaps);
    EXPECT_EQ(pass(h, {1, 2, 3, 4, 5}, 5), (Numbers{6, 7, 8, 9, 10})) << launch;
    return stat(h, "workers");
  };
  EXPECT_EQ(workers(parallel), 3u);
  EXPECT_EQ(workers(parallel + "workers=2"), 2u);
  EXPECT_EQ(workers(parallel + "invoke-rows=1"), 1u);
  EXPECT_EQ(workers(adder(files_.model(5))), 1u);
}

}  // namespace fallback_test
}  // namespace weir::test
