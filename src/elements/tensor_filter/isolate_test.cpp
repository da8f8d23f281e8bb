// tensor_filter isolate=process with the unruly engine of tests/support: whatever the model does to
// its process, the pipeline continues as on-crash defines.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <future>
#include <string>
#include <thread>
#include <vector>

#include "becomes.hpp"
#include "elements/tests/element_test_support.hpp"
#include "refused_calls.hpp"

namespace isolate_test {

using namespace weir::test;
namespace fs = std::filesystem;

// The first bytes of frames that control unruly_engine.cpp.
constexpr uint8_t kCrash = 200, kLoop = 203, kFail = 212, kProcess = 214;

std::string model_path() {
  const std::string path = testing::TempDir() + "weir_unruly_model.bin";
  std::ofstream(path) << "x";
  return path;
}

std::string line(const std::string& properties = "") {
  return "tensor_filter framework=unruly isolate=process model=" + model_path() + " " + properties;
}

Harness filter(const std::string& properties = "") {
  return make_harness(line(properties), tensors("uint8", "4"));
}

uint64_t read_result(GstBuffer* buffer) {
  const auto all = values<uint64_t>(buffer);
  return all.size() == 1 ? all[0] : UINT64_MAX;
}
uint64_t result(const Harness& h, const Bytes& bytes) {
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(bytes)));
  return out ? read_result(out.get()) : UINT64_MAX;
}

uint64_t get_stat(const Harness& h, const char* name) {
  return stat(h, "tensor_filter", name);
}

// Pushes frames, which are dropped until the new worker is ready.
bool pushed_until_something_comes(const Harness& h) {
  GstFlowReturn flow = GST_FLOW_OK;
  Ref<GstBuffer> out;
  const auto comes_or_fails = [&] {
    flow = gst_harness_push(h.get(), frame(Bytes{0, 1, 2, 3}));
    out = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
    return out || flow != GST_FLOW_OK;
  };
  return becomes_true(comes_or_fails, "a result of the new process") && flow == GST_FLOW_OK &&
         read_result(out.get()) == 6;
}

TEST(TensorFilterIsolated, RunsTheModelInAnotherProcess) {
  auto h = filter();
  EXPECT_EQ(result(h, {0, 1, 2, 3}), 6u);
  const uint64_t process = result(h, {kProcess, 0, 0, 0});
  EXPECT_GT(process, 0u);
  EXPECT_NE(process, static_cast<uint64_t>(getpid()));
  weir::gst::UniqueText framework;
  gchar* name = nullptr;
  g_object_get(find_element(h, "tensor_filter").get(), "framework", &name, nullptr);
  framework.reset(name);
  EXPECT_STREQ(framework.get(), "unruly");
  const auto all = stats(find_element(h, "tensor_filter").get());
  EXPECT_SAYS(std::string(gst_structure_get_string(all.get(), "worker-confinement")),
              can_refuse_calls()
                  ? "no new sockets, programs or processes"
                  : "new sockets, programs and processes (Function not implemented)");
}

// Collects warnings of the log.
void keep_warning(GstDebugCategory*, GstDebugLevel level, const char*, const char*, gint, GObject*,
                  GstDebugMessage* message, gpointer text) {
  if (level == GST_LEVEL_WARNING)
    *static_cast<std::string*>(text) += std::string(gst_debug_message_get(message)) + "\n";
}

TEST(TensorFilterIsolated, WarnsAboutUnsupportedConfinement) {
  if (!can_refuse_calls()) GTEST_SKIP() << "this system does not filter system calls";
  std::string warnings;
  (gst_debug_add_log_function)(keep_warning, &warnings, nullptr);
  const auto before = gst_debug_get_default_threshold();
  gst_debug_set_default_threshold(GST_LEVEL_WARNING);
  std::thread([] {
    refuse_calls({SYS_unshare}, EPERM);
    auto h = filter();
    EXPECT_EQ(result(h, {0, 1, 2, 3}), 6u);
  }).join();
  gst_debug_set_default_threshold(before);
  gst_debug_remove_log_function_by_data(&warnings);
  EXPECT_SAYS(warnings,
              "not restricted for the worker process: the network of this machine "
              "(Operation not permitted)");
}

TEST(TensorFilterIsolated, ContinuesAfterACrash) {
  auto h = filter();
  Errors errors(h);
  EXPECT_EQ(result(h, {0, 1, 0, 0}), 1u);
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{kCrash, 0, 0, 0})), GST_FLOW_OK);
  const std::string warning = errors.next_warning();
  EXPECT_SAYS(warning, "WEIR-3014: the worker process of the model ended on invoke 2");
  EXPECT_SAYS(warning, "signal 11 (Segmentation fault)");
  EXPECT_SAYS(warning, "fix: crash-folder=/tmp") << "on-crash=restart is set";
  ASSERT_TRUE(pushed_until_something_comes(h));
  EXPECT_EQ(get_stat(h, "worker-ended"), 1u);
  EXPECT_EQ(get_stat(h, "worker-restarts"), 1u);
  const uint64_t lost = get_stat(h, "worker-frames-lost");
  EXPECT_GE(lost, 1u);
  EXPECT_EQ(get_stat(h, "dropped-policy"), lost);
  EXPECT_EQ(get_stat(h, "invokes"), get_stat(h, "consumed")) << "without the frames that were lost";
  EXPECT_EQ(get_stat(h, "received"), get_stat(h, "consumed") + lost);
  EXPECT_EQ(errors.next(), "") << "no error";
}

TEST(TensorFilterIsolated, ContinuesAfterAnEndlessLoop) {
  auto h = filter("isolate-timeout=300");
  Errors errors(h);
  EXPECT_EQ(result(h, {0, 1, 0, 0}), 1u);
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{kLoop, 0, 0, 0})), GST_FLOW_OK);
  EXPECT_SAYS(errors.next_warning(), "WEIR-3015: the model timed out");
  ASSERT_TRUE(pushed_until_something_comes(h));
  EXPECT_EQ(get_stat(h, "worker-timeouts"), 1u);
}

// The time of an invoke is not limited here: only the stop ends the process.
class StoppedDuringAHang : public ::testing::TestWithParam<const char*> {};

TEST_P(StoppedDuringAHang, EndsTheProcessImmediately) {
  auto h = filter(std::string("isolate-timeout=0 ") + GetParam());
  Errors errors(h);
  const auto process = static_cast<pid_t>(result(h, {kProcess, 0, 0, 0}));
  std::thread source([&h] { gst_harness_push(h.get(), frame(Bytes{kLoop, 0, 0, 0})); });
  wait_for_stat(h, "tensor_filter", "held", 1);
  const auto element = find_element(h, "tensor_filter");
  EXPECT_EQ(gst_element_set_state(element.get(), GST_STATE_READY), GST_STATE_CHANGE_SUCCESS);
  source.join();
  EXPECT_NE(kill(process, 0), 0) << "it is reaped";
  EXPECT_EQ(get_stat(h, "dropped-flush"), 1u);
  EXPECT_EQ(get_stat(h, "received"), get_stat(h, "consumed") + get_stat(h, "dropped"));
  EXPECT_EQ(get_stat(h, "worker-ended") + get_stat(h, "worker-timeouts"), 0u);
  EXPECT_EQ(get_stat(h, "worker-restarts") + get_stat(h, "worker-not-started"), 0u);
  EXPECT_EQ(errors.next() + errors.next_warning(), "");
}

INSTANTIATE_TEST_SUITE_P(WhateverTheWay, StoppedDuringAHang,
                         ::testing::Values("", "on-crash=error", "on-crash=drop",
                                           "when-busy=block"));

TEST(TensorFilterIsolated, RestartsAfterAStopDuringAHang) {
  auto h = filter("isolate-timeout=0");
  std::thread source([&h] { gst_harness_push(h.get(), frame(Bytes{kLoop, 0, 0, 0})); });
  wait_for_stat(h, "tensor_filter", "held", 1);
  const auto element = find_element(h, "tensor_filter");
  gst_element_set_state(element.get(), GST_STATE_READY);
  source.join();
  ASSERT_EQ(gst_element_set_state(element.get(), GST_STATE_PLAYING), GST_STATE_CHANGE_SUCCESS);
  auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(tensors("uint8", "4").c_str()));
  gst_harness_set_src_caps(h.get(), caps.release());
  EXPECT_EQ(result(h, {0, 1, 2, 3}), 6u);
}

TEST(TensorFilterIsolated, DropsEverythingAfterACrash) {
  auto h = filter("on-crash=drop");
  for (const uint8_t order : {kCrash, uint8_t{0}, uint8_t{0}})
    EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{order, 0, 0, 0})), GST_FLOW_OK);
  EXPECT_EQ(gst_harness_buffers_received(h.get()), 0u);
  EXPECT_EQ(get_stat(h, "worker-frames-lost"), 3u);
  EXPECT_EQ(get_stat(h, "dropped-policy"), 3u);
  EXPECT_EQ(get_stat(h, "worker-restarts"), 0u);
}

TEST(TensorFilterIsolated, ReportsACrashAsAnError) {
  auto h = filter("on-crash=error");
  Errors errors(h);
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{kCrash, 0, 0, 0})), GST_FLOW_ERROR);
  EXPECT_SAYS(errors.next(), "signal 11 (Segmentation fault)");
  EXPECT_EQ(errors.next_warning(), "") << "posted once";
  EXPECT_EQ(get_stat(h, "dropped-error"), 1u);
  EXPECT_EQ(get_stat(h, "worker-ended"), 1u);
}

TEST(TensorFilterIsolated, ForwardsTheErrorsOfAnEngine) {
  auto h = filter();
  Errors errors(h);
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{kFail, 0, 0, 0})), GST_FLOW_ERROR);
  EXPECT_SAYS(errors.next(), "ordered to fail");
  EXPECT_EQ(get_stat(h, "worker-ended"), 0u);
}

TEST(TensorFilterIsolated, ReportsErrorsAtTheStart) {
  EXPECT_SAYS(start_error(line("custom=open:crash")), "ended while it opened the model");
  EXPECT_SAYS(start_error(line("custom=open:abort on-crash=drop")), "signal 6 (Aborted)");
  EXPECT_SAYS(start_error("tensor_filter framework=nothing isolate=process model=" + model_path()),
              "WEIR-3001");
  EXPECT_SAYS(start_error("tensor_filter framework=unruly isolate=process model=/not-there"),
              "the model file does not exist");
  EXPECT_SAYS(start_error("tensor_filter framework=unruly isolate=process"), "no model is set");
}

TEST(TensorFilterIsolated, SavesTheFrameWithAPipelineThatReplaysIt) {
  const std::string folder = testing::TempDir() + "weir-isolate-" + std::to_string(getpid());
  fs::create_directories(folder);
  auto h = filter("isolate-timeout=9000 isolate-memory=2000 crash-folder=" + folder);
  Errors errors(h);
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{kCrash, 5, 6, 7})), GST_FLOW_OK);
  EXPECT_EQ(get_stat(h, "worker-frames-saved"), 1u);
  const std::string warning = errors.next_warning();
  EXPECT_SAYS(warning, " isolate-memory=2000 isolate-timeout=9000 isolate=process on-crash=error");
  const std::string before = "fix: gst-launch-1.0 ";
  const size_t at = warning.find(before);
  ASSERT_NE(at, std::string::npos) << warning;
  const auto pipeline = lone_element(warning.substr(at + before.size()));
  ASSERT_TRUE(pipeline);
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(pipeline.get()));
  const auto message = Ref<GstMessage>::adopt(gst_bus_timed_pop_filtered(
      bus.get(), 60 * GST_SECOND, GstMessageType(GST_MESSAGE_ERROR | GST_MESSAGE_EOS)));
  ASSERT_TRUE(message);
  EXPECT_EQ(GST_MESSAGE_TYPE(message.get()), GST_MESSAGE_ERROR);
  EXPECT_SAYS(get_text(message.get()), "signal 11 (Segmentation fault)");
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  fs::remove_all(folder);
}

TEST(TensorFilterIsolated, ReadsUpstreamMemoryInPlace) {
  auto h = make_harness("tensor_transform mode=typecast option=uint8 ! " + line(),
                        tensors("uint16", "1000"));
  const std::vector<uint16_t> input(1000, 2);
  for (uint64_t i = 1; i <= 5; ++i) {
    const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(input)));
    ASSERT_TRUE(out);
    EXPECT_EQ(read_result(out.get()), 2000u);
    EXPECT_EQ(get_stat(h, "worker-bytes-copied"), i * sizeof(uint64_t)) << "the results only";
  }
}

TEST(TensorFilterIsolated, CountsCopiedBytes) {
  auto h = filter();
  EXPECT_EQ(result(h, {0, 1, 2, 3}), 6u);
  EXPECT_EQ(get_stat(h, "worker-bytes-copied"), 4 + sizeof(uint64_t));
}

TEST(TensorFilterIsolated, KeepsTheOrderOfSeveralProcesses) {
  auto h = filter("workers=3");
  for (uint8_t i = 0; i < 60; ++i)
    ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes{0, i, 0, 0})), 0);
  for (uint8_t i = 0; i < 60; ++i) {
    const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
    ASSERT_TRUE(out);
    EXPECT_EQ(read_result(out.get()), i);
  }
}

TEST(TensorFilterIsolated, FramesWaitForANewProcessIfConfigured) {
  for (const char* workers : {"", " workers=2"}) {
    auto h = filter(std::string("on-crash=wait") + workers);
    Errors errors(h);
    const Bytes orders{1, 2, kCrash, 3, 4, 5, kCrash, 6, 7};
    for (const uint8_t order : orders)
      ASSERT_EQ(
          gst_harness_push(h.get(), frame(Bytes{order > 100 ? order : uint8_t{0}, order, 0, 0})),
          GST_FLOW_OK);
    for (uint8_t i = 1; i <= 7; ++i) {
      const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
      ASSERT_TRUE(out) << workers;
      EXPECT_EQ(read_result(out.get()), i);
    }
    EXPECT_EQ(get_stat(h, "worker-frames-lost"), 2u);
    EXPECT_EQ(get_stat(h, "dropped-policy"), 2u);
    EXPECT_EQ(errors.next(), "");
  }
}

// The stop ends the wait of the fourth restart, 400 ms.
TEST(TensorFilterIsolated, AStopEndsTheWaitForANewProcess) {
  auto h = filter("on-crash=wait");
  for (int i = 0; i < 4; ++i) gst_harness_push(h.get(), frame(Bytes{kCrash, 0, 0, 0}));
  std::thread source([&h] { gst_harness_push(h.get(), frame(Bytes{0, 1, 0, 0})); });
  wait_for_stat(h, "tensor_filter", "held", 1);
  EXPECT_EQ(gst_element_set_state(find_element(h, "tensor_filter").get(), GST_STATE_READY),
            GST_STATE_CHANGE_SUCCESS);
  source.join();
  EXPECT_EQ(get_stat(h, "received"), get_stat(h, "consumed") + get_stat(h, "dropped"));
}

TEST(TensorFilterIsolated, StartsAgainWithNewProcesses) {
  auto h = filter("on-crash=drop");
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{kCrash, 0, 0, 0})), GST_FLOW_OK);
  const auto element = find_element(h, "tensor_filter");
  ASSERT_NE(gst_element_set_state(element.get(), GST_STATE_READY), GST_STATE_CHANGE_FAILURE);
  ASSERT_NE(gst_element_set_state(element.get(), GST_STATE_PLAYING), GST_STATE_CHANGE_FAILURE);
  auto other = filter();
  EXPECT_EQ(result(other, {0, 9, 0, 0}), 9u);
  EXPECT_EQ(stat(element.get(), "worker-ended"), 0u) << "counted from the start";
}

// The worker process of a model that is reopened after a property change does not answer.
TEST(TensorFilterIsolated, AStopCancelsAReopenAfterAPropertyChange) {
  const auto element = lone_element(line("isolate-timeout=600000"));
  auto h = Harness{gst_harness_new_with_element(element.get(), "sink", "src")};
  gst_harness_set_src_caps_str(h.get(), tensors("uint8", "4").c_str());
  EXPECT_EQ(result(h, {0, 1, 2, 3}), 6u);
  Errors errors(h);
  g_object_set(element.get(), "custom", "open:loop", nullptr);
  auto pushed = std::async(std::launch::async, [&] {
    return gst_harness_push(h.get(), frame(Bytes{0, 1, 2, 3}));
  });
  EXPECT_TRUE(wait_for_stat(element.get(), "received", 2));
  auto stopped = std::async(std::launch::async,
                            [&] { return gst_element_set_state(element.get(), GST_STATE_READY); });
  const bool ended = becomes_true(
      [&] { return stopped.wait_for(std::chrono::seconds(0)) == std::future_status::ready; },
      "the stop", std::chrono::seconds(20));
  if (!ended) abort();  // the threads would wait for minutes
  EXPECT_EQ(pushed.get(), GST_FLOW_FLUSHING);
  EXPECT_EQ(errors.next() + errors.next_warning(), "");
  EXPECT_EQ(stat(element.get(), "held"), 0u);
}

}  // namespace isolate_test
