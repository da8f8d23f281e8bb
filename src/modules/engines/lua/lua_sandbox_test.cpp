// Tests of custom=Sandbox:true: what scripts cannot reach unless it is granted.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fstream>

#include "lua/lua_test_support.hpp"
#include "says.hpp"

namespace weir::engine_test {
namespace lua_sandbox_test {

class LuaSandbox : public LuaTest {
 protected:
  static Options sandboxed(Options options) {
    options.emplace_back("Sandbox", "true");
    return options;
  }
  Error failure(const std::string& body, const Options& options = {}) {
    return LuaTest::failure(body, sandboxed(options));
  }
  std::vector<float> result(const std::string& body, const Options& options = {}) {
    return LuaTest::result(body, sandboxed(options));
  }
};

TEST_F(LuaSandbox, WithholdsLibrariesAndNamesTheOptionThatGivesThem) {
  for (const char* use : {"io.open('x')", "os.exit(1)", "debug.getupvalue(print, 1)", "jit.off()",
                          "ffi.cdef('int x')", "package.loaded.x = 1"}) {
    const Error error = failure(use);
    EXPECT_EQ(error.code, Code::INVOKE_FAILED) << use;
    const std::string name = std::string(use).substr(0, std::string(use).find('.'));
    EXPECT_SAYS(error.message(), "global '" + name + "' (a nil value)");
    EXPECT_SAYS(error.message(), "fix: custom=Libraries:" + name);
  }
  EXPECT_SAYS(failure("require('ffi')").message(), "fix: custom=Libraries:package");
}

TEST_F(LuaSandbox, NoFunctionReadsFilesOrByteCode) {
  EXPECT_EQ(result("y[1] = (dofile or loadfile or string.dump or newproxy) and 0 or 1"),
            (std::vector<float>{1, 0, 0, 0}));
  for (const char* load : {"load('\\27LJ\\2')", "loadstring('\\27LJ\\2')",
                           "load('\\27LJ\\2', 'x', 'b')", "load('\\27LJ\\2', 'x', 'bt', {})",
                           "load(function() local s = code  code = nil  return s end)"})
    EXPECT_EQ(result("code = '\\27LJ\\2'  local f, why = " + std::string(load) +
                     "  y[1] = not f and why:find('wrong mode') and 1 or 0")[0],
              1)
        << load;
}

TEST_F(LuaSandbox, LoadsText) {
  EXPECT_EQ(result(R"lua(
    y[1] = load('return 2 + 3')()
    y[2] = loadstring('return ...')(7)
    y[3] = load('return z', 'chunk', 't', {z = 9})()
    y[4] = select(2, load('x x', '=here')):find('^here:1:')
  )lua"),
            (std::vector<float>{5, 7, 9, 1}));
}

// Each expression is true if the script gained access.
TEST_F(LuaSandbox, KeepsFfiOutOfReach) {
  for (const char* way : {
           "type(getmetatable(x)) == 'table'",
           "pcall(setmetatable, x, {})",
           "pcall(function() return x.__index end)",
           "pcall(function() return x.data end)",
           "pcall(function() return x + 1 end)",
           "pcall(function() return x() end)",
           "pcall(function() return x.x.x end)",
           "rawget(_G, 'ffi') ~= nil",
           "getfenv(input_tensor).ffi ~= nil",
           "getfenv(getfenv(0).load).ffi ~= nil",
           "pcall(getfenv(0).require or error, 'ffi')",
           "(function() for _, f in pairs(_G) do if type(f) == 'function' and f ~= _G.pcall and "
           "pcall(getfenv, f) and getfenv(f).ffi then return true end end end)()",
           "(function() for i = 0, 9 do local good, e = pcall(getfenv, i) if good and e.ffi then "
           "return true end end end)()",
           "pcall(function() return (1LL)[0] end)",
           "type(getmetatable(1LL)) == 'table'",
       })
    EXPECT_EQ(result("y[1] = (" + std::string(way) + ") and 1 or 2")[0], 2) << way;
}

// Our closures do not call the functions with which a script replaces library functions.
TEST_F(LuaSandbox, ReplacedFunctionsAreNotOurs) {
  EXPECT_EQ(result(R"lua(
    local seen = 0
    local function spy(...) seen = seen + select('#', ...)  return 1 end
    for _, name in ipairs({'error', 'type', 'tostring', 'tonumber', 'rawget', 'pcall'}) do
      _G[name] = spy
    end
    math.floor, string.format = spy, spy
    y[1] = x[2]
    y[2] = '7'
    y[3] = seen
  )lua"),
            (std::vector<float>{2, 7, 0, 0}));
}

TEST_F(LuaSandbox, ProvidesRequestedLibraries) {
  const auto path = folder_.path("written.txt");
  EXPECT_EQ(result("local f = io.open('" + path +
                       "', 'w')  f:write('hello')  f:close()  y[1] = os.time()",
                   {{"Libraries", "io+os"}})
                .size(),
            4u);
  std::string word;
  std::ifstream(path) >> word;
  EXPECT_EQ(word, "hello");
  EXPECT_EQ(result("y[1] = ffi.sizeof('int64_t')  y[2] = jit and 1 or 2", {{"Libraries", "ffi"}}),
            (std::vector<float>{8, 2, 0, 0}));
  EXPECT_EQ(result("y[1] = jit.status() and 1 or 2", {{"Libraries", "jit"}})[0], 1);
  EXPECT_EQ(result("y[1] = debug.getinfo(1).currentline", {{"libraries", "debug io"}})[0], 5);
}

TEST_F(LuaSandbox, PackagesGetNoFfiUnlessItIsRequested) {
  EXPECT_EQ(result("y[1] = package.loaded.ffi == nil and not pcall(require, 'ffi') and 1 or 2",
                   {{"Libraries", "package"}})[0],
            1);
  EXPECT_EQ(result("y[1] = require('ffi').sizeof('int')", {{"Libraries", "package+ffi"}})[0], 4);
}

// changing(table, a, b, c): a missing field reads as a the first time, then as b, and as c from
// then on. ones(...): 16 dimensions, 14 of which are such fields.
constexpr char kChanging[] = R"lua(
  local function changing(table, ...)
    local values, reads = {...}, {}
    return setmetatable(table, {__index = function(_, key)
      reads[key] = math.min((reads[key] or 0) + 1, #values)
      return values[reads[key]]
    end})
  end
  local function ones(...)
    return changing({16, nil, nil, nil, nil, nil, nil, nil, nil, nil, nil, nil, nil, nil, nil, 1}, ...)
  end
)lua";

// A table that declares a tensor of 16 elements, and differs between its first and second read.
struct ChangingCase {
  const char* name;
  const char* table;
};
class LuaChangingTable : public LuaTest, public ::testing::WithParamInterface<ChangingCase> {
 protected:
  static std::string tables(const std::string& input, const std::string& output) {
    return std::string(kChanging) + "inputTensorsInfo = " + input +
           "\noutputTensorsInfo = " + output + "\n";
  }
};

constexpr char kSixteen[] = "{num = 1, dim = {{16}}, type = {'uint8'}}";

TEST_P(LuaChangingTable, BoundsOfAnInputFollowItsMemory) {
  const auto model = script(tables(GetParam().table, kSixteen) +
                            "function nnstreamer_invoke() local x = input_tensor(1)\n"
                            "output_tensor(1)[1] = #x  output_tensor(1)[2] = x[#x + 1] end");
  ASSERT_NE(model, nullptr);
  ASSERT_EQ(model->inputs().size(), 1u);
  const auto y = model->invoke(zero_inputs(*model));
  ASSERT_FALSE(y) << "an element after the input was read";
  EXPECT_SAYS(y.error().message(), "input_tensor(1)[17] is out of range: it has 16 elements");
}

TEST_P(LuaChangingTable, BoundsOfAnOutputFollowItsMemory) {
  const auto model = script(tables(kSixteen, GetParam().table) +
                            "function nnstreamer_invoke() local y = output_tensor(1)\n"
                            "for i = 1, 16 do y[i] = i end  y[17] = 1 end");
  ASSERT_NE(model, nullptr);
  ASSERT_EQ(model->outputs().size(), 1u);
  const auto y = model->invoke(zero_inputs(*model));
  ASSERT_FALSE(y) << "an element after the output was written";
  EXPECT_SAYS(y.error().message(), "output_tensor(1)[17] is out of range: it has 16 elements");
}

INSTANTIATE_TEST_SUITE_P(
    All, LuaChangingTable,
    ::testing::Values(
        ChangingCase{"ThirdReadOfADimension",
                     "{num = 1, dim = {ones(1, 1, 1.9999)}, type = {'uint8'}}"},
        ChangingCase{"SecondReadOfADimension", "{num = 1, dim = {ones(1, 2)}, type = {'uint8'}}"},
        ChangingCase{"NumberOfTensors", "changing({dim = {{16}}, type = {'uint8'}}, 1, 1, 1, 300)"},
        ChangingCase{"ListOfDimensions", "changing({num = 1, type = {'uint8'}}, {{16}}, {{4096}})"},
        ChangingCase{"ListOfTypes", "changing({num = 1, dim = {{16}}}, {'uint8'}, {'float64'})"}),
    [](const auto& info) { return info.param.name; });

TEST_F(LuaSandbox, AFractionFromAMetamethodIsRejectedInEveryTable) {
  const Error error =
      refusal(std::string(kChanging) +
              "inputTensorsInfo = {num = 1, dim = {ones(1.9999)}, type = {'uint8'}}\n"
              "outputTensorsInfo = " +
              kSixteen + "\nfunction nnstreamer_invoke() end");
  EXPECT_EQ(error.code, Code::MODEL_INVALID);
  EXPECT_SAYS(error.message(), "inputTensorsInfo.dim[1][15] is not a dimension");
  EXPECT_SAYS(error.message(), "1.9999");
}

}  // namespace lua_sandbox_test
}  // namespace weir::engine_test
