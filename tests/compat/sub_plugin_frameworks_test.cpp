// Tests which engine framework=NAME and a model's extension select when filters for NNStreamer are
// installed (docs/compatibility/filter.md 4.2, docs/compatibility/app-api.md 8.1).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <fstream>

#include "core/custom/filter_library.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/process/process_object.hpp"
#include "core/subplugin/loader.hpp"
#include "library/process.h"
#include "says.hpp"
#include "sub_plugin_test_support.hpp"

namespace weir::infer {
namespace sub_plugin_frameworks_test {

namespace fs = std::filesystem;

class SubPluginFramework : public ::testing::Test {
 protected:
  SubPluginFramework() : folder_("NNSTREAMER_CUSTOMFILTERS"), ini_(folder_ / "nnstreamer.ini") {
    write("");
    setenv("NNSTREAMER_CONF", ini_.c_str(), 1);
    setenv("NNSTREAMER_FILTERS", std::getenv("WEIR_COMPAT_FILTERS"), 1);
  }
  ~SubPluginFramework() override {
    for (const char* name : {"NNSTREAMER_CONF", "NNSTREAMER_FILTERS", "WEIR_FILTER_ENABLE_SYMLINK",
                             "WEIR_FILTER_PRIORITY_ABC"})
      unsetenv(name);
  }
  void write(const std::string& text) const {
    std::ofstream(ini_) << "[common]\nenable_envvar=1\n" << text;
  }
  // The name of the engine, or the error.
  static std::string engine(const std::string& framework) {
    const auto found = ModuleLibrary::instance().engine(framework);
    return found ? (*found)->name : found.error().message();
  }
  static std::string chosen(const std::string& model) {
    const auto choice = ModuleLibrary::instance().choose_engine(std::vector{model});
    return choice ? choice->engine + ": " + choice->reason : choice.error().message();
  }
  test::SubPluginFolder folder_;
  fs::path ini_;
};

TEST_F(SubPluginFramework, IsTheSubPluginOfThisName) {
  EXPECT_EQ(engine("hand0"), "hand0");
  const auto names = ModuleLibrary::instance().engine_names();
  EXPECT_TRUE(std::find(names.begin(), names.end(), "hand0") != names.end());
  EXPECT_TRUE(std::find(names.begin(), names.end(), "fake") != names.end());
  EXPECT_SAYS(engine("Hand0"), "WEIR-3001: no engine has this name");
  EXPECT_SAYS(engine("Hand0"), "did you mean hand0?");
  EXPECT_SAYS(engine("half"), "or NNStreamer's libnnstreamer_filter_half.so in /");
}

TEST_F(SubPluginFramework, FollowsPriorityThenAlias) {
  write(
      "[own]\nsubplugin_priority=missing, ;hand0 header1\n"
      "[filter-aliases]\nown=header1\nother=missing;header1\nbad=missing\n"
      "[hand0]\nsubplugin_priority=header1\n");
  EXPECT_EQ(engine("own"), "hand0");
  EXPECT_EQ(engine("other"), "header1");
  EXPECT_SAYS(engine("bad"), "WEIR-3001: no engine has this name\n  offered: framework=bad");
  EXPECT_EQ(engine("hand0"), "hand0") << "what has the name itself comes first";
}

TEST_F(SubPluginFramework, PrefersWeirsEngineOfTheSameName) {
  const test::SubPluginFolder filters("NNSTREAMER_FILTERS");
  for (const char* name : {"fake", "snpe"})
    std::ofstream(filters / ("libnnstreamer_filter_" + std::string(name) + ".so")) << "text";
  EXPECT_EQ(engine("fake"), "fake");
  EXPECT_SAYS(engine("snpe"), "WEIR-3007: the module " +
                                  (filters / "libnnstreamer_filter_snpe.so").string() +
                                  " cannot be used")
      << "Weir knows the name and has no module";
}

TEST_F(SubPluginFramework, FollowsThePriorityOfTheModelsExtension) {
  EXPECT_SAYS(chosen("model.abc"), "WEIR-3003: the model file does not exist");
  write("[filter]\nframework_priority_abc=missing,hand0,fake\n");
  EXPECT_EQ(chosen("model.ABC"),
            "hand0: the file has the extension .abc; first installed engine of "
            "framework_priority_abc (" +
                ini_.string() + ":4)");
  setenv("WEIR_FILTER_PRIORITY_ABC", "fake", 1);
  EXPECT_EQ(chosen("model.abc"),
            "fake: the file has the extension .abc; first installed engine of priority_abc "
            "(WEIR_FILTER_PRIORITY_ABC)");
}

TEST_F(SubPluginFramework, SearchesNnstreamersFoldersLastForCustomFilters) {
  std::ofstream(folder_ / "named.so") << "not opened";
  EXPECT_EQ(custom::library_of_filter("named"), (folder_ / "named.so").string());
  const auto folders = custom::filter_folders();
  EXPECT_EQ(folders[folders.size() - 2], (folder_ / "").parent_path().string());
  EXPECT_EQ(folders.back(), "/usr/lib/nnstreamer/customfilters");
}

TEST_F(SubPluginFramework, AcceptsLinksToCustomFiltersIfEnabled) {
  const auto file = fs::path(std::getenv("WEIR_COMPAT_FILTERS")) / "by_hand.so";
  const auto link = folder_ / "link.so";
  fs::create_symlink(file, link);
  const auto refused = [&] {
    const auto opened = custom::has_callbacks(link.string());
    return opened ? "" : opened.error().message();
  };
  EXPECT_SAYS(refused(), "WEIR-3007: a filter's file must not be a symbolic link");
  write("enable_symlink=true\n");
  EXPECT_EQ(refused(), "");
  setenv("WEIR_FILTER_ENABLE_SYMLINK", "no", 1);
  EXPECT_SAYS(refused(), "must not be a symbolic link");
  setenv("WEIR_FILTER_ENABLE_SYMLINK", "yes", 1);
  write("enable_symlink=false\n");
  EXPECT_EQ(refused(), "");
}

}  // namespace sub_plugin_frameworks_test
}  // namespace weir::infer

int main(int argc, char** argv) {
  weir::process::take_objects_from(weir_process_object);
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
