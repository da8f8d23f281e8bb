// Falling behind a live source, and the latency that tensor_filter reports.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/gated_filter_test_support.hpp"

namespace weir::test {
namespace lag_test {

// Frames at 30 per second that arrive later and later: by `lag` percent of the elapsed time.
class Late {
 public:
  explicit Late(const std::string& properties, bool live = true)
      : filter_(properties, true), errors_(filter_.element()) {
    gst_harness_set_live(filter_.get(), live);
    gst_harness_use_testclock(filter_.get());
  }
  // Pushes frames up to `seconds` of the clock.
  void bring(double seconds, int lag_percent) {
    for (; now_ < seconds * GST_SECOND; now_ += GST_SECOND / 10) {
      gst_harness_set_time(filter_.get(), now_);
      const GstClockTime time = now_ - now_ * static_cast<GstClockTime>(lag_percent) / 100;
      EXPECT_EQ(gst_harness_push(filter_.get(), frame<float>({0, 0, 0, 0}, time)), GST_FLOW_OK);
    }
  }
  std::string warning() { return errors_.next_warning(); }
  GstHarness* get() const { return filter_.get(); }

 private:
  GatedFilter filter_;
  Errors errors_;
  GstClockTime now_ = 0;
};

TEST(FilterFallsBehind, IsReportedOnceWithAFix) {
  Late f("");
  f.bring(3.9, 50);
  EXPECT_EQ(f.warning(), "") << "late for less than two seconds";
  f.bring(4.2, 50);
  const std::string text = f.warning();
  EXPECT_SAYS(text, "WEIR-3017: the model is slower than the live source");
  EXPECT_SAYS(text, "offered: frames that are 2.0 s old when they arrive");
  EXPECT_SAYS(text, "when-busy");
  EXPECT_SAYS(text, "fix: tensor_filter when-busy=drop-old");
  f.bring(60, 50);
  EXPECT_EQ(f.warning(), "");
}

TEST(FilterFallsBehind, IsReportedForBlockingWorkers) {
  Late f("workers=2");
  f.bring(6, 50);
  EXPECT_SAYS(f.warning(), "WEIR-3017");
}

TEST(FilterFallsBehind, IsNotReportedIfWhenBusyIsSet) {
  for (const char* when_busy : {"block", "drop-new", "drop-old"}) {
    Late f("when-busy=" + std::string(when_busy));
    f.bring(20, 50);
    EXPECT_EQ(f.warning(), "") << when_busy;
  }
}

TEST(FilterFallsBehind, IsNotReportedForASourceThatIsNotLive) {
  Late f("", false);
  f.bring(20, 50);
  EXPECT_EQ(f.warning(), "");
}

TEST(FilterFallsBehind, IsNotReportedForFramesInTime) {
  Late f("");
  f.bring(20, 4);
  EXPECT_EQ(f.warning(), "");
}

TEST(FilterFallsBehind, IsNotReportedForTheLatencyOfTheSource) {
  Late f("");
  gst_harness_set_upstream_latency(f.get(), 60 * GST_SECOND);
  f.bring(20, 50);
  EXPECT_EQ(f.warning(), "");
}

struct Latency {
  gboolean live = FALSE;
  GstClockTime min = 0, max = 0;
};
// The latency of the filter downstream of a live source that answers 10 to 20 ms.
Latency get_latency(const GatedFilter& f) {
  gst_pad_set_query_function(
      f.get()->srcpad, [](GstPad* pad, GstObject* parent, GstQuery* query) -> gboolean {
        if (GST_QUERY_TYPE(query) != GST_QUERY_LATENCY)
          return gst_pad_query_default(pad, parent, query);
        gst_query_set_latency(query, TRUE, 10 * GST_MSECOND, 20 * GST_MSECOND);
        return TRUE;
      });
  const Unique<GstQuery, gst_query_unref> query(gst_query_new_latency());
  Latency out;
  EXPECT_TRUE(gst_pad_peer_query(f.get()->sinkpad, query.get()));
  gst_query_parse_latency(query.get(), &out.live, &out.min, &out.max);
  return out;
}

TEST(FilterLatency, IsThatOfUpstreamWithoutWorkers) {
  GatedFilter f("", true);
  const auto latency = get_latency(f);
  EXPECT_TRUE(latency.live);
  EXPECT_EQ(latency.min, 10 * GST_MSECOND);
  EXPECT_EQ(latency.max, 20 * GST_MSECOND);
}

TEST(FilterLatency, IncludesTheFramesThatCanBeHeld) {
  constexpr GstClockTime kFrame = GST_SECOND / 30;
  for (const auto& [properties, frames] :
       std::initializer_list<std::pair<const char*, GstClockTime>>{{"workers=2", 4},
                                                                   {"when-busy=drop-new", 1},
                                                                   {"when-busy=drop-old", 2},
                                                                   {"when-busy=block", 2}}) {
    GatedFilter f(properties, true);
    const auto latency = get_latency(f);
    EXPECT_EQ(latency.min, 10 * GST_MSECOND) << "no measurement yet";
    EXPECT_EQ(latency.max, 20 * GST_MSECOND + frames * kFrame) << properties;
  }
}

TEST(FilterLatency, IncludesTheWaitForAWorker) {
  for (const auto& [properties, waits] :
       {std::pair{"when-busy=drop-new", false}, {"when-busy=drop-old", true}}) {
    GatedFilter f(properties);
    for (const float n : {0, 1, 2}) {
      f.push(n);
      gate().wait_for_entered(static_cast<size_t>(n) + 1);
      // An invoke of measurable duration.
      const auto begin = std::chrono::steady_clock::now();
      while (std::chrono::steady_clock::now() - begin < std::chrono::microseconds(50)) {
      }
      gate().let_go(n);
      f.pull(1);
      f.wait_for_stat("workers-busy", 0);
    }
    int invoke = -1;  // microseconds
    g_object_set(f.element(), "latency", 1, nullptr);
    g_object_get(f.element(), "latency", &invoke, nullptr);
    ASSERT_GE(invoke, 50);
    const auto expected = waits ? static_cast<GstClockTime>(invoke) * GST_USECOND : 0;
    EXPECT_EQ(get_latency(f).min, 10 * GST_MSECOND + expected) << properties;
  }
}

}  // namespace lag_test
}  // namespace weir::test
