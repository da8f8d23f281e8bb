// Precedence of NNStreamer's files and variables, the folders of sub-plugins, and the reported
// faults.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/config/nnstreamer.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>

#include "says.hpp"

namespace weir::config {
namespace nnstreamer_test {

namespace fs = std::filesystem;
using Variables = std::map<std::string, std::string>;

class NnstreamerConfigurationTest : public ::testing::Test {
 protected:
  NnstreamerConfigurationTest() : folder_(fs::path(testing::TempDir()) / "weir-nnstreamer-ini") {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~NnstreamerConfigurationTest() override { fs::remove_all(folder_); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  // With a file of this text, the given variables and no weir.ini.
  NnstreamerConfiguration with(const std::string& text, Variables variables = {}) const {
    variables.try_emplace("NNSTREAMER_CONF", write("nns.ini", text));
    return of(std::move(variables));
  }
  static NnstreamerConfiguration of(Variables variables) {
    variables.try_emplace("WEIR_CONFIG", "");
    return NnstreamerConfiguration(
        [variables = std::move(variables)](const char* name) -> const char* {
          const auto found = variables.find(name);
          return found == variables.end() ? nullptr : found->second.c_str();
        });
  }
  std::string file() const { return (folder_ / "nns.ini").string(); }
  fs::path folder_;
};

std::string found(const NnstreamerConfiguration& c, const char* group, const char* key) {
  const auto setting = c.find(group, key);
  return setting ? setting->value + " from " + setting->origin : "nothing";
}
// "PATH from ORIGIN" for each folder, one per line.
std::string folders(const NnstreamerConfiguration& c, FolderKind kind) {
  std::string out;
  for (const auto& folder : c.folders(kind)) out += folder.path + " from " + folder.origin + "\n";
  return out;
}
std::string faults(const NnstreamerConfiguration& c) {
  std::string out;
  for (const auto& fault : c.faults()) out += fault.message() + "\n";
  return out;
}
std::string state(const NnstreamerConfiguration& c, const std::string& path) {
  for (const auto& candidate : c.candidates())
    if (candidate.path == path) return candidate.source + ": " + to_string(candidate.state);
  return "no candidate";
}

TEST_F(NnstreamerConfigurationTest, ReadsTheFileThatTheVariableNames) {
  const auto c = with("[common]\nenable_symlink=yes\n# a comment\n[filter]\nfilters = /a/b\n");
  EXPECT_EQ(faults(c), "");
  EXPECT_EQ(c.path(), file());
  EXPECT_EQ(state(c, file()), "NNSTREAMER_CONF: read");
  ASSERT_EQ(c.candidates().size(), 3u) << "also where what Weir is built for is what is hard-coded";
  EXPECT_EQ(c.candidates()[1].source, "built for");
  EXPECT_EQ(c.candidates()[2].source, "hard-coded");
  EXPECT_EQ(c.candidates()[2].path, "/etc/nnstreamer.ini");
  EXPECT_EQ(c.candidates()[2].state, NnstreamerConfiguration::State::NotNeeded);
  EXPECT_EQ(found(c, "filter", "filters"), "/a/b from " + file() + ":5");
  EXPECT_TRUE(c.enable_symlink());
  EXPECT_FALSE(c.enable_envvar());
}

TEST_F(NnstreamerConfigurationTest, NeedsNoFile) {
  const auto c = of({{"NNSTREAMER_CONF", (folder_ / "none.ini").string()}});
  EXPECT_SAYS(faults(c), "WEIR-4001: NNSTREAMER_CONF does not name a regular file and is ignored");
  EXPECT_SAYS(faults(c), "offered: " + (folder_ / "none.ini").string());
  EXPECT_EQ(state(c, (folder_ / "none.ini").string()), "NNSTREAMER_CONF: not found");
  EXPECT_SAYS(folders(c, FolderKind::Decoders), "/usr/lib/nnstreamer/decoders from hard-coded");
  const auto unset = of({});
  EXPECT_EQ(unset.candidates().front().source, "built for");
}

// What a process of another user reads, if the test runs as root; root itself may read every file.
NnstreamerConfiguration as_other_user(const Variables& variables) {
  constexpr uid_t kNobody = 65534;
  const bool root = geteuid() == 0;
  EXPECT_TRUE(!root || seteuid(kNobody) == 0) << "there is no other user here";
  NnstreamerConfiguration out([&](const char* name) -> const char* {
    const auto found = variables.find(name);
    return found == variables.end() ? nullptr : found->second.c_str();
  });
  EXPECT_TRUE(!root || seteuid(0) == 0);
  return out;
}

TEST_F(NnstreamerConfigurationTest, ReportsAFileThatCannotBeReachedAsUnread) {
  const auto closed = folder_ / "closed";
  fs::create_directory(closed);
  const std::string hidden = write("closed/nns.ini", "[element-restriction]\n");
  const std::string names_it = write("open.ini", "[common]\nextra_config_path=" + hidden + "\n");
  fs::permissions(closed, fs::perms::none);
  const auto direct = as_other_user({{"NNSTREAMER_CONF", hidden}, {"WEIR_CONFIG", ""}});
  const auto extra = as_other_user({{"NNSTREAMER_CONF", names_it}, {"WEIR_CONFIG", ""}});
  fs::permissions(closed, fs::perms::owner_all);
  EXPECT_EQ(direct.path(), hidden) << "no other candidate takes its place";
  for (const auto* c : {&direct, &extra}) {
    ASSERT_TRUE(c->unread());
    EXPECT_SAYS(c->unread()->message(), "offered: " + hidden);
    EXPECT_SAYS(c->unread()->message(), "Permission denied");
    EXPECT_EQ(state(*c, hidden).substr(state(*c, hidden).find(':')), ": cannot be read");
  }
}

TEST_F(NnstreamerConfigurationTest, ReadsItsFilesWhenTheHomeFolderCannotBeReached) {
  fs::create_directories(folder_ / "home/.config/weir");
  write("home/.config/weir/weir.ini", "[nnstreamer]\nenable=no\n");
  const std::string path = write("nns.ini", "[filter]\nfilters=/a\n");
  fs::permissions(folder_ / "home", fs::perms::none);
  const auto c = as_other_user({{"NNSTREAMER_CONF", path}, {"HOME", (folder_ / "home").string()}});
  fs::permissions(folder_ / "home", fs::perms::owner_all);
  EXPECT_TRUE(c.enabled());
  EXPECT_EQ(found(c, "filter", "filters"), "/a from " + path + ":2");
  EXPECT_FALSE(c.unread()) << c.unread()->message();
}

TEST_F(NnstreamerConfigurationTest, DoesNotReadAFolderAsItsFile) {
  const auto c = of({{"NNSTREAMER_CONF", folder_.string()}});
  EXPECT_EQ(state(c, folder_.string()), "NNSTREAMER_CONF: not a regular file");
  EXPECT_SAYS(faults(c), "does not name a regular file");
}

TEST_F(NnstreamerConfigurationTest, HasTheSyntaxOfKeyFiles) {
  const auto c =
      with("[g]\nk=first\na= two words\\tand\\\\more \n[h]\nx=1\n[g]\nk=last\n\n#k=no\n");
  EXPECT_EQ(found(c, "g", "k"), "last from " + file() + ":7") << "the last line counts";
  EXPECT_EQ(found(c, "g", "a"), "two words\tand\\more from " + file() + ":3");
}

TEST_F(NnstreamerConfigurationTest, ReportsFileAndLineOfErrors) {
  const auto c = with("lost=1\n[common]\nnonsense\nenable_symlink=1\n[broken\nx=1\n");
  EXPECT_EQ(c.faults().size(), 3u);
  EXPECT_SAYS(faults(c), file() + ":1: the key is not in a group");
  EXPECT_SAYS(faults(c), file() + ":3: the line is neither a group nor a key");
  EXPECT_SAYS(faults(c), file() + ":5: the group name cannot be read");
  EXPECT_TRUE(c.enable_symlink()) << "the other lines count";
}

TEST_F(NnstreamerConfigurationTest, ParsesBooleansByTheirFirstLetters) {
  for (const char* word : {"1", "true", "T", "yes", "Y1", "on", "ONE"})
    EXPECT_TRUE(with(std::string("[common]\nenable_symlink=") + word).enable_symlink()) << word;
  for (const char* word : {"0", "false", "F", "no", "N1", "off", "OF"})
    EXPECT_FALSE(with(std::string("[common]\nenable_symlink=") + word).enable_symlink()) << word;
  const auto c = with("[common]\nenable_symlink=maybe\n");
  EXPECT_FALSE(c.enable_symlink());
  EXPECT_SAYS(faults(c), "WEIR-1004: " + file() + ":2: neither true nor false");
  EXPECT_SAYS(faults(c), "offered: [common] enable_symlink=maybe");
}

TEST_F(NnstreamerConfigurationTest, UsesVariablesOnlyIfTheFileEnablesThem) {
  const Variables variables{{"NNSTREAMER_DECODERS", "/env"},
                            {"NNSTREAMER_pytorch_enable_use_gpu", "1"},
                            {"NNSTREAMER_common_enable_envvar", "1"}};
  const auto without = with("[pytorch]\nenable_use_gpu=0\n", variables);
  EXPECT_EQ(found(without, "pytorch", "enable_use_gpu"), "0 from " + file() + ":2");
  EXPECT_EQ(folders(without, FolderKind::Decoders),
            "/usr/lib/nnstreamer/decoders from hard-coded\n");
  EXPECT_FALSE(without.enable_envvar()) << "a variable cannot enable variables";
  const auto c = with("[common]\nenable_envvar=true\n[pytorch]\nenable_use_gpu=0\n", variables);
  EXPECT_EQ(found(c, "pytorch", "enable_use_gpu"), "1 from NNSTREAMER_pytorch_enable_use_gpu");
  EXPECT_EQ(folders(c, FolderKind::Decoders),
            "/env from NNSTREAMER_DECODERS\n/usr/lib/nnstreamer/decoders from hard-coded\n");
}

TEST_F(NnstreamerConfigurationTest, SearchesVariableFileHardCodedAndAdditionalFile) {
  const auto extra = write("extra.ini",
                           "[filter]\nfilters=/extra\nonly=here\ncustomfilters=/extra/custom\n"
                           "[decoder]\ndecoders=/usr/lib/nnstreamer/decoders/\n");
  const auto c =
      with("[common]\nenable_envvar=1\nextra_config_path=" + extra + "\n[filter]\nfilters=/ini\n",
           {{"NNSTREAMER_FILTERS", "/env"}});
  EXPECT_EQ(folders(c, FolderKind::Filters),
            "/env from NNSTREAMER_FILTERS\n/ini from " + file() +
                ":5\n/usr/lib/nnstreamer/filters from hard-coded\n/extra from " + extra + ":2\n");
  EXPECT_EQ(
      folders(c, FolderKind::CustomFilters),
      "/usr/lib/nnstreamer/customfilters from hard-coded\n/extra/custom from " + extra + ":4\n");
  EXPECT_EQ(folders(c, FolderKind::Decoders), "/usr/lib/nnstreamer/decoders from hard-coded\n")
      << "a folder is searched once";
  EXPECT_EQ(found(c, "filter", "filters"), "/ini from " + file() + ":5");
  EXPECT_EQ(found(c, "filter", "only"), "here from " + extra + ":3");
  EXPECT_EQ(state(c, extra), "extra_config_path: read");
  EXPECT_EQ(c.extra_path(), extra);
}

TEST_F(NnstreamerConfigurationTest, AcceptsBothSpellingsOfTheTrainersFolder) {
  const std::string hard_coded = "/usr/lib/nnstreamer/trainers from hard-coded\n";
  for (const char* key : {"trainers", "trainer"})
    EXPECT_EQ(folders(with(std::string("[trainer]\n") + key + "=/t\n"), FolderKind::Trainers),
              "/t from " + file() + ":2\n" + hard_coded);
  EXPECT_EQ(folders(with("[decoder]\ndecoder=/t\n"), FolderKind::Decoders),
            "/usr/lib/nnstreamer/decoders from hard-coded\n")
      << "the other kinds have one";
}

TEST_F(NnstreamerConfigurationTest, RejectsPathsThatAreNotAbsolute) {
  const auto c = with(
      "[common]\nenable_envvar=1\nextra_config_path=more.ini\n[converter]\nconverters=plug-ins\n",
      {{"NNSTREAMER_TRAINERS", "./t"}});
  const auto text = faults(c);
  EXPECT_EQ(c.faults().size(), 3u) << text;
  EXPECT_SAYS(text, "WEIR-1004: " + file() + ":3: the path is not absolute and is ignored");
  EXPECT_SAYS(text, "offered: [converter] converters=plug-ins");
  EXPECT_SAYS(text, "fix: converters=" + (fs::current_path() / "plug-ins").string());
  EXPECT_SAYS(text, "NNSTREAMER_TRAINERS: the path is not absolute");
  EXPECT_EQ(folders(c, FolderKind::Converters), "/usr/lib/nnstreamer/converters from hard-coded\n");
}

TEST_F(NnstreamerConfigurationTest, ReportsThatTheAdditionalFileIsMissing) {
  const auto c = with("[common]\nextra_config_path=/nowhere/extra.ini\n");
  EXPECT_SAYS(faults(c),
              "WEIR-4001: " + file() + ":2: extra_config_path does not name a regular file");
  EXPECT_EQ(state(c, "/nowhere/extra.ini"), "extra_config_path: not found");
}

TEST_F(NnstreamerConfigurationTest, CanBeDisabledInWeirIni) {
  const auto c = with("[filter]\nfilters=/a\n", {{"WEIR_NNSTREAMER_ENABLE", "no"}});
  EXPECT_FALSE(c.enabled());
  EXPECT_TRUE(c.candidates().empty());
  EXPECT_TRUE(c.all().empty());
  for (const auto kind : kFolderKinds) EXPECT_EQ(folders(c, kind), "");
  const auto ini = write("weir.ini", "[nnstreamer]\nenable=off\n");
  EXPECT_FALSE(of({{"WEIR_CONFIG", ini}}).enabled());
}

TEST_F(NnstreamerConfigurationTest, ListsWhatHasAnEffectAndWhatOverridesIt) {
  const auto c = with(
      "[common]\nenable_envvar=1\n[filter]\nframework_priority_TFLITE=armnn\nframework_priority_nb="
      "x\n[own]\nkey=1\nkey=2\n",
      {{"NNSTREAMER_pytorch_enable_use_gpu", "1"}});
  const Configuration weir([](const char* name) -> const char* {
    const std::string_view wanted = name;
    return wanted == "WEIR_FILTER_PRIORITY_TFLITE" ? "onnxruntime"
           : wanted == "WEIR_CONFIG"               ? ""
                                                   : nullptr;
  });
  std::string text;
  for (const auto& s : c.all()) {
    const auto by = overriding(s, weir);
    text += s.group + "/" + s.key + "=" + s.value + (by ? " not: " + by->origin : "") + "\n";
  }
  EXPECT_EQ(text,
            "common/enable_envvar=1\nfilter/framework_priority_TFLITE=armnn not: "
            "WEIR_FILTER_PRIORITY_TFLITE\nfilter/framework_priority_nb=x\nown/key=2\n"
            "pytorch/enable_use_gpu=1\n");
}

}  // namespace nnstreamer_test
}  // namespace weir::config
