// Tests workers that end, hang or violate the protocol: error texts, counts and policies.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <thread>

#include "becomes.hpp"
#include "core/isolate/isolated_test_support.hpp"
#include "core/tensor/tensor_header.hpp"

namespace weir::isolate {
namespace worker_end_test {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

class WorkerEnd : public IsolatedTest {
 protected:
  // The frame of the order is dropped with this text; later frames use a new process.
  void expect_restart(uint8_t order, const std::string& words) {
    ASSERT_TRUE(open());
    EXPECT_EQ(result_of({0, 4}), 4u);
    const auto lost = run({order, 1, 2});
    ASSERT_TRUE(lost) << lost.error().message();
    EXPECT_FALSE(*lost);
    ASSERT_EQ(reported_.size(), 1u);
    EXPECT_SAYS(reported_[0], words);
    EXPECT_SAYS(reported_[0], "on invoke 2 of this process");
    EXPECT_EQ(counts().frames_lost, 1u);
    ASSERT_TRUE(wait_for_worker());
    EXPECT_EQ(counts().restarted, 1u);
    EXPECT_EQ(result_of({0, 5, 6}), 11u);
  }
};

TEST_F(WorkerEnd, ByACrash) {
  expect_restart(kCrash, "WEIR-3014: the worker process of the model ended");
  EXPECT_SAYS(reported_[0], "signal 11 (Segmentation fault)");
  EXPECT_EQ(counts().ended, 1u);
}

TEST_F(WorkerEnd, ByAnAbort) {
  expect_restart(kAbort, "signal 6 (Aborted)");
}

TEST_F(WorkerEnd, ByExit) {
  expect_restart(kExit, "exit(3)");
}

TEST_F(WorkerEnd, ByWritingIntoItsInput) {
  expect_restart(kWriteInput, "signal 11 (Segmentation fault)");
}

TEST_F(WorkerEnd, ByClosingItsSocket) {
  expect_restart(kCloseSocket, "it closed its connection");
}

TEST_F(WorkerEnd, ByAnInvalidMessage) {
  expect_restart(kTalkNonsense, "sent an invalid message");
  EXPECT_EQ(counts().ended, 1u);
}

TEST_F(WorkerEnd, ByAnEndlessLoop) {
  isolation_.timeout = 500ms;
  expect_restart(kLoop, "WEIR-3015: the model timed out");
  EXPECT_SAYS(reported_[0], "isolate-timeout=500 ms");
  EXPECT_EQ(counts().timed_out, 1u);
  EXPECT_EQ(counts().ended, 0u);
}

// The CPU time of the process in hundredths of a second.
long computed(pid_t id) {
  std::ifstream file("/proc/" + std::to_string(id) + "/stat");
  std::string word;
  for (int field = 1; field < 14; ++field) file >> word;
  long ticks = 0;
  file >> ticks;
  return ticks;
}

// No time limit: calls that wait for the hanging model end only because of the stop.
TEST_F(WorkerEnd, ByTheStopOfItsUserIsNoCrash) {
  isolation_.timeout = 0ms;
  ASSERT_TRUE(open());
  const auto id = static_cast<pid_t>(result_of({kProcess}));
  std::thread stopper([this, id] {
    const long before = computed(id);
    EXPECT_TRUE(becomes_true([&] { return computed(id) >= before + 5; }, "the model to compute"));
    isolation_.monitor->stop();
  });
  const auto lost = run({kLoop});
  stopper.join();
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().code, Code::CANCELLED);
  EXPECT_SAYS(lost.error().message(), "the work was cancelled on invoke 2 of this process");
  const auto next = run({0});
  ASSERT_FALSE(next) << "there is none any more";
  EXPECT_SAYS(next.error().message(), "the element that uses the model was stopped");
  EXPECT_EQ(wait_for_worker().error().code, Code::CANCELLED) << "shapes are not resolved either";
  session_.reset();
  EXPECT_NE(kill(id, 0), 0) << "it is reaped";
  EXPECT_EQ(counts().ended + counts().timed_out + counts().restarted + counts().frames_lost, 0u);
  EXPECT_TRUE(reported_.empty());
}

bool memory_is_limited(const Monitor& monitor) {
  return monitor.confinement().text.find("sanitizer") == std::string::npos;
}

TEST_F(WorkerEnd, ByMemoryBeyondTheLimit) {
  isolation_.memory_mib = 256;
  ASSERT_TRUE(open());
  if (!memory_is_limited(*isolation_.monitor))
    GTEST_SKIP() << isolation_.monitor->confinement().text;
  EXPECT_SAYS(isolation_.monitor->confinement().text, "at most 256 MiB");
  expect_restart(kEatMemory, "the model exceeded its memory limit");
  EXPECT_SAYS(reported_[0], "isolate-memory=256 MiB");
  EXPECT_SAYS(reported_[0], "fix: isolate-memory=512");
}

TEST_F(WorkerEnd, AtTheStartIsAnErrorWhateverThePolicy) {
  for (const auto policy : {OnCrash::Restart, OnCrash::Drop, OnCrash::Error}) {
    isolation_.on_crash = policy;
    EXPECT_SAYS(open_error("crash"), "ended while it opened the model");
  }
  EXPECT_SAYS(open_error("crash"), "signal 11 (Segmentation fault)");
  EXPECT_SAYS(open_error("abort"), "signal 6 (Aborted)");
  EXPECT_SAYS(open_error("exit"), "exit(4)");
  isolation_.timeout = 1ms;
  isolation_.min_for_start = 2000ms;
  const std::string error = open_error("loop");
  EXPECT_SAYS(error, "timed out while it opened the model");
  EXPECT_SAYS(error, "offered: nothing within 2000 ms, with isolate-timeout=1 ms");
  EXPECT_SAYS(error, "fix: isolate-timeout=2000");
  EXPECT_EQ(counts().restarted, 0u);
}

TEST_F(WorkerEnd, AtTheStartByMemoryBeyondTheLimit) {
  isolation_.memory_mib = 256;
  ASSERT_TRUE(open());
  if (!memory_is_limited(*isolation_.monitor))
    GTEST_SKIP() << isolation_.monitor->confinement().text;
  EXPECT_SAYS(open_error("memory"), "the model exceeded its memory limit");
}

// Only the worker loads the module.
TEST_F(WorkerEnd, InAModulesEntryFunctionIsAnError) {
  const std::string before = std::getenv("WEIR_MODULE_PATH");
  setenv("WEIR_MODULE_PATH", std::getenv("WEIR_CRASHING_MODULES"), 1);
  isolation_.engine = "crashing";
  const Status status = open();
  setenv("WEIR_MODULE_PATH", before.c_str(), 1);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Code::WORKER_ENDED);
  EXPECT_SAYS(status.error().message(), "ended while it opened the model");
  EXPECT_SAYS(status.error().message(), "signal 11 (Segmentation fault)");
  EXPECT_SAYS(status.error().message(), "crashing");
}

TEST_F(WorkerEnd, MakesAnErrorWhereThePolicyIsError) {
  isolation_.on_crash = OnCrash::Error;
  ASSERT_TRUE(open());
  const auto lost = run({kCrash});
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().code, Code::WORKER_ENDED);
  EXPECT_SAYS(lost.error().message(), "signal 11");
  const auto next = run({0});
  ASSERT_FALSE(next);
  EXPECT_SAYS(next.error().message(), "the model no longer has a worker process");
  EXPECT_EQ(counts().frames_lost, 0u);
  EXPECT_EQ(counts().restarted, 0u);
}

TEST_F(WorkerEnd, DropsAllThatFollowsWhereThePolicyIsDrop) {
  isolation_.on_crash = OnCrash::Drop;
  ASSERT_TRUE(open());
  for (const Bytes& bytes : {Bytes{kCrash}, Bytes{0}, Bytes{0, 1}}) {
    const auto lost = run(bytes);
    ASSERT_TRUE(lost);
    EXPECT_FALSE(*lost);
  }
  EXPECT_EQ(counts().ended, 1u);
  EXPECT_EQ(counts().frames_lost, 3u);
  EXPECT_FALSE(wait_for_worker());
}

TEST_F(WorkerEnd, DropsFramesWhileANewWorkerStarts) {
  ASSERT_TRUE(open());
  for (int i = 0; i < 3; ++i) {  // the restart delay grows each time
    EXPECT_FALSE(*run({kCrash}));
    ASSERT_TRUE(wait_for_worker());
  }
  EXPECT_FALSE(*run({kCrash}));
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(*run({0})) << "400 ms without a worker";
  EXPECT_EQ(counts().frames_lost, 14u);
  EXPECT_EQ(counts().ended, 4u);
}

TEST_F(WorkerEnd, LosesOnlyTheCrashingFrameIfTheOthersWait) {
  isolation_.on_crash = OnCrash::Wait;
  ASSERT_TRUE(open());
  for (uint8_t i = 1; i <= 3; ++i) {
    EXPECT_FALSE(*run({kCrash}));
    EXPECT_EQ(result_of({0, i}), i) << "by the next process";
  }
  EXPECT_EQ(counts().frames_lost, 3u);
  EXPECT_EQ(counts().restarted, 3u);
  const auto id = static_cast<pid_t>(result_of({kProcess}));
  ASSERT_EQ(kill(id, SIGKILL), 0);
  siginfo_t info{};
  ASSERT_EQ(waitid(P_PID, static_cast<id_t>(id), &info, WEXITED | WNOWAIT), 0);
  EXPECT_EQ(result_of({0, 9}), 9u) << "an end between two frames loses none";
  EXPECT_EQ(counts().frames_lost, 3u);
}

TEST_F(WorkerEnd, AStopEndsTheWaitForANewWorker) {
  isolation_.on_crash = OnCrash::Wait;
  ASSERT_TRUE(open());
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(*run({kCrash}));  // the next restart is 800 ms away
  std::thread stopper([this] { isolation_.monitor->stop(); });
  const auto next = run({0});
  stopper.join();
  ASSERT_FALSE(next);
  EXPECT_EQ(next.error().code, Code::CANCELLED);
  EXPECT_EQ(counts().restarted, 4u);
}

// Nothing could end the wait for a worker.
TEST_F(WorkerEnd, WithoutADescriptorForTheStopNoneStarts) {
  rlimit before{};
  getrlimit(RLIMIT_NOFILE, &before);
  const rlimit none{0, before.rlim_max};
  setrlimit(RLIMIT_NOFILE, &none);
  isolation_.monitor = std::make_shared<Monitor>();
  setrlimit(RLIMIT_NOFILE, &before);
  const auto status = open();
  EXPECT_REFUSED(status, WORKER_NOT_STARTED, "offered: eventfd: Too many open files");
  EXPECT_SAYS(status.error().message(), "fix: ulimit -n");
}

TEST_F(WorkerEnd, BetweenFramesLosesNoFrame) {
  isolation_.crash_folder = testing::TempDir();
  ASSERT_TRUE(open());
  const auto id = static_cast<pid_t>(result_of({kProcess}));
  ASSERT_EQ(kill(id, SIGKILL), 0);
  siginfo_t info{};
  ASSERT_EQ(waitid(P_PID, static_cast<id_t>(id), &info, WEXITED | WNOWAIT), 0);
  EXPECT_FALSE(*run({0}));
  ASSERT_EQ(reported_.size(), 1u);
  EXPECT_SAYS(reported_[0], "ended between two frames");
  EXPECT_SAYS(reported_[0], "signal 9 (Killed)");
  EXPECT_EQ(counts().frames_saved, 0u);
  ASSERT_TRUE(wait_for_worker());
  EXPECT_EQ(result_of({0, 9}), 9u);
}

TEST_F(WorkerEnd, SavesTheCrashingFrame) {
  isolation_.crash_folder = testing::TempDir() + "weir-worker-end-" + std::to_string(getpid());
  isolation_.repeat = "tensor_filter framework=unruly model=m";
  fs::create_directories(isolation_.crash_folder);
  ASSERT_TRUE(open());
  EXPECT_FALSE(*run({kCrash, 7, 8, 9}));
  EXPECT_EQ(counts().frames_saved, 1u);
  ASSERT_EQ(reported_.size(), 1u);
  EXPECT_SAYS(reported_[0], "fix: gst-launch-1.0 filesrc location=" + isolation_.crash_folder);
  EXPECT_SAYS(reported_[0], "! tensor_filter framework=unruly model=m ! fakesink");
  const auto path = fs::directory_iterator(isolation_.crash_folder)->path();
  std::ifstream file(path, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  const auto chunk = read_tensor_chunk(std::as_bytes(std::span(bytes)));
  ASSERT_TRUE(chunk);
  EXPECT_EQ(chunk->spec.to_string(), "uint8 4");
  EXPECT_EQ(bytes.substr(kTensorHeaderBytes), "\xC8\x07\x08\x09");
  fs::remove_all(isolation_.crash_folder);
}

TEST_F(WorkerEnd, ReportsThatTheFrameCannotBeSaved) {
  isolation_.crash_folder = "/not-there";
  ASSERT_TRUE(open());
  EXPECT_FALSE(*run({kCrash}));
  ASSERT_EQ(reported_.size(), 1u);
  EXPECT_SAYS(reported_[0], "a frame that terminated a worker process cannot be saved");
  EXPECT_EQ(counts().frames_saved, 0u);
}

}  // namespace worker_end_test
}  // namespace weir::isolate
