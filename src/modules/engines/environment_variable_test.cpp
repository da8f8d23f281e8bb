// Tests setting an environment variable during concurrent reads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "environment_variable.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <deque>
#include <string>
#include <thread>
#include <vector>

namespace weir::engine {
namespace environment_variable_test {

std::string get_value(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "not set";
}

// Returns "NAME=value" with a new name per call; the text is never freed.
const char* fresh(const std::string& value, std::string* name) {
  static int count = 0;
  static std::deque<std::string> kept;
  *name = "WEIR_TEST_" + std::to_string(++count);
  return kept.emplace_back(*name + "=" + value).c_str();
}

TEST(EnvironmentVariable, IsSetWithoutChangingTheOldEnvironment) {
  unsetenv("WEIR_TEST_OF_GLIBC");
  setenv("WEIR_TEST_OF_GLIBC", "1", 1);  // makes setenv() allocate `environ`
  char** const old = environ;
  const std::vector<char*> entries = [old] {
    std::vector<char*> out;
    for (char** entry = old; *entry; ++entry) out.push_back(*entry);
    return out;
  }();
  std::string name;
  add_environment_variable(fresh("2", &name));
  EXPECT_EQ(get_value(name.c_str()), "2");
  EXPECT_EQ(get_value("WEIR_TEST_OF_GLIBC"), "1");
  EXPECT_NE(environ, old) << "readers of the old environment would see it change";
  for (size_t i = 0; i < entries.size(); ++i) EXPECT_EQ(old[i], entries[i]);
  EXPECT_EQ(old[entries.size()], nullptr);
}

TEST(EnvironmentVariable, ThatIsSetStays) {
  setenv("WEIR_TEST_SET", "mine", 1);
  char** const old = environ;
  add_environment_variable("WEIR_TEST_SET=other");
  EXPECT_EQ(get_value("WEIR_TEST_SET"), "mine");
  EXPECT_EQ(environ, old);
}

TEST(EnvironmentVariable, CanBeChangedAndRemovedByTheProgram) {
  std::string name;
  add_environment_variable(fresh("1", &name));
  setenv(name.c_str(), "2", 1);
  EXPECT_EQ(get_value(name.c_str()), "2");
  unsetenv(name.c_str());
  EXPECT_EQ(get_value(name.c_str()), "not set");
}

TEST(EnvironmentVariable, CanBeSetWhileThreadsReadOthers) {
  setenv("WEIR_TEST_READ", "always", 1);
  std::atomic<bool> done = false;
  std::atomic<int> wrong = 0;
  std::vector<std::thread> readers;
  for (int i = 0; i < 3; ++i)
    readers.emplace_back([&] {
      while (!done) wrong += get_value("WEIR_TEST_READ") != "always";
    });
  std::string name;
  for (int i = 0; i < 200; ++i) add_environment_variable(fresh(std::to_string(i), &name));
  done = true;
  for (auto& reader : readers) reader.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(get_value(name.c_str()), "199");
}

}  // namespace environment_variable_test
}  // namespace weir::engine
