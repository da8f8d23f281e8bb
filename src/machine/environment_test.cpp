// Tests the environment of a program with more rights than the user who starts it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "environment.hpp"

#include <gtest/gtest.h>
#include <sys/auxv.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <string>

namespace weir {
namespace environment_test {

namespace fs = std::filesystem;

constexpr char kVariable[] = "WEIR_TEST_VARIABLE";
constexpr uid_t kNobody = 65534;
constexpr int kNotSecure = 77;

TEST(Environment, IsReadByAnOrdinaryProgram) {
  ASSERT_EQ(getauxval(AT_SECURE), 0u);
  setenv(kVariable, "x", 1);
  EXPECT_STREQ(environment_variable(kVariable), "x");
  unsetenv(kVariable);
  EXPECT_EQ(environment_variable(kVariable), nullptr);
}

// Runs as a copy of this program with another user's rights.
TEST(Environment, DISABLED_InASetUserIdProgram) {
  if (getauxval(AT_SECURE) == 0) std::_Exit(kNotSecure);
  ASSERT_STREQ(std::getenv(kVariable), "x") << "it is there";
  EXPECT_EQ(environment_variable(kVariable), nullptr) << "and is not used";
}

TEST(Environment, IsNotReadByASetUserIdProgram) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers do not run in such programs";
#endif
  if (geteuid() != 0) GTEST_SKIP() << "only root makes a program of another user's";
  std::string folder = (fs::temp_directory_path() / "weir-environment-XXXXXX").string();
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  chmod(folder.c_str(), 0755);
  const fs::path copy = fs::path(folder) / "program";
  fs::copy_file("/proc/self/exe", copy);
  ASSERT_EQ(chown(copy.c_str(), kNobody, kNobody), 0);
  ASSERT_EQ(chmod(copy.c_str(), 04755), 0);
  setenv(kVariable, "x", 1);
  const std::string command = copy.string() +
                              " --gtest_also_run_disabled_tests --gtest_brief=1 "
                              "--gtest_filter=Environment.DISABLED_InASetUserIdProgram";
  const int status = std::system(command.c_str());
  unsetenv(kVariable);
  fs::remove_all(folder);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == kNotSecure) GTEST_SKIP() << "the folder's disk has no set-user-ID";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace environment_test
}  // namespace weir
