// Setting an environment variable under readers.
#include "environment_variable.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

namespace weir::engine {
namespace {

std::string value_of(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "not set";
}

TEST(EnvironmentVariable, IsSetAndLeavesTheOldEnvironmentAsItIs) {
  setenv("WEIR_TEST_OF_GLIBC", "1", 1);  // `environ` is memory that setenv() allocated
  char** const old = environ;
  const std::vector<char*> entries = [old] {
    std::vector<char*> out;
    for (char** entry = old; *entry; ++entry) out.push_back(*entry);
    return out;
  }();
  add_environment_variable("WEIR_TEST_ADDED=2");
  EXPECT_EQ(value_of("WEIR_TEST_ADDED"), "2");
  EXPECT_EQ(value_of("WEIR_TEST_OF_GLIBC"), "1");
  EXPECT_NE(environ, old) << "readers of the old environment would see it change";
  for (size_t i = 0; i < entries.size(); ++i) EXPECT_EQ(old[i], entries[i]);
  EXPECT_EQ(old[entries.size()], nullptr);
}

TEST(EnvironmentVariable, ThatIsSetStays) {
  setenv("WEIR_TEST_SET", "mine", 1);
  char** const old = environ;
  add_environment_variable("WEIR_TEST_SET=other");
  EXPECT_EQ(value_of("WEIR_TEST_SET"), "mine");
  EXPECT_EQ(environ, old);
}

TEST(EnvironmentVariable, CanBeChangedAndTakenAwayByTheProgram) {
  add_environment_variable("WEIR_TEST_CHANGED=1");
  setenv("WEIR_TEST_CHANGED", "2", 1);
  EXPECT_EQ(value_of("WEIR_TEST_CHANGED"), "2");
  unsetenv("WEIR_TEST_CHANGED");
  EXPECT_EQ(value_of("WEIR_TEST_CHANGED"), "not set");
}

TEST(EnvironmentVariable, CanBeSetWhileThreadsReadOthers) {
  setenv("WEIR_TEST_READ", "always", 1);
  static std::vector<std::string> assignments;
  for (int i = 0; i < 200; ++i)
    assignments.push_back("WEIR_TEST_" + std::to_string(i) + "=" + std::to_string(i));
  std::atomic<bool> done = false;
  std::atomic<int> wrong = 0;
  std::vector<std::thread> readers;
  for (int i = 0; i < 3; ++i)
    readers.emplace_back([&] {
      while (!done) wrong += value_of("WEIR_TEST_READ") != "always";
    });
  for (const auto& assignment : assignments) add_environment_variable(assignment.c_str());
  done = true;
  for (auto& reader : readers) reader.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(value_of("WEIR_TEST_199"), "199");
}

}  // namespace
}  // namespace weir::engine
