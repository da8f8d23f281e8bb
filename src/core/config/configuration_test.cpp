// The precedence of configuration files and variables.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/config/configuration.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

#include "says.hpp"

namespace weir::config {
namespace configuration_test {

namespace fs = std::filesystem;
using Variables = std::map<std::string, std::string>;

class ConfigurationTest : public ::testing::Test {
 protected:
  ConfigurationTest() : folder_(fs::path(testing::TempDir()) / "weir-configuration-test") {
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "home/.config/weir");
  }
  ~ConfigurationTest() override { fs::remove_all(folder_); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  // Without the files of this machine and user, unless the variables name one.
  static Configuration with(Variables variables) {
    return Configuration([variables = std::move(variables)](const char* name) -> const char* {
      const auto found = variables.find(name);
      return found == variables.end() ? nullptr : found->second.c_str();
    });
  }
  fs::path folder_;
};

std::string found(const Configuration& configuration, const char* group, const char* key) {
  const auto setting = configuration.find(group, key);
  return setting ? setting->value + " from " + setting->origin : "nothing";
}

TEST_F(ConfigurationTest, ReadsOnlyTheFileNamedByTheVariable) {
  const auto path = write("own.ini", "[filter]\npriority_onnx=a\npriority_onnx=b\n");
  write("home/.config/weir/weir.ini", "[module]\npath=/home\n");
  const auto own = with({{"WEIR_CONFIG", path}, {"HOME", (folder_ / "home").string()}});
  EXPECT_EQ(found(own, "filter", "priority_onnx"), "b from " + path + ":3")
      << "the last line counts";
  EXPECT_EQ(found(own, "module", "path"), "nothing");
  ASSERT_EQ(own.files().size(), 1u);
  EXPECT_TRUE(own.files()[0].found);
  EXPECT_TRUE(own.faults().empty());
}

TEST_F(ConfigurationTest, ReadsNoFileWhereTheVariableIsEmpty) {
  write("home/.config/weir/weir.ini", "[module]\npath=/home\n");
  const auto none = with({{"WEIR_CONFIG", ""}, {"HOME", (folder_ / "home").string()}});
  EXPECT_TRUE(none.files().empty());
  EXPECT_EQ(found(none, "module", "path"), "nothing");
}

TEST_F(ConfigurationTest, LooksForTheUsersFileFirst) {
  const auto home = (folder_ / "home").string();
  const auto path = write("home/.config/weir/weir.ini", "[module]\npath=/home\n");
  const auto user = with({{"HOME", home}});
  EXPECT_EQ(found(user, "module", "path"), "/home from " + path + ":2");
  ASSERT_GE(user.files().size(), 2u);
  EXPECT_EQ(user.files()[0].path, path);
  EXPECT_EQ(user.files().back().path, "/etc/weir/weir.ini");
  const auto elsewhere = with({{"HOME", home}, {"XDG_CONFIG_HOME", (folder_ / "xdg").string()}});
  EXPECT_EQ(elsewhere.files()[0].path, (folder_ / "xdg/weir/weir.ini").string());
  EXPECT_FALSE(elsewhere.files()[0].found);
  EXPECT_TRUE(elsewhere.faults().empty()) << "it need not be there";
}

TEST_F(ConfigurationTest, AVariableOverridesASingleValue) {
  const auto path = write("own.ini", "[filter]\npriority_tflite=a\nenable_symlink=yes\n");
  const auto both = with({{"WEIR_CONFIG", path}, {"WEIR_FILTER_PRIORITY_TFLITE", "b"}});
  EXPECT_EQ(found(both, "filter", "priority_tflite"), "b from WEIR_FILTER_PRIORITY_TFLITE");
  EXPECT_EQ(found(both, "filter", "enable_symlink"), "yes from " + path + ":3");
  EXPECT_EQ(variable_name("filter-aliases", "a.b"), "WEIR_FILTER_ALIASES_A_B");
}

TEST_F(ConfigurationTest, ReportsThatTheNamedFileIsMissing) {
  const auto missing = with({{"WEIR_CONFIG", "/no/such/weir.ini"}});
  ASSERT_EQ(missing.faults().size(), 1u);
  EXPECT_EQ(missing.faults()[0].code, Code::FILE_NOT_FOUND);
  EXPECT_SAYS(missing.faults()[0].message(), "offered: /no/such/weir.ini");
  EXPECT_SAYS(missing.faults()[0].message(),
              "needed: an existing file, because WEIR_CONFIG names it");
}

TEST_F(ConfigurationTest, ReportsWhyAnExistingFileCannotBeRead) {
  fs::create_directories(folder_ / "weir/weir.ini");
  const auto c = with({{"XDG_CONFIG_HOME", folder_.string()}});
  ASSERT_FALSE(c.files().empty());
  EXPECT_TRUE(c.files()[0].found);
  EXPECT_FALSE(c.files()[0].read);
  ASSERT_EQ(c.faults().size(), 1u);
  EXPECT_SAYS(c.faults()[0].message(), "WEIR-4001: the configuration file cannot be read");
  EXPECT_SAYS(c.faults()[0].message(), "offered: " + (folder_ / "weir/weir.ini").string());
  EXPECT_SAYS(c.faults()[0].message(), "it is a folder");
}

// root may read every file, so this part runs as another user.
TEST_F(ConfigurationTest, ReportsThatAFileIsNotReadable) {
  constexpr uid_t kNobody = 65534;
  const auto path = write("closed.ini", "[module]\npath=/m\n");
  fs::permissions(path, fs::perms::none);
  const bool root = geteuid() == 0;
  if (root && seteuid(kNobody) != 0) GTEST_SKIP() << "there is no other user here";
  const auto c = with({{"WEIR_CONFIG", path}});
  if (root) {
    ASSERT_EQ(seteuid(0), 0);
  }
  EXPECT_FALSE(c.files()[0].read);
  ASSERT_EQ(c.faults().size(), 1u);
  EXPECT_SAYS(c.faults()[0].message(), "offered: " + path);
  EXPECT_SAYS(c.faults()[0].message(), "Permission denied");
  EXPECT_TRUE(c.all().empty());
}

TEST_F(ConfigurationTest, ReportsUnknownSettings) {
  const auto path =
      write("own.ini", "[filter]\npriorty_tflite=a\n[modul]\npath=/x\n[other]\nx=1\nhello\n");
  const auto typo = with({{"WEIR_CONFIG", path}});
  EXPECT_TRUE(typo.all().empty());
  std::string text;
  for (const auto& fault : typo.faults()) text += fault.message() + "\n";
  EXPECT_EQ(typo.faults().size(), 4u);
  EXPECT_SAYS(text, path + ":2: unknown setting\n  offered: [filter] priorty_tflite");
  EXPECT_SAYS(text, "did you mean [filter] priority_tflite?");
  EXPECT_SAYS(text, "did you mean [module] path?");
  EXPECT_SAYS(text, path + ":6: unknown setting\n  offered: [other] x");
  EXPECT_SAYS(text, path + ":7: the line is neither");
}

std::string possible_fault(const Configuration& configuration, const char* group = "lua",
                           const char* key = "sandbox") {
  const auto fault = configuration.possible_fault(group, key);
  return fault ? fault->message() : "none";
}

TEST_F(ConfigurationTest, AnyFaultOfAFileIsADoubt) {
  const std::pair<std::string, const char*> cases[] = {
      {"[lua\nsandbox = true\n", ":1: the group name cannot be read"},
      {"[lua]\nsandbox true\n", ":2: the line is neither"},
      {"sandbox = true\n", ":1: the key is not in a group"},
      {"[lua]\nsandbox = true\n[filter]\nhello\n", ":4: the line is neither"},
      {"[lua]\nsanbox = true\n", ":2: unknown setting"},
      {"[Lua]\nsandbox = true\n", ":2: unknown setting"},
      {"[other]\nSandbox = true\n", ":2: unknown setting"},
      {std::string((1 << 20) + 1, '\n'), ": the file is too long"},
  };
  for (const auto& [text, what] : cases) {
    const auto path = write("doubt.ini", text);
    EXPECT_SAYS(possible_fault(with({{"WEIR_CONFIG", path}})), path + what);
    EXPECT_EQ(possible_fault(with({{"WEIR_CONFIG", path}, {"WEIR_LUA_SANDBOX", "false"}})), "none")
        << "the variable decides";
  }
}

TEST_F(ConfigurationTest, AFileWithoutAFaultLeavesNoDoubt) {
  for (const char* text : {"", "# nothing\n", "[lua]\nsandbox = true\n", "[lua]\nsandbox =\n",
                           "[module]\npath=/m\n[filter]\nabsent=1\n"})
    EXPECT_EQ(possible_fault(with({{"WEIR_CONFIG", write("own.ini", text)}})), "none") << text;
  EXPECT_EQ(possible_fault(with({{"WEIR_CONFIG", ""}})), "none");
  EXPECT_EQ(possible_fault(with({{"HOME", (folder_ / "absent").string()}})), "none")
      << "need not be there";
}

TEST_F(ConfigurationTest, ANamedFileThatDoesNotExistIsADoubt) {
  EXPECT_SAYS(possible_fault(with({{"WEIR_CONFIG", "/no/such/weir.ini"}})),
              "offered: /no/such/weir.ini");
}

// A link to itself: whether the file exists cannot be determined.
TEST_F(ConfigurationTest, AFileThatCannotBeSearchedForIsADoubt) {
  fs::create_symlink("weir.ini", folder_ / "home/.config/weir/weir.ini");
  const auto c = with({{"HOME", (folder_ / "home").string()}});
  EXPECT_TRUE(c.files()[0].found);
  EXPECT_FALSE(c.files()[0].read);
  EXPECT_SAYS(possible_fault(c), "offered: " + c.files()[0].path);
  EXPECT_SAYS(possible_fault(c), "symbolic links");
}

TEST_F(ConfigurationTest, AFileInAClosedFolderIsADoubt) {
  constexpr uid_t kNobody = 65534;
  const auto path = write("home/.config/weir/weir.ini", "[lua]\nsandbox=true\n");
  fs::permissions(folder_ / "home/.config/weir", fs::perms::none);
  const bool root = geteuid() == 0;
  if (root && seteuid(kNobody) != 0) GTEST_SKIP() << "there is no other user here";
  const auto c = with({{"HOME", (folder_ / "home").string()}});
  if (root) {
    ASSERT_EQ(seteuid(0), 0);
  }
  fs::permissions(folder_ / "home/.config/weir", fs::perms::owner_all);
  EXPECT_SAYS(possible_fault(c), "offered: " + path);
  EXPECT_SAYS(possible_fault(c), "Permission denied");
}

// The user's file has precedence, and so do its faults.
TEST_F(ConfigurationTest, ADoubtIsAboutTheFilesUpToTheOneThatDecides) {
  const auto home = (folder_ / "home").string();
  const Variables first{{"HOME", home}};
  write("home/.config/weir/weir.ini", "[module\npath=/m\n[lua]\nsandbox=false\n");
  EXPECT_SAYS(possible_fault(with(first)), "weir.ini:1: ");
  EXPECT_SAYS(possible_fault(with(first), "module", "path"), "weir.ini:1: ");
}

TEST_F(ConfigurationTest, ListsWhatHasAnEffect) {
  const auto path =
      write("own.ini", "[module]\npath=/m\n[filter]\npriority_onnx=a\npriority_onnx=b\n");
  setenv("WEIR_FILTER_PRIORITY_PT", "pytorch", 1);
  const auto all = with({{"WEIR_CONFIG", path}, {"WEIR_FILTER_PATH", "/f"}}).all();
  unsetenv("WEIR_FILTER_PRIORITY_PT");
  std::string text;
  for (const auto& s : all) text += s.group + "/" + s.key + "=" + s.value + "\n";
  EXPECT_EQ(text,
            "filter/path=/f\nfilter/priority_onnx=b\nfilter/priority_pt=pytorch\nmodule/path=/m\n");
}

}  // namespace configuration_test
}  // namespace weir::config
