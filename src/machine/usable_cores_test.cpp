// Tests counting cores on this machine, and in a directory tree created by the test.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "usable_cores.hpp"

#include <gtest/gtest.h>
#include <sched.h>

#include <filesystem>
#include <fstream>
#include <thread>

namespace weir {
namespace usable_cores_test {

namespace fs = std::filesystem;

class UsableCores : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) /
            ("cores_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(root_);
  }
  void TearDown() override { fs::remove_all(root_); }
  void write(const std::string& path, const std::string& text) {
    fs::create_directories((root_ / path).parent_path());
    std::ofstream(root_ / path) << text;
  }
  // CPUs that this test may use, two per core.
  int write_pairs_of_cpus() {
    cpu_set_t mask;
    CPU_ZERO(&mask);
    sched_getaffinity(0, sizeof mask, &mask);
    int count = 0;
    for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
      if (!CPU_ISSET(cpu, &mask)) continue;
      const std::string place = "sys/devices/system/cpu/cpu" + std::to_string(cpu) + "/topology/";
      write(place + "physical_package_id", "0");
      write(place + "core_id", std::to_string(count++ / 2));
    }
    return count;
  }
  std::string root() const { return root_.string(); }
  fs::path root_;
};

TEST_F(UsableCores, CountsTheThreadsOfACoreOnce) {
  const int cpus = write_pairs_of_cpus();
  EXPECT_EQ(usable_cores(root()), (cpus + 1) / 2);
}

TEST_F(UsableCores, KeepsToTheQuotaOfEachGroupAboveTheProcess) {
  write("proc/self/cgroup", "0::/outer/inner\n");
  write("sys/fs/cgroup/outer/inner/cpu.max", "max 100000\n");
  write("sys/fs/cgroup/outer/cpu.max", "50000 100000\n");
  EXPECT_EQ(usable_cores(root()), 1);
}

TEST_F(UsableCores, TakesAQuotaThatCannotBeReadForNone) {
  const int without = usable_cores(root());
  write("proc/self/cgroup", "0::/\n");
  write("sys/fs/cgroup/cpu.max", "much\n");
  EXPECT_EQ(usable_cores(root()), without);
  EXPECT_GE(without, 1);
}

TEST(UsableCoresOfThisMachine, AreBetweenOneAndItsProcessors) {
  EXPECT_GE(usable_cores(), 1);
  EXPECT_LE(usable_cores(), static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
}

TEST(UsableCoresOfThisMachine, FollowTheAffinityOfTheThread) {
  int found = 0;
  std::thread([&found] {
    cpu_set_t mask;
    ASSERT_EQ(sched_getaffinity(0, sizeof mask, &mask), 0);
    int first = 0;
    while (!CPU_ISSET(first, &mask)) ++first;
    CPU_ZERO(&mask);
    CPU_SET(first, &mask);
    ASSERT_EQ(sched_setaffinity(0, sizeof mask, &mask), 0);
    found = usable_cores();
  }).join();
  EXPECT_EQ(found, 1);
}

}  // namespace usable_cores_test
}  // namespace weir
