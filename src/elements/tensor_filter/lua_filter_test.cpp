// tensor_filter with Lua scripts: how a pipeline selects them, their errors, and scripts that do
// not return or end their process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "becomes.hpp"
#include "elements/tensor_filter/adder_test_support.hpp"
#include "refused_calls.hpp"

namespace lua_filter_test {

using namespace weir::test;

constexpr char kTables[] =
    "inputTensorsInfo = {num = 1, dim = {{4, 1}}, type = {'uint8'}} "
    "outputTensorsInfo = {num = 1, dim = {{2}}, type = {'float32'}} ";

class LuaFilter : public testing::Test {
 protected:
  void SetUp() override {
    const std::string error = start_error("tensor_filter framework=lua model=\"x = 1\"");
    if (error.find("LuaJIT is not installed") != error.npos) GTEST_SKIP() << error;
    if (error.find("the engine lua is not installed") != error.npos) GTEST_SKIP() << error;
  }
  // Writes a file with the tables and `body` as nnstreamer_invoke, on its second line.
  static std::string script(const std::string& body) {
    const std::string path = testing::TempDir() + "weir_" +
                             testing::UnitTest::GetInstance()->current_test_info()->name() + ".lua";
    std::ofstream(path) << kTables << "\nfunction nnstreamer_invoke() " << body << " end\n";
    return path;
  }
  static Harness filter(const std::string& properties) {
    return make_harness("tensor_filter " + properties, tensors("uint8", "4:1"));
  }
  static std::vector<float> result(const Harness& h, const Bytes& bytes) {
    const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(bytes)));
    return out ? values<float>(out.get()) : std::vector<float>{};
  }
  // Pushes frames, which are dropped until the new worker is ready.
  static bool pushed_until_something_comes(const Harness& h) {
    GstFlowReturn flow = GST_FLOW_OK;
    Ref<GstBuffer> out;
    const auto comes_or_fails = [&] {
      flow = gst_harness_push(h.get(), frame(Bytes{0, 1, 2, 3}));
      out = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
      return out || flow != GST_FLOW_OK;
    };
    return becomes_true(comes_or_fails, "a result of the new worker") && flow == GST_FLOW_OK;
  }
};

const std::vector<float> kSums{1, 5};
constexpr char kSum[] =
    "local x, y = input_tensor(1), output_tensor(1) y[1] = x[1] + x[2] y[2] = x[3] + x[4]";

TEST_F(LuaFilter, FindsTheEngineByTheFile) {
  auto h = filter("model=" + script(kSum));
  EXPECT_EQ(result(h, {0, 1, 2, 3}), kSums);
  EXPECT_EQ(text_property(find_element(h, "tensor_filter").get(), "framework"), "lua");
}

TEST_F(LuaFilter, AcceptsAScriptAsModelText) {
  auto h = filter("framework=lua model=\"" + std::string(kTables) +
                  "function nnstreamer_invoke() " + kSum + " end\"");
  EXPECT_EQ(result(h, {0, 1, 2, 3}), kSums);
}

TEST_F(LuaFilter, KeepsTheOrderOfWorkersInAndOutOfProcess) {
  for (const char* where : {"none", "process"}) {
    auto h = filter("workers=3 isolate=" + std::string(where) + " model=" + script(kSum));
    for (uint8_t i = 0; i < 60; ++i)
      ASSERT_EQ(gst_harness_push(h.get(), frame(Bytes{i, 0, 0, 1})), GST_FLOW_OK);
    for (uint8_t i = 0; i < 60; ++i) {
      const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
      ASSERT_TRUE(out);
      EXPECT_EQ(values<float>(out.get()), (std::vector<float>{static_cast<float>(i), 1})) << where;
    }
  }
}

TEST_F(LuaFilter, ReportsErrorsOfTheScript) {
  auto h = filter("model=" + script("error('no such digit')"));
  Errors errors(h);
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes(4))), GST_FLOW_ERROR);
  const std::string error = errors.next();
  EXPECT_SAYS(error, "WEIR-3006: the script failed on a frame");
  EXPECT_SAYS(error, ".lua:2: no such digit");
  EXPECT_SAYS(error, "stack traceback");
}

TEST_F(LuaFilter, ReportsTablesThatDoNotFitTheStream) {
  auto h = Harness{gst_harness_new_parse(("tensor_filter model=" + script(kSum)).c_str())};
  Errors errors(h);
  gst_harness_set_src_caps_str(h.get(), tensors("uint8", "5:1").c_str());
  gst_harness_push(h.get(), frame(Bytes(5)));
  EXPECT_SAYS(errors.next(), "WEIR-2001");
}

TEST_F(LuaFilter, ReportsAMissingScript) {
  EXPECT_SAYS(start_error("tensor_filter model=/nowhere/a.lua"),
              "WEIR-3003: the script does not exist");
}

TEST_F(LuaFilter, EndsAScriptThatNeverReturnsInItsOwnProcess) {
  auto h = filter("isolate=process isolate-timeout=200 model=" +
                  script("while input_tensor(1)[1] == 255 do end output_tensor(1)[1] = 1"));
  Errors errors(h);
  EXPECT_EQ(result(h, {1, 0, 0, 0}), (std::vector<float>{1, 0}));
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{255, 0, 0, 0})), GST_FLOW_OK);
  EXPECT_SAYS(errors.next_warning(), "WEIR-3015");
  EXPECT_EQ(stat(h, "tensor_filter", "worker-timeouts"), 1u);
  EXPECT_TRUE(pushed_until_something_comes(h));
}

TEST_F(LuaFilter, SurvivesAScriptThatEndsItsProcess) {
  auto h = filter("isolate=process custom=Libraries:os model=" +
                  script("if input_tensor(1)[1] == 255 then os.exit(7) end"));
  Errors errors(h);
  EXPECT_EQ(result(h, {1, 0, 0, 0}), (std::vector<float>{0, 0}));
  EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes{255, 0, 0, 0})), GST_FLOW_OK);
  const std::string warning = errors.next_warning();
  EXPECT_SAYS(warning, "WEIR-3014");
  EXPECT_SAYS(warning, "7");
  EXPECT_TRUE(pushed_until_something_comes(h));
}

TEST_F(LuaFilter, PreventsAnIsolatedScriptFromRunningPrograms) {
  if (!can_refuse_calls()) GTEST_SKIP() << "this system does not filter system calls";
  auto h = filter("isolate=process custom=Libraries:os model=" +
                  script("output_tensor(1)[1] = os.execute('true') == 0 and 1 or 2"));
  EXPECT_EQ(result(h, {0, 0, 0, 0}), (std::vector<float>{2, 0}));
}

constexpr char kTime[] = "output_tensor(1)[1] = os.time() > 1e9 and 1 or 2";

TEST_F(LuaFilter, GivesScriptsTheStandardLibraries) {
  for (const char* where : {"none", "process"}) {
    auto h = filter("isolate=" + std::string(where) + " model=" + script(kTime));
    EXPECT_EQ(result(h, {0, 0, 0, 0}), (std::vector<float>{1, 0})) << where;
  }
}

TEST_F(LuaFilter, SandboxesScriptsByConfiguration) {
  const auto path = script(kTime);
  const std::string ini = testing::TempDir() + "weir_lua_sandbox.ini";
  std::ofstream(ini) << "[lua]\nsandbox = true\n";
  for (const char* where : {"none", "process"}) {
    setenv("WEIR_CONFIG", ini.c_str(), 1);
    auto h = filter("isolate=" + std::string(where) + " model=" + path);
    setenv("WEIR_CONFIG", "", 1);
    Errors errors(h);
    EXPECT_EQ(gst_harness_push(h.get(), frame(Bytes(4))), GST_FLOW_ERROR) << where;
    const std::string error = errors.next();
    EXPECT_SAYS(error, "global 'os' (a nil value)");
    EXPECT_SAYS(error, "fix: custom=Libraries:os");
  }
}

TEST_F(LuaFilter, AllowsALibraryInTheSandboxByProperty) {
  setenv("WEIR_LUA_SANDBOX", "yes", 1);
  for (const char* custom : {"Libraries:os", "Sandbox:false"}) {
    auto h = filter("custom=" + std::string(custom) + " model=" + script(kTime));
    EXPECT_EQ(result(h, {0, 0, 0, 0}), (std::vector<float>{1, 0})) << custom;
  }
  unsetenv("WEIR_LUA_SANDBOX");
}

TEST_F(LuaFilter, WithholdsLibrariesIfTheConfigurationIsUnreadable) {
  const std::string folder = testing::TempDir();
  setenv("WEIR_CONFIG", folder.c_str(), 1);
  const auto error = start_error("tensor_filter model=" + script(kTime));
  auto h = filter("custom=Sandbox:false model=" + script(kTime));
  setenv("WEIR_CONFIG", "", 1);
  EXPECT_SAYS(error, "Sandbox:unknown, because " + folder + " cannot be read");
  EXPECT_EQ(result(h, {0, 0, 0, 0}), (std::vector<float>{1, 0}));
}

TEST_F(LuaFilter, WithholdsLibrariesIfTheConfigurationIsInvalid) {
  const std::string path = testing::TempDir() + "weir_lua_fault.ini";
  const std::pair<std::string, const char*> cases[] = {
      {"[lua\nsandbox = true\n", ":1: the group name cannot be read"},
      {"[lua]\nsandbox true\n", ":2: the line is neither"},
      {std::string((1 << 20) + 1, '\n'), ": the file is too long"},
      {"", " cannot be read: it does not exist"},  // no file
  };
  for (const auto& [text, what] : cases) {
    std::remove(path.c_str());
    if (!text.empty()) std::ofstream(path) << text;
    for (const char* where : {"none", "process"}) {
      setenv("WEIR_CONFIG", path.c_str(), 1);
      const auto error =
          start_error("tensor_filter isolate=" + std::string(where) + " model=" + script(kTime));
      setenv("WEIR_CONFIG", "", 1);
      EXPECT_SAYS(error, "Sandbox:unknown, because " + path + what);
      EXPECT_SAYS(error, "set the variable WEIR_LUA_SANDBOX");
    }
  }
}

TEST_F(LuaFilter, ReportsAnInvalidConfigurationValue) {
  setenv("WEIR_LUA_SANDBOX", "perhaps", 1);
  EXPECT_SAYS(start_error("tensor_filter model=" + script(kTime)), "Sandbox:perhaps");
  unsetenv("WEIR_LUA_SANDBOX");
}

TEST_F(LuaFilter, CanBeReplacedWhilePlaying) {
  auto h = filter("is-updatable=true model=" + script(kSum));
  EXPECT_EQ(result(h, {0, 1, 2, 3}), kSums);
  const std::string other = testing::TempDir() + "weir_lua_other.lua";
  std::ofstream(other) << kTables << "function nnstreamer_invoke() output_tensor(1)[2] = 9 end";
  g_object_set(find_element(h, "tensor_filter").get(), "model", other.c_str(), nullptr);
  EXPECT_TRUE(becomes_true(
      [&] {
        return result(h, {0, 1, 2, 3}) != kSums;
      },
      "a result of the other script"));
  EXPECT_EQ(result(h, {0, 1, 2, 3}), (std::vector<float>{0, 9}));
}

}  // namespace lua_filter_test
