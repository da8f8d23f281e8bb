// What a module in a worker process cannot do, and how long it lives.
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>

extern "C" {  // glibc 2.36 does not say so itself
#include <sys/pidfd.h>
}

#include <cerrno>
#include <cstdio>
#include <cstdlib>

#include "core/isolate/descriptor.hpp"
#include "core/isolate/isolated_test_support.hpp"

extern char** environ;

namespace weir::isolate {
namespace {

class Confinement : public IsolatedTest {
 protected:
  void SetUp() override {
    IsolatedTest::SetUp();
    ASSERT_TRUE(open());
  }
};

TEST_F(Confinement, SaysWhatItIs) {
  const std::string words = isolation_.monitor->confinement();
  EXPECT_SAYS(words, "no new sockets, programs or processes");
  EXPECT_SAYS(words, "network");
  EXPECT_SAYS(words, "any memory");
}

TEST_F(Confinement, AllowsNoSocket) {
  EXPECT_EQ(result_of({kSocket}), uint64_t{EPERM});
}
TEST_F(Confinement, AllowsNoProcess) {
  EXPECT_EQ(result_of({kFork}), uint64_t{EPERM});
}
TEST_F(Confinement, AllowsNoProgram) {
  EXPECT_EQ(result_of({kExec}), uint64_t{EPERM});
}
TEST_F(Confinement, AllowsNoSignalToOthers) {
  EXPECT_EQ(result_of({kKillParent}), uint64_t{EPERM});
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

TEST_F(Program, ThatIsNotThereIsNamed) {
  const std::string error = error_with("/not-there/weir-worker");
  EXPECT_SAYS(error, "WEIR-3016: the worker process of a model could not be started");
  EXPECT_SAYS(error, "/not-there/weir-worker: No such file or directory");
  EXPECT_SAYS(error, "fix: make install");
}

TEST_F(Program, ThatIsAnotherIsNamed) {
  const std::string error = error_with("/bin/true");
  EXPECT_SAYS(error, "WEIR-3016: the program for workers is not this version's weir-worker");
  EXPECT_SAYS(error, "/bin/true: exit(0)");
}

// Run by the test below in a process of its own, which ends without a word to its worker.
TEST_F(IsolatedTest, DISABLED_EndsAtOnce) {
  ASSERT_TRUE(open());
  std::printf("worker=%llu\n", static_cast<unsigned long long>(result_of({kProcess})));
  std::fflush(stdout);
  _exit(0);
}

TEST(Worker, NeverOutlivesItsPipeline) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const Descriptor read_end(ends[0]);
  pid_t child = -1;
  {
    const Descriptor write_end(ends[1]);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, write_end.get(), 1);
    std::string self = "/proc/self/exe", all = "--gtest_also_run_disabled_tests",
                filter = "--gtest_filter=*DISABLED_EndsAtOnce";
    char* const arguments[] = {self.data(), all.data(), filter.data(), nullptr};
    ASSERT_EQ(posix_spawn(&child, self.c_str(), &actions, nullptr, arguments, environ), 0);
    posix_spawn_file_actions_destroy(&actions);
  }
  std::string said;
  char part[256];
  for (ssize_t got = 0; (got = read(read_end.get(), part, sizeof part)) > 0;)
    said.append(part, static_cast<size_t>(got));  // to the end: the worker has this pipe too
  waitpid(child, nullptr, 0);
  const size_t at = said.find("worker=");
  ASSERT_NE(at, std::string::npos) << said;
  const auto worker = static_cast<pid_t>(std::atol(said.c_str() + at + 7));
  const Descriptor process(pidfd_open(worker, 0));
  if (!process) return;  // gone already
  pollfd watched{process.get(), POLLIN, 0};
  EXPECT_EQ(poll(&watched, 1, 30000), 1) << "the worker lives on";
}

}  // namespace
}  // namespace weir::isolate
