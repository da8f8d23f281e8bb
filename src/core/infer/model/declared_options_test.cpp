// Tests which engines receive the user's description of a model's tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/model/declared_options.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdlib>
#include <fstream>

#include "says.hpp"

namespace weir::infer {
namespace declared_options_test {

using Pairs = std::vector<std::pair<std::string, std::string>>;

weir_engine engine_with(const char* options_json) {
  weir_engine engine{};
  engine.struct_size = sizeof engine;
  engine.options_json = options_json;
  return engine;
}

OpenOptions declared() {
  OpenOptions options;
  options.options = {{"NumThreads", "2"}};
  options.declared = {{"input", "3:4"}, {"inputtype", "uint8"}};
  return options;
}

TEST(DeclaredOptions, AreSentToAnEngineThatListsThem) {
  const auto engine = engine_with(R"([{"name": "input"}, {"name": "NumThreads"}])");
  EXPECT_EQ(options_for(engine, declared()), (Pairs{{"NumThreads", "2"}, {"input", "3:4"}}));
}

TEST(DeclaredOptions, AreNotSentToOtherEngines) {
  for (const char* json : {static_cast<const char*>(nullptr), "", "[]", "no json", "{}", "[1, {}]",
                           R"([{"name": 7}, {"name": "inputs"}])"})
    EXPECT_EQ(options_for(engine_with(json), declared()), (Pairs{{"NumThreads", "2"}}));
  weir_engine old = engine_with(R"([{"name": "input"}])");
  old.struct_size = offsetof(weir_engine, options_json);
  EXPECT_EQ(options_for(old, declared()), (Pairs{{"NumThreads", "2"}}));
}

TEST(DeclaredOptions, AreOverriddenByTheUsersOption) {
  auto options = declared();
  options.options = {{"input", "5"}};
  const auto engine = engine_with(R"([{"name": "input"}, {"name": "inputtype"}])");
  EXPECT_EQ(options_for(engine, options), (Pairs{{"input", "5"}, {"inputtype", "uint8"}}));
}

TEST(DeclaredOptions, AnEngineOfSeveralNamesReceivesTheRequestedName) {
  auto engine = engine_with(R"([{"name": "framework"}, {"name": "input"}])");
  engine.name = "second";
  OpenOptions options = declared();
  options.options = {{"framework", "a word of custom="}};
  EXPECT_EQ(options_for(engine, options),
            (Pairs{{"framework", "a word of custom="}, {"framework", "second"}, {"input", "3:4"}}));
}

// Sets [filter] enable_symlink for the duration of a test.
class Installation {
 public:
  explicit Installation(const char* value) { setenv(kVariable, value, 1); }
  Installation(const Installation&) = delete;
  Installation& operator=(const Installation&) = delete;
  ~Installation() { unsetenv(kVariable); }

 private:
  static constexpr char kVariable[] = "WEIR_FILTER_ENABLE_SYMLINK";
};

constexpr char kWithSetting[] = R"([{"name": "Links", "setting": "filter/enable_symlink"}])";

TEST(DeclaredOptions, ASettingOfTheInstallationIsTheDefault) {
  OpenOptions options;
  EXPECT_EQ(options_for(engine_with(kWithSetting), options), Pairs{});
  const Installation says("yes");
  EXPECT_EQ(options_for(engine_with(kWithSetting), options), (Pairs{{"Links", "yes"}}));
  EXPECT_EQ(get_identity(engine_with(kWithSetting), options), (Pairs{{"Links", "yes"}}))
      << "models that differ in it are not shared";
  options.options = {{"links", "no"}};
  EXPECT_EQ(options_for(engine_with(kWithSetting), options), (Pairs{{"links", "no"}}));
}

TEST(DeclaredOptions, ASettingOfAFileThatCannotBeReadIsNotTheDefault) {
  const std::string folder = testing::TempDir();
  setenv("WEIR_CONFIG", folder.c_str(), 1);  // a folder
  const auto unknown = options_for(engine_with(kWithSetting), {});
  OpenOptions own;
  own.options = {{"Links", "no"}};
  const auto given = options_for(engine_with(kWithSetting), own);
  setenv("WEIR_CONFIG", "", 1);
  EXPECT_EQ(unknown, (Pairs{{"Links", "unknown, because " + folder +
                                          " cannot be read: it is a folder; correct that file, or "
                                          "set the variable WEIR_FILTER_ENABLE_SYMLINK"}}));
  EXPECT_EQ(given, (Pairs{{"Links", "no"}}));
}

TEST(DeclaredOptions, ASettingOfAFileWithAFaultIsNotTheDefault) {
  const std::string path = testing::TempDir() + "weir_declared_options.ini";
  std::ofstream(path) << "[filter]\nenable_symlink no\n";
  setenv("WEIR_CONFIG", path.c_str(), 1);
  const auto unknown = options_for(engine_with(kWithSetting), {});
  Pairs decided;
  {
    const Installation says("yes");
    decided = options_for(engine_with(kWithSetting), {});
  }
  setenv("WEIR_CONFIG", "", 1);
  ASSERT_EQ(unknown.size(), 1u);
  EXPECT_EQ(unknown[0].first, "Links");
  EXPECT_SAYS(unknown[0].second, "unknown, because " + path + ":2: the line is neither");
  EXPECT_SAYS(unknown[0].second,
              "(enable_symlink no); correct that file, or set the variable "
              "WEIR_FILTER_ENABLE_SYMLINK");
  EXPECT_EQ(decided, (Pairs{{"Links", "yes"}}));
}

TEST(DeclaredOptions, AMissingSettingChangesNothing) {
  const Installation says("yes");
  for (const char* setting : {"7", R"("")", R"("filter")", R"("filter/")", R"("/enable_symlink")",
                              R"("filter/enable_symlink/")", "null"})
    EXPECT_EQ(options_for(
                  engine_with(
                      (R"([{"name": "Links", "setting": )" + std::string(setting) + "}]").c_str()),
                  {}),
              Pairs{})
        << setting;
}

// The options of `inner` when an engine with kAllDeclared was opened with `options`.
Pairs inner_options(const weir_engine& inner, const OpenOptions& options) {
  auto outer = engine_with(kAllDeclared);
  outer.name = "custom";
  const auto given = options_for(outer, options);
  std::vector<weir_option> pairs;
  for (const auto& [key, value] : given) pairs.push_back({key.c_str(), value.c_str()});
  weir_open request{};
  request.options = pairs.data();
  request.n_options = static_cast<uint32_t>(pairs.size());
  Pairs out;
  for (const auto& option : options_for_inner(inner, request))
    out.emplace_back(option.key, option.value);
  return out;
}

TEST(DeclaredOptions, AreForwardedAsTheInnerEngineListsThem) {
  EXPECT_EQ(inner_options(engine_with(nullptr), declared()), (Pairs{{"NumThreads", "2"}}));
  auto inner = engine_with(R"([{"name": "framework"}, {"name": "inputtype"}])");
  inner.name = "inside";
  OpenOptions options = declared();
  options.options = {{"input", "the user's"}};
  EXPECT_EQ(inner_options(inner, options),
            (Pairs{{"input", "the user's"}, {"framework", "inside"}, {"inputtype", "uint8"}}));
}

}  // namespace declared_options_test
}  // namespace weir::infer
