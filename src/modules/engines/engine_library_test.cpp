// Tests where an engine's library is searched.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "engine_library.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "engine_host_test_support.hpp"
#include "says.hpp"

namespace weir::engine {
namespace engine_library_test {

class EngineLibraryPlaces : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const char* value = std::getenv("WEIR_ENGINES_DIR")) kept_ = value;
  }
  void TearDown() override { set(kept_); }
  static void set(const std::string& value) {
    value.empty() ? unsetenv("WEIR_ENGINES_DIR") : setenv("WEIR_ENGINES_DIR", value.c_str(), 1);
  }
  std::string kept_;
  engine_test::TemporaryFolder folder_;
};

TEST_F(EngineLibraryPlaces, OnlyTheEnvironmentCountsWhereItIsSet) {
  set("/some/where");
  EXPECT_EQ(library_folders("frob"), (std::vector<std::string>{"/some/where/frob/lib"}));
}

TEST_F(EngineLibraryPlaces, OtherwiseBesideTheFolderOfTheModule) {
  set("");
  const auto folders = library_folders("frob");
  ASSERT_EQ(folders.size(), 1u);
  const auto beside = std::filesystem::canonical("/proc/self/exe").parent_path().parent_path();
  EXPECT_EQ(folders[0], beside / "engines/frob/lib");
}

TEST_F(EngineLibraryPlaces, AMissingLibraryIsReportedWithTheCommandThatInstallsIt) {
  set(folder_.path(""));
  const auto library = EngineLibrary::open("frob", "Frob", {"libfrob.so.1", "libfrob.so"});
  ASSERT_FALSE(library);
  EXPECT_EQ(library.error().code, Code::ENGINE_NOT_INSTALLED);
  EXPECT_EQ(library.error().what, "Frob is not installed");
  EXPECT_SAYS(library.error().offered, "libfrob.so.1");
  EXPECT_SAYS(library.error().offered, folder_.path(""));
  EXPECT_EQ(library.error().fix, "tools/setup --engine frob");
}

TEST_F(EngineLibraryPlaces, AFileThatIsNotALibraryIsReportedAsExisting) {
  set(folder_.path(""));
  ASSERT_EQ(std::system(("mkdir -p " + folder_.path("frob/lib")).c_str()), 0);
  folder_.write("frob/lib/libfrob.so", std::vector<std::byte>(100));
  const auto library = EngineLibrary::open("frob", "Frob", {"libfrob.so.1", "libfrob.so"});
  ASSERT_FALSE(library);
  EXPECT_EQ(library.error().code, Code::ENGINE_NOT_INSTALLED);
  EXPECT_SAYS(library.error().what, "exists but cannot be loaded");
}

TEST_F(EngineLibraryPlaces, ALibraryOfTheSystemIsLoadedByItsSoname) {
  for (const auto& chosen : {std::string(), folder_.path("")}) {
    set(chosen);
    const auto library = EngineLibrary::open("frob", "Frob", {"libfrob.so"}, "libm.so.6");
    ASSERT_TRUE(library) << library.error().message();
    EXPECT_TRUE(library->path().starts_with("/") && library->path().ends_with("/libm.so.6"));
    EXPECT_EQ(library->install_command(), "apt-get install --reinstall libm6");
    EXPECT_TRUE(library->is_of_system());
  }
}

TEST_F(EngineLibraryPlaces, AFetchedLibraryThatTheUserChoseWinsOverThatOfTheSystem) {
  set(folder_.path(""));
  const auto of_system = EngineLibrary::open("frob", "Frob", {"libfrob.so"}, "libm.so.6");
  ASSERT_TRUE(of_system);
  const std::string fetched = folder_.path("frob/lib/libfrob.so");
  std::filesystem::create_directories(folder_.path("frob/lib"));
  std::filesystem::copy_file(of_system->path(), fetched);
  const auto library = EngineLibrary::open("frob", "Frob", {"libfrob.so"}, "libm.so.6");
  ASSERT_TRUE(library) << library.error().message();
  EXPECT_EQ(library->path(), fetched);
  EXPECT_FALSE(library->is_of_system());
  EXPECT_EQ(library->install_command(), "tools/setup --engine frob");
}

TEST_F(EngineLibraryPlaces, AMissingLibraryOfTheSystemIsReportedWithItsPackage) {
  for (const auto& chosen : {std::string(), folder_.path("")}) {
    set(chosen);
    const auto library = EngineLibrary::open("frob", "Frob", {"libfrob.so"}, "libfrob.so.1.21");
    ASSERT_FALSE(library);
    EXPECT_EQ(library.error().code, Code::ENGINE_NOT_INSTALLED);
    EXPECT_EQ(library.error().what, "Frob is not installed");
    EXPECT_SAYS(library.error().offered, "libfrob.so.1.21");
    EXPECT_SAYS(library.error().needed, "WEIR_ENGINES_DIR");
    EXPECT_EQ(library.error().fix, "apt-get install --reinstall libfrob1.21");
  }
}

TEST_F(EngineLibraryPlaces, AMissingSymbolIsNull) {
  for (const auto* name : {"libonnxruntime.so.1", "libtensorflowlite_c.so"}) {
    set(std::filesystem::canonical("/proc/self/exe").parent_path() / "engines");
    const std::string engine = name[3] == 'o' ? "onnxruntime" : "tensorflow-lite";
    const auto library = EngineLibrary::open(engine, engine, {name});
    if (!library) continue;
    EXPECT_TRUE(library->path().ends_with(name));
    EXPECT_EQ(library->symbol<void (*)()>("no_such_symbol"), nullptr);
  }
}

}  // namespace engine_library_test
}  // namespace weir::engine
