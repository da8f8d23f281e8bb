// Tests of filter sub-plugins with invoke-async=true that dispatch outputs after invoke has
// returned.
// SPDX-License-Identifier: LGPL-2.1-or-later

#include "elements/tensor_filter/adder_test_support.hpp"
#include "elements/tensor_filter/async_filter_test_support.hpp"
#include "filter_lines_test_support.hpp"

namespace sub_plugin_async_test {

using namespace weir::test;
using weir::test::async::End;
using weir::test::async::flush;

const std::string kThree = tensors("uint8", "3");

// An element whose filter dispatches, on its own thread, what it reads from a pipe, and confirms
// through another pipe.
class Later {
 public:
  explicit Later(const std::string& more = "")
      : harness(make_harness("tensor_filter framework=header1 invoke-async=true custom=later:" +
                                 to_.reader() + ":" + from_.writer() + more,
                             kThree)) {}
  ~Later() {
    to_.put(0);  // ends the thread
    harness.reset();
  }
  Later(const Later&) = delete;
  Later& operator=(const Later&) = delete;
  // Returns after the dispatch.
  void dispatch(uint8_t number) const {
    to_.put(static_cast<char>(number));
    EXPECT_EQ(from_.next(), static_cast<char>(number));
  }

 private:
  const Pipe to_, from_;

 public:
  Harness harness;
};

GstFlowReturn push(const Harness& h, GstClockTime pts) {
  GstBuffer* buffer = frame<uint8_t>({1, 2, 3});
  GST_BUFFER_PTS(buffer) = pts;
  return gst_harness_push(h.get(), buffer);
}
void expect_output(const Harness& h, uint8_t number, GstClockTime pts) {
  const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  ASSERT_TRUE(out);
  EXPECT_EQ(content(out.get()), Bytes(3, number));
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), pts);
}

TEST(CompatSubPluginAsync, OutputsAfterInvokeBelongToItsFrame) {
  const Later later;
  const Harness& h = later.harness;
  ASSERT_EQ(push(h, 10), GST_FLOW_OK);
  for (const uint8_t number : {uint8_t{5}, uint8_t{6}}) {
    later.dispatch(number);
    expect_output(h, number, 10);
  }
  ASSERT_EQ(push(h, 20), GST_FLOW_OK);
  later.dispatch(7);
  expect_output(h, 7, 20);
  EXPECT_EQ(stat(h, "tensor_filter", "consumed"), 1u) << "the second is open";
}

TEST(CompatSubPluginAsync, EosFollowsTheLastOutput) {
  const Later later;
  const Harness& h = later.harness;
  ASSERT_EQ(push(h, 10), GST_FLOW_OK);
  later.dispatch(5);
  End end(h);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  end.wait();  // until nothing has arrived for a while
  expect_output(h, 5, 10);
  EXPECT_EQ(stat(h, "tensor_filter", "consumed"), 1u);
  EXPECT_EQ(stat(h, "tensor_filter", "held"), 0u);
}

TEST(CompatSubPluginAsync, AFlushAbandonsTheOpenFrame) {
  const Later later;
  const Harness& h = later.harness;
  ASSERT_EQ(push(h, 10), GST_FLOW_OK);
  flush(h);
  EXPECT_EQ(stat(h, "tensor_filter", "dropped-flush"), 1u);
  later.dispatch(5);  // the frame is gone
  ASSERT_EQ(push(h, 20), GST_FLOW_OK);
  later.dispatch(6);
  expect_output(h, 6, 20);
}

TEST(CompatSubPluginAsync, ALateOutputFailsTheNextFrame) {
  const Later later(" async-timeout=400");
  const Harness& h = later.harness;
  Errors errors(h);
  ASSERT_EQ(push(h, 10), GST_FLOW_OK);
  wait_for_stat(h, "tensor_filter", "consumed", 1);
  testing::internal::CaptureStderr();
  later.dispatch(5);
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_SAYS(log, "returned an output after its frame had ended");
  EXPECT_SAYS(log, "needed: an output within 200 ms of the previous one");
  EXPECT_EQ(push(h, 20), GST_FLOW_ERROR);
  EXPECT_SAYS(errors.next(),
              "WEIR-5003: the filter header1 returned an output after its frame had ended");
}

TEST(CompatSubPluginAsync, OutputsWhileItIsClosedAreDropped) {
  auto h = make_harness("tensor_filter framework=header1 custom=late invoke-async=true", kThree);
  ASSERT_EQ(push(h, 10), GST_FLOW_OK);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(Ref<GstBuffer>::adopt(gst_harness_pull(h.get())));
  testing::internal::CaptureStderr();
  h.reset();
  EXPECT_SAYS(testing::internal::GetCapturedStderr(),
              "while it was being closed; the output is dropped");
}

}  // namespace sub_plugin_async_test
