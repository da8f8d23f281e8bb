// Tests of what the Lua engine rejects, and of the error texts.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>

#include "lua/lua_test_support.hpp"
#include "out_of_memory_test_support.hpp"
#include "says.hpp"

namespace weir::engine_test {
namespace lua_refusals_test {

class LuaRejects : public LuaTest {};

constexpr char kOutput[] = "outputTensorsInfo = {num = 1, dim = {{2}}, type = {'uint8'}}\n";
constexpr char kInvoke[] = "function nnstreamer_invoke() end\n";

std::string with_input(const std::string& table) {
  return "inputTensorsInfo = " + table + "\n" + kOutput + kInvoke;
}

struct TableCase {
  const char* name;
  const char* table;
  const char* words;
};
class LuaRejectsTables : public LuaTest, public ::testing::WithParamInterface<TableCase> {};

TEST_P(LuaRejectsTables, WithTheNameOfTheField) {
  const Error error = refusal(with_input(GetParam().table));
  EXPECT_EQ(error.code, Code::MODEL_INVALID) << error.message();
  EXPECT_SAYS(error.message(), GetParam().words);
  EXPECT_SAYS(error.offered, "model.bin");
  EXPECT_FALSE(error.needed.empty());
}
INSTANTIATE_TEST_SUITE_P(
    All, LuaRejectsTables,
    ::testing::Values(
        TableCase{"NoTable", "nil", "the script has no table inputTensorsInfo"},
        TableCase{"Text", "'3:4'", "the script has no table inputTensorsInfo"},
        TableCase{"NoNum", "{dim = {{2}}, type = {'uint8'}}",
                  "inputTensorsInfo.num is not a number of tensors"},
        TableCase{"NumZero", "{num = 0, dim = {}, type = {}}", "an integer from 1 to 256"},
        TableCase{"NumText", "{num = '1', dim = {{2}}, type = {'uint8'}}", "\"1\""},
        TableCase{"NumFraction", "{num = 1.5, dim = {{2}}, type = {'uint8'}}", "1.5"},
        TableCase{"NumBeyond", "{num = 257, dim = {{2}}, type = {'uint8'}}", "257"},
        TableCase{"NoDim", "{num = 1, type = {'uint8'}}", "inputTensorsInfo.dim is not a list"},
        TableCase{"DimText", "{num = 1, dim = '2', type = {'uint8'}}",
                  "inputTensorsInfo.dim is not a list"},
        TableCase{"NumBeyondDim", "{num = 2, dim = {{2}}, type = {'uint8', 'uint8'}}",
                  "inputTensorsInfo.dim and inputTensorsInfo.num have different lengths"},
        TableCase{"NumBeyondType", "{num = 2, dim = {{2}, {3}}, type = {'uint8'}}",
                  "inputTensorsInfo.type and inputTensorsInfo.num have different lengths"},
        TableCase{"DimBeyondNum", "{num = 1, dim = {{2}, {2}}, type = {'uint8'}}", "2 in the list"},
        TableCase{"FlatDim", "{num = 1, dim = {2}, type = {'uint8'}}",
                  "inputTensorsInfo.dim[1] is not a list"},
        TableCase{"NoDimensions", "{num = 1, dim = {{}}, type = {'uint8'}}",
                  "inputTensorsInfo.dim[1] has a number of dimensions"},
        TableCase{"SeventeenDimensions",
                  "{num = 1, dim = {{1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1}}, type = {'uint8'}}", "17"},
        TableCase{"NegativeDimension", "{num = 1, dim = {{2, -1}}, type = {'uint8'}}",
                  "inputTensorsInfo.dim[1][2] is not a dimension"},
        TableCase{"ZeroWithin", "{num = 1, dim = {{2, 0, 3}}, type = {'uint8'}}",
                  "inputTensorsInfo.dim[1][2] is not a dimension"},
        TableCase{"TextDimension", "{num = 1, dim = {{'2'}}, type = {'uint8'}}", "\"2\""},
        TableCase{"NotANumber", "{num = 1, dim = {{0/0}}, type = {'uint8'}}",
                  "inputTensorsInfo.dim[1][1] is not a dimension"},
        TableCase{"TooLarge", "{num = 1, dim = {{65536, 65536}}, type = {'uint8'}}",
                  "inputTensorsInfo.dim[1] is too large for a script"},
        TableCase{"NoType", "{num = 1, dim = {{2}}}", "inputTensorsInfo.type is not a list"},
        TableCase{"UnknownType", "{num = 1, dim = {{2}}, type = {'uint9'}}",
                  "inputTensorsInfo.type[1] is not an element type"},
        TableCase{"TypeNumber", "{num = 1, dim = {{2}}, type = {5}}", "float16"},
        TableCase{"ATrap", "setmetatable({}, {__index = function() error('no') end})",
                  "the tables of the script cannot be read"}),
    [](const auto& info) { return info.param.name; });

TEST_F(LuaRejects, TablesOfOutputs) {
  const std::string input = "inputTensorsInfo = {num = 1, dim = {{2}}, type = {'uint8'}}\n";
  EXPECT_SAYS(refusal(input + kInvoke).message(), "the script has no table outputTensorsInfo");
  EXPECT_SAYS(
      refusal(input + "outputTensorsInfo = {num = 1, dim = {{2}}, type = {'half'}}\n" + kInvoke)
          .message(),
      "outputTensorsInfo.type[1] is not an element type");
}

TEST_F(LuaRejects, AScriptWithoutItsFunction) {
  const std::string tables =
      "inputTensorsInfo = {num = 1, dim = {{2}}, type = {'uint8'}}\n" + std::string(kOutput);
  EXPECT_SAYS(refusal(tables).message(), "the script has no function nnstreamer_invoke");
  EXPECT_SAYS(refusal(tables + "nnstreamer_invoke = 5").message(), "offered: ");
}

TEST_F(LuaRejects, AFileThatDoesNotExist) {
  const auto model = OpenEngine::open(*engine(), folder_.path("none.lua"));
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().code, Code::MODEL_NOT_FOUND);
  EXPECT_SAYS(model.error().message(), "none.lua");
}

TEST_F(LuaRejects, AFolder) {
  const auto model = OpenEngine::open(*engine(), folder_.path(""));
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().code, Code::MODEL_NOT_FOUND);
}

TEST_F(LuaRejects, AnEmptyFile) {
  EXPECT_EQ(refusal("").code, Code::MODEL_INVALID);
}

TEST_F(LuaRejects, TextThatIsNotLua) {
  const Error error = refusal("inputTensorsInfo = {num = 1\n\nfunction (");
  EXPECT_EQ(error.code, Code::MODEL_INVALID);
  EXPECT_SAYS(error.message(), "the script is not valid Lua");
  EXPECT_SAYS(error.message(), "model.bin:3:");
}

TEST_F(LuaRejects, ByteCode) {
  for (const char* text : {"\x1BLJ\x02", "\x1BLua", "# a line\n\x1BLJ\x02"}) {
    const Error error = refusal(text);
    EXPECT_EQ(error.code, Code::MODEL_INVALID);
    EXPECT_FALSE(error.offered.empty());
  }
  EXPECT_SAYS(refusal("\x1BLJ\x02").message(), "Lua byte code is not run");
}

TEST_F(LuaRejects, AScriptThatFailsWhenItIsOpened) {
  const Error error = refusal("local function deep() error('no camera') end\n\ndeep()");
  EXPECT_EQ(error.code, Code::MODEL_INVALID);
  EXPECT_SAYS(error.message(), "model.bin:1: no camera");
  EXPECT_SAYS(error.message(), "stack traceback");
  EXPECT_SAYS(error.message(), "model.bin:3: in main chunk");
  EXPECT_LACKS(error.message(), "weir:") << "no line of ours";
}

TEST_F(LuaRejects, AScriptThatFailsOnAFrame) {
  const Error error = failure("local t = nil  y[1] = t.x");
  EXPECT_EQ(error.code, Code::INVOKE_FAILED);
  EXPECT_SAYS(error.message(), "the script failed on a frame");
  EXPECT_SAYS(error.message(), "model.bin:5: attempt to index local 't' (a nil value)");
  EXPECT_SAYS(error.message(), "stack traceback");
  EXPECT_LACKS(error.message(), "weir:") << "no line of ours";
}

TEST_F(LuaRejects, ErrorsThatAreNotText) {
  EXPECT_SAYS(failure("error({})").message(), "the error is not text");
  EXPECT_SAYS(failure("error()").message(), "the error is not text");
}

TEST_F(LuaRejects, IndicesOutsideATensor) {
  for (const char* key : {"0", "5", "-1", "1.5", "1/0", "0/0", "2^40"}) {
    const Error error = failure("y[1] = x[" + std::string(key) + "]");
    EXPECT_EQ(error.code, Code::INVOKE_FAILED) << key;
    EXPECT_SAYS(error.message(), "is out of range: it has 4 elements, counted from 1 (float32 4)");
    EXPECT_SAYS(error.message(), "model.bin:5: input_tensor(1)[");
    EXPECT_SAYS(failure("y[" + std::string(key) + "] = 0").message(), "output_tensor(1)[");
  }
  EXPECT_SAYS(failure("y[1] = x[5]").message(), "input_tensor(1)[5] is out of range");
}

TEST_F(LuaRejects, IndicesOutsideATensorInACompiledLoop) {
  const auto model =
      script(script_text("for i = 1, 10001 do y[i] = x[i] end", "uint8", "uint8", 10000));
  ASSERT_NE(model, nullptr);
  for (int frame = 0; frame < 3; ++frame) {
    const auto y = model->invoke({make_tensor(WEIR_UINT8, {10000})});
    ASSERT_FALSE(y);
    EXPECT_SAYS(y.error().message(),
                "input_tensor(1)[10001] is out of range: it has 10000 elements");
  }
}

TEST_F(LuaRejects, InvalidIndices) {
  EXPECT_SAYS(failure("y[1] = x.data").message(),
              "input_tensor(1)[data]: tensors have elements only, counted from 1");
  EXPECT_SAYS(failure("x.count = 1e9").message(), "input_tensor(1)[count]: tensors have elements");
  EXPECT_SAYS(failure("y[x] = 1").message(), "tensors have elements only");
}

TEST_F(LuaRejects, InvalidNumbers) {
  for (const char* value : {"nil", "{}", "true", "'a'", "x", "print"})
    EXPECT_SAYS(failure("y[2] = " + std::string(value)).message(), "a number is needed");
  EXPECT_SAYS(failure("y[2] = nil").message(), "output_tensor(1)[2] = nil: a number is needed");
}

TEST_F(LuaRejects, TensorsThatDoNotExist) {
  EXPECT_SAYS(failure("y[1] = input_tensor(2)[1]").message(),
              "input_tensor(2): the script has 1 inputs, counted from 1");
  EXPECT_SAYS(failure("output_tensor(0)[1] = 1").message(), "output_tensor(0): the script has 1");
  EXPECT_SAYS(failure("output_tensor()[1] = 1").message(), "output_tensor(nil): the script has 1");
}

TEST_F(LuaRejects, TensorsBeforeAFrame) {
  EXPECT_SAYS(refusal("local x = input_tensor(1)\n" + script_text("")).message(),
              "model.bin:1: input_tensor(): the tensors are known when the script has run");
}

TEST_F(LuaRejects, AFunctionThatWasRemoved) {
  const auto model = script(script_text("nnstreamer_invoke = nil"));
  ASSERT_NE(model, nullptr);
  ASSERT_TRUE(model->invoke({make_tensor(WEIR_FLOAT32, {4})}));
  const auto y = model->invoke({make_tensor(WEIR_FLOAT32, {4})});
  ASSERT_FALSE(y);
  EXPECT_SAYS(y.error().message(), "nnstreamer_invoke is no longer a function");
}

TEST_F(LuaRejects, RecursionWithoutEnd) {
  EXPECT_SAYS(failure("local function f() return 1 + f() end  y[1] = f()").message(),
              "stack overflow");
}

TEST_F(LuaRejects, MemoryBeyondItsLimit) {
  const char* const hogs[] = {"local t = {}  for i = 1, 1e9 do t[i] = {i} end",
                              "local s = 'x'  while true do s = s .. s end",
                              "hog = string.rep('x', 2^30)"};
  for (const char* hog : hogs) {
    const Error error = failure(hog, {{"MemoryLimit", "16"}});
    EXPECT_EQ(error.code, Code::INVOKE_FAILED);
    EXPECT_SAYS(error.message(), "not enough memory");
    EXPECT_SAYS(error.message(), "fix: custom=MemoryLimit:32");
  }
}

TEST_F(LuaRejects, FreedMemoryDoesNotCount) {
  for (const char* sandbox : {"true", "false"})
    EXPECT_EQ(result("for i = 1, 200 do local s = string.rep('x', 2^20) .. i end  y[1] = 1",
                     {{"MemoryLimit", "16"}, {"Sandbox", sandbox}}),
              (std::vector<float>{1, 0, 0, 0}))
        << sandbox;
}

TEST_F(LuaRejects, ToRunWithoutMemoryAndRecovers) {
  const auto text = script_text("for i = 1, #x do y[i] = -x[i] end", "float32", "float32", 1 << 22);
  expect_errors_without_memory(
      {*engine(), folder_.write("model.lua", to_bytes(text)), {1 << 22}, folder_.path("")});
}

TEST_F(LuaRejects, InputsThatDoNotFit) {
  const auto model = script(script_text("y[1] = 1"));
  ASSERT_NE(model, nullptr);
  for (const auto& [input, words] : std::vector<std::pair<TestTensor, const char*>>{
           {make_tensor(WEIR_UINT8, {4}), "uint8"},
           {make_tensor(WEIR_FLOAT32, {5}), "5"},
           {make_tensor(WEIR_FLOAT32, {4, 1}), "rank"}}) {
    const auto y = model->invoke({input});
    ASSERT_FALSE(y);
    EXPECT_EQ(y.error().code, Code::SPEC_MISMATCH);
    EXPECT_SAYS(y.error().message(), words);
  }
  EXPECT_FALSE(model->invoke({}));
}

TEST_F(LuaRejects, FramesWhoseSizeIsInconsistent) {
  const auto model = script(script_text("y[1] = x[4]"));
  ASSERT_NE(model, nullptr);
  float x[2] = {};
  OneToOne frames({4}, x);
  const weir_tensor& out = frames.out;
  const Status status = frames.through(*model);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Code::FRAME_SIZE);
  EXPECT_EQ(out.data, nullptr);
}

TEST_F(LuaRejects, AScriptThatDeclaresDifferentTensorsEachTime) {
  // The address differs from run to run, even in a sandbox.
  const auto model = script(
      "local n = tonumber(tostring({}):match('0x(%x+)'), 16) % 2^20 + 1\n"
      "inputTensorsInfo = {num = 1, dim = {{n}}, type = {'uint8'}}\n" +
      std::string(kOutput) + kInvoke);
  ASSERT_NE(model, nullptr);
  Status status = ok();
  for (int i = 0; status && i < 10; ++i) status = model->control(WEIR_RESET_STATE);
  ASSERT_FALSE(status);
  EXPECT_SAYS(status.error().message(), "the script declares different tensors each time it runs");
}

TEST_F(LuaRejects, OptionsThatCannotBeUsed) {
  const std::string text = script_text("");
  for (const char* value : {"0", "-1", "much", ""}) {
    const Error error = refusal(text, {{"MemoryLimit", value}});
    EXPECT_EQ(error.code, Code::OPTION_VALUE) << value;
    EXPECT_SAYS(error.message(), "MemoryLimit");
  }
  const Error error = refusal(text, {{"Libraries", "io+socket"}});
  EXPECT_EQ(error.code, Code::OPTION_VALUE);
  EXPECT_SAYS(error.message(), "offered: socket");
  EXPECT_SAYS(error.message(), "io, os, package, debug, jit, ffi");
}

TEST_F(LuaRejects, LogsUnknownOptions) {
  ASSERT_NE(script(script_text(""), {{"Librarys", "io"}}), nullptr);
  const auto lines = take_log();
  EXPECT_TRUE(std::any_of(lines.begin(), lines.end(), [](const auto& line) {
    return line.find("Librarys") != std::string::npos &&
           line.find("Libraries, MemoryLimit, Sandbox") != std::string::npos;
  }));
}

TEST_F(LuaRejects, UnsupportedControlCalls) {
  const auto model = script(script_text(""));
  ASSERT_NE(model, nullptr);
  EXPECT_TRUE(model->control(WEIR_WARM));
  EXPECT_EQ(model->control(WEIR_SUSPEND).error().code, Code::MODEL_UNSUPPORTED);
  EXPECT_EQ(model->control(WEIR_SET_OPTION).error().code, Code::OPTION_VALUE);
}

}  // namespace lua_refusals_test
}  // namespace weir::engine_test
