// Tests the restrictions of a worker process and its lifetime.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <poll.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>

extern "C" {  // missing in glibc 2.36
#include <sys/pidfd.h>
}

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "core/isolate/isolated_test_support.hpp"
#include "machine/descriptor.hpp"
#include "refused_calls.hpp"

extern char** environ;

namespace weir::isolate {
namespace confinement_test {

class Confined : public IsolatedTest {
 protected:
  void SetUp() override {
    IsolatedTest::SetUp();
    ASSERT_TRUE(open());
  }
};

TEST_F(Confined, ReportsItsState) {
  const std::string text = isolation_.monitor->confinement().text;
  EXPECT_SAYS(text, "new sockets, programs");
  for (const char* part : {"network", "capabilities", "user namespace", "/proc", "any memory"})
    EXPECT_SAYS(text, part);
}

TEST_F(Confined, AllowsNoSocket) {
  EXPECT_EQ(result_of({kSocket}), uint64_t{EPERM});
}
TEST_F(Confined, AllowsNoProcess) {
  EXPECT_EQ(result_of({kFork}), uint64_t{EPERM});
}
TEST_F(Confined, AllowsNoProgram) {
  EXPECT_EQ(result_of({kExec}), uint64_t{EPERM});
}
TEST_F(Confined, AllowsNoSignalToOthers) {
  EXPECT_EQ(result_of({kKillParent}), uint64_t{EPERM});
}

// libgomp ends the process if it cannot pin the threads that it starts.
TEST_F(IsolatedTest, LeavesThreadsOfOpenMpUnpinned) {
  const auto is_set = [this](const std::string& name) {
    Bytes order{kVariable};
    order.insert(order.end(), name.begin(), name.end());
    return result_of(order);
  };
  setenv("OMP_PROC_BIND", "true", 1);
  setenv("OMP_NUM_THREADS", "2", 0);
  const Status status = open();
  unsetenv("OMP_PROC_BIND");
  ASSERT_TRUE(status) << status.error().message();
  EXPECT_EQ(is_set("OMP_PROC_BIND"), 0u);
  EXPECT_EQ(is_set("OMP_NUM_THREADS"), 1u);
}

// A worker on a kernel, or in a container, that lacks some of the mechanisms.
class PartialConfinement : public IsolatedTest {
 protected:
  void open_without(std::initializer_list<long> calls, int error) {
    std::thread([&] {
      refuse_calls(calls, error);
      const Status status = open();
      ASSERT_TRUE(status) << status.error().message();
      EXPECT_EQ(result_of({0, 1, 2}), 3u);
      EXPECT_EQ(result_of({kFork}), uint64_t{EPERM}) << "the other restrictions hold";
      TearDown();
    }).join();
    confinement_ = isolation_.monitor->confinement();
  }
  Confinement confinement_;
};

TEST_F(PartialConfinement, ReportsThatThereIsNoNamespace) {
  open_without({SYS_unshare}, EPERM);
  EXPECT_SAYS(confinement_.refused, "the user namespace of the pipeline (Operation not permitted)");
  EXPECT_SAYS(confinement_.refused, "the network of this machine (Operation not permitted)");
  EXPECT_SAYS(confinement_.text, confinement_.refused.substr(0, confinement_.refused.find(',')));
  EXPECT_SAYS(confinement_.text, "no new sockets, programs or processes");
  EXPECT_SAYS(confinement_.text, "no capabilities");
}

TEST_F(PartialConfinement, ReportsThatThereIsNoLandlock) {
  open_without({SYS_landlock_create_ruleset}, ENOSYS);
  EXPECT_SAYS(confinement_.refused, "files of other processes in /proc (Function not implemented)");
  EXPECT_SAYS(confinement_.text, "files of other processes in /proc (Function not implemented)");
  EXPECT_SAYS(confinement_.text, "no capabilities");
}

TEST_F(PartialConfinement, ReportsThatCapabilitiesRemain) {
  open_without({SYS_capset}, EPERM);
  EXPECT_SAYS(confinement_.refused, "the capabilities of the pipeline (Operation not permitted)");
}

class Program : public IsolatedTest {
 protected:
  void SetUp() override {
    IsolatedTest::SetUp();
    before_ = std::getenv("WEIR_WORKER");
  }
  void TearDown() override {
    setenv("WEIR_WORKER", before_.c_str(), 1);
    IsolatedTest::TearDown();
  }
  std::string error_with(const std::string& program) {
    setenv("WEIR_WORKER", program.c_str(), 1);
    const Status status = open();
    return status ? "no error" : status.error().message();
  }
  std::string before_;
};

TEST_F(Program, AMissingProgramIsReported) {
  const std::string error = error_with("/not-there/weir-worker");
  EXPECT_SAYS(error, "WEIR-3016: the worker process of a model could not be started");
  EXPECT_SAYS(error, "/not-there/weir-worker: No such file or directory");
  EXPECT_SAYS(error, "fix: make install");
}

TEST_F(Program, ADifferentVersionIsReported) {
  const std::string error = error_with("/bin/true");
  EXPECT_SAYS(error, "WEIR-3016: the worker program is not the weir-worker of this version");
  EXPECT_SAYS(error, "/bin/true: exit(0)");
}

// Run by the test below in a separate process, which exits without notifying its worker.
TEST_F(IsolatedTest, DISABLED_EndsAtOnce) {
  ASSERT_TRUE(open());
  std::printf("worker=%llu\n", static_cast<unsigned long long>(result_of({kProcess})));
  std::fflush(stdout);
  _exit(0);
}

TEST(Worker, NeverOutlivesItsPipeline) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const io::Descriptor read_end(ends[0]);
  pid_t child = -1;
  {
    const io::Descriptor write_end(ends[1]);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, write_end.get(), 1);
    std::string self = "/proc/self/exe", all = "--gtest_also_run_disabled_tests",
                filter = "--gtest_filter=*DISABLED_EndsAtOnce";
    char* const arguments[] = {self.data(), all.data(), filter.data(), nullptr};
    ASSERT_EQ(posix_spawn(&child, self.c_str(), &actions, nullptr, arguments, environ), 0);
    posix_spawn_file_actions_destroy(&actions);
  }
  std::string text;
  char part[256];
  for (ssize_t got = 0; (got = read(read_end.get(), part, sizeof part)) > 0;)
    text.append(part, static_cast<size_t>(got));  // until EOF: the worker has this pipe too
  waitpid(child, nullptr, 0);
  const size_t at = text.find("worker=");
  ASSERT_NE(at, std::string::npos) << text;
  const auto worker = static_cast<pid_t>(std::atol(text.c_str() + at + 7));
  const io::Descriptor process(pidfd_open(worker, 0));
  if (!process) return;  // already gone
  pollfd watched{process.get(), POLLIN, 0};
  EXPECT_EQ(poll(&watched, 1, 30000), 1) << "the worker lives on";
}

}  // namespace confinement_test
}  // namespace weir::isolate
