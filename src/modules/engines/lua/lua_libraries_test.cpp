// Tests of the standard Lua libraries, which scripts get unless they run in a sandbox.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>

#include "lua/lua_test_support.hpp"
#include "says.hpp"

namespace weir::engine_test {
namespace lua_libraries_test {

class LuaLibraries : public LuaTest {
 protected:
  std::string file(const std::string& name, const std::string& text) {
    return folder_.write(name, to_bytes(text));
  }
};

TEST_F(LuaLibraries, OsReturnsTheTime) {
  const auto before = std::time(nullptr);
  const auto y = result("y[1] = math.floor(os.time() / 65536)  y[2] = os.time() % 65536");
  const auto after = std::time(nullptr);
  ASSERT_EQ(y.size(), 4u);
  const double time = static_cast<double>(y[0]) * 65536 + static_cast<double>(y[1]);
  EXPECT_GE(time, static_cast<double>(before));
  EXPECT_LE(time, static_cast<double>(after) + 1) << "the two calls may be a second apart";
}

TEST_F(LuaLibraries, IoReadsAndWritesFiles) {
  const auto path = folder_.path("numbers.txt");
  std::ofstream(path) << "2.5 -4\n";
  EXPECT_EQ(result("local f = assert(io.open('" + path +
                   "'))  y[1], y[2] = f:read('*n', '*n')  f:close()\n"
                   "f = assert(io.open('" +
                   path + "', 'w'))  f:write('seen')  f:close()"),
            (std::vector<float>{2.5f, -4, 0, 0}));
  std::string word;
  std::ifstream(path) >> word;
  EXPECT_EQ(word, "seen");
}

TEST_F(LuaLibraries, RequireFindsModulesOnItsPath) {
  file("tripled.lua", "return {of = function(x) return 3 * x end}");
  EXPECT_EQ(
      result(
          "package.path = '" + folder_.path("?.lua") +
          "'\n  local tripled = require('tripled')  for i = 1, 4 do y[i] = tripled.of(x[i]) end"),
      (std::vector<float>{3, 6, 9, 12}));
  EXPECT_SAYS(failure("require('no_such_module')").message(), "module 'no_such_module' not found");
}

// Changes the working directory for as long as it lives.
class WorkingIn {
 public:
  explicit WorkingIn(const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    std::filesystem::current_path(folder);
  }
  ~WorkingIn() { std::filesystem::current_path(before_); }
  WorkingIn(const WorkingIn&) = delete;
  WorkingIn& operator=(const WorkingIn&) = delete;

 private:
  const std::filesystem::path before_ = std::filesystem::current_path();
};

TEST_F(LuaLibraries, RequireFindsModulesBesideTheScriptAndNotInTheWorkingDirectory) {
  const WorkingIn elsewhere(folder_.path("elsewhere"));
  file("beside.lua", "return 5");
  std::ofstream("working.lua") << "return 6";
  EXPECT_EQ(result("y[1] = require('beside')  y[2] = pcall(require, 'working') and 1 or 2"),
            (std::vector<float>{5, 2, 0, 0}));
  EXPECT_EQ(result("for part in (package.path .. ';' .. package.cpath):gmatch('[^;]+') do\n"
                   "if part:sub(1, 1) ~= '/' then y[1] = y[1] + 1 end  y[2] = y[2] + 1 end")[0],
            0);
  EXPECT_SAYS(failure("require('working')").message(), folder_.path("working.lua"));
}

TEST_F(LuaLibraries, VariablesSetTheSearchPathAsInLua) {
  const WorkingIn elsewhere(folder_.path("elsewhere"));
  std::ofstream("working.lua") << "return 6";
  setenv("LUA_PATH", "./?.lua", 1);
  const auto y = result("y[1] = require('working')");
  unsetenv("LUA_PATH");
  EXPECT_EQ(y, (std::vector<float>{6, 0, 0, 0}));
}

TEST_F(LuaLibraries, OtherScriptsCanBeRun) {
  const auto path = file("other.lua", "return 7, ...");
  EXPECT_EQ(result("y[1] = dofile('" + path + "')  y[2] = select(2, loadfile('" + path +
                   "')(8))\n  y[3] = loadfile('" + file("global.lua", "return z") +
                   "', 't', {z = 9})()  y[4] = debug.getinfo(1).currentline"),
            (std::vector<float>{7, 8, 9, 6}));
  const Error error = failure("dofile('" + file("wrong.lua", "x x") + "')");
  EXPECT_EQ(error.code, Code::INVOKE_FAILED);
  EXPECT_SAYS(error.message(), "wrong.lua:1:");
  EXPECT_SAYS(failure("dofile('/nowhere/a.lua')").message(), "/nowhere/a.lua");
}

TEST_F(LuaLibraries, ByteCodeIsRejectedOutsideTheSandbox) {
  const auto path = file("code.luac", "\x1BLJ\x02");
  EXPECT_EQ(result("y[1] = loadfile('" + path + "') and 1 or 2  y[2] = pcall(dofile, '" + path +
                   "') and 1 or 2  y[3] = load('\\27LJ\\2') and 1 or 2\n"
                   "  y[4] = (string.dump or newproxy) and 1 or 2"),
            (std::vector<float>{2, 2, 2, 2}));
}

TEST_F(LuaLibraries, FfiAndJitMustBeRequested) {
  for (const char* name : {"ffi", "jit"}) {
    const Error error = failure(std::string(name) + ".off()");
    EXPECT_SAYS(error.message(), "global '" + std::string(name) + "' (a nil value)");
    EXPECT_SAYS(error.message(), "fix: custom=Libraries:" + std::string(name));
  }
  EXPECT_EQ(result("y[1] = pcall(require, 'ffi') and 1 or 2")[0], 2);
  EXPECT_EQ(result("y[1] = require('ffi').sizeof('int')", {{"Libraries", "ffi"}})[0], 4);
}

TEST_F(LuaLibraries, TheLastValueOfSandboxCounts) {
  for (const char* off : {"false", "no", "0", "off"})
    EXPECT_EQ(result("y[1] = os and 1 or 2", {{"sandbox", off}})[0], 1) << off;
  for (const char* on : {"true", "yes", "1", "ON"})
    EXPECT_EQ(result("y[1] = os and 1 or 2", {{"Sandbox", on}})[0], 2) << on;
  const Error error = refusal(script_text(""), {{"Sandbox", "perhaps"}});
  EXPECT_EQ(error.code, Code::OPTION_VALUE);
  EXPECT_SAYS(error.message(), "Sandbox:perhaps");
  EXPECT_SAYS(error.message(), "true or false");
}

}  // namespace lua_libraries_test
}  // namespace weir::engine_test
