// Parses ini files, and rejects lines that are not entries.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/config/ini.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "says.hpp"
#include "weir/join.hpp"

namespace weir::config {
namespace ini_test {

// "group/key=value@line" for each entry.
std::string entries(const Ini& ini) {
  return join(ini.entries, " ", [](const auto& e) {
    return e.group + "/" + e.key + "=" + e.value + "@" + std::to_string(e.line);
  });
}
std::string faults(const Ini& ini) {
  std::string out;
  for (const auto& fault : ini.faults) out += fault.message() + "\n";
  return out;
}

TEST(Ini, HasGroupsKeysAndValues) {
  const auto ini = parse_ini(
      "# a comment\n\n[filter]\n priority_tflite = a, b \nempty=\n; another\n[a group]\nk=v=w\n"
      "[filter]\r\nlast=1\r\n",
      "x.ini");
  EXPECT_EQ(faults(ini), "");
  EXPECT_EQ(entries(ini),
            "filter/priority_tflite=a, b@4 filter/empty=@5 a group/k=v=w@8 filter/last=1@10");
}

TEST(Ini, MayEndWithoutALineEndAndBeginWithAByteOrderMark) {
  const auto ini = parse_ini("\xEF\xBB\xBF[g]\nk=v", "x.ini");
  EXPECT_EQ(faults(ini) + entries(ini), "g/k=v@2");
  EXPECT_EQ(entries(parse_ini("", "x.ini")), "");
}

TEST(Ini, ReportsFileAndLineOfErrors) {
  const auto ini =
      parse_ini("k=v\n[g]\nhello\n=5\nk=v\n[broken\nlost=1\n[]\n[h]\nk=w\n", "/etc/x.ini");
  EXPECT_EQ(entries(ini), "g/k=v@5 h/k=w@10");
  const auto text = faults(ini);
  EXPECT_EQ(ini.faults.size(), 5u);
  EXPECT_SAYS(text, "WEIR-1001: /etc/x.ini:1: the key is not in a group\n  offered: k=v");
  EXPECT_SAYS(text, "/etc/x.ini:3: the line is neither a group nor a key with its value");
  EXPECT_SAYS(text, "/etc/x.ini:4: the line is neither");
  EXPECT_SAYS(text, "/etc/x.ini:6: the group name cannot be read\n  offered: [broken");
  EXPECT_SAYS(text, "/etc/x.ini:8: the group name cannot be read\n  offered: []");
}

TEST(Ini, EscapesALineForTerminalsAndJson) {
  const auto offered = [](const std::string& line) {
    const auto ini = parse_ini("[g]\n" + line + "\n", "x");
    return ini.faults.empty() ? "" : ini.faults[0].offered;
  };
  EXPECT_EQ(offered("gr\xC3\xBC\xC3\x9F \xE2\x82\xAC \xF0\x9F\x98\x80"),
            "gr\xC3\xBC\xC3\x9F \xE2\x82\xAC \xF0\x9F\x98\x80");
  EXPECT_EQ(offered("a\x1B[2Jb\x7F"), "a?[2Jb?");
  EXPECT_EQ(offered("b\xC2\x9B"), "b??") << "an order of eight bits";
  EXPECT_EQ(offered("\xFF\xC3:\x80\xE2\x82"), "??:???");
  EXPECT_EQ(offered("\xC0\xAF\xED\xA0\x80\xF4\x90\x80\x80\xE0\x80\xAF"), "????????????")
      << "overlong, surrogates, beyond the last";
  EXPECT_EQ(offered(std::string(60, 'a')), std::string(60, 'a'));
  EXPECT_EQ(offered(std::string(59, 'a') + "\xC3\xBC"), std::string(59, 'a') + "...")
      << "no half character";
}

TEST(Ini, SkipsLinesThatAreNotText) {
  const auto ini = parse_ini(std::string_view("[g]\na\0b=1\nk=v\n", 15), "x");
  EXPECT_EQ(entries(ini), "g/k=v@3");
  EXPECT_SAYS(faults(ini), "x:2: the line is not text\n  offered: a?b=1");
}

TEST(Ini, LimitsSizeAndKeys) {
  EXPECT_SAYS(faults(parse_ini("[g]\nk=" + std::string(5000, 'v'), "x")),
              "x:2: the line is too long");
  EXPECT_SAYS(faults(parse_ini(std::string((1 << 20) + 1, '\n'), "x")), "the file is too long");
  std::string many = "[g]\n";
  for (int i = 0; i < 5000; ++i) many += "k=v\n";
  const auto keys = parse_ini(many, "x");
  EXPECT_EQ(keys.entries.size(), 4096u);
  EXPECT_SAYS(faults(keys), "x:4097: too many keys: the rest of the file is ignored");
  std::string wrong;
  for (int i = 0; i < 100; ++i) wrong += "no\n";
  EXPECT_EQ(parse_ini(wrong, "x").faults.size(), 17u);
}

TEST(Ini, IsReadFromAFile) {
  const auto path = testing::TempDir() + "weir-ini-test.ini";
  std::ofstream(path) << "[g]\nk=v\nx\n";
  const auto ini = read_ini(path);
  EXPECT_EQ(entries(ini), "g/k=v@2");
  EXPECT_SAYS(faults(ini), path + ":3: ");
  std::filesystem::remove(path);
  for (const auto& none : {path, testing::TempDir()}) {
    const auto missing = read_ini(none);
    ASSERT_EQ(missing.faults.size(), 1u);
    EXPECT_EQ(missing.faults[0].code, Code::FILE_NOT_FOUND);
    EXPECT_SAYS(missing.faults[0].message(), none);
  }
}

TEST(Ini, ParsesBooleansByTheirFirstLetters) {
  for (const char* text : {"1", "true", "True", "yes", "Y", "on", "ON", "t"})
    EXPECT_TRUE(truth(text, false)) << text;
  for (const char* text : {"0", "false", "F", "no", "off", "Of"})
    EXPECT_FALSE(truth(text, true)) << text;
  for (const char* text : {"", "maybe", "2", "o", " 1"}) {
    EXPECT_TRUE(truth(text, true)) << text;
    EXPECT_FALSE(truth(text, false)) << text;
  }
}

}  // namespace ini_test
}  // namespace weir::config
