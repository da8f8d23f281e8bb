// Tests of scripts through the C ABI: the functions and tables of docs/compatibility/filter.md
// 4.14, element types, globals.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>
#include <cstring>
#include <limits>
#include <thread>

#include "lua/lua_test_support.hpp"

namespace weir::engine_test {
namespace lua_test {

class Lua : public LuaTest {};

TEST_F(Lua, RunsAScriptOnEachFrame) {
  const auto model = script(R"lua(
inputTensorsInfo = {num = 1, dim = {{3, 2}}, type = {'uint8'}}
outputTensorsInfo = {num = 1, dim = {{3, 2}}, type = {'float32'}}
function nnstreamer_invoke()
  local x, y = input_tensor(1), output_tensor(1)
  for i = 1, 6 do y[i] = x[i] / 2 end
end
)lua");
  ASSERT_NE(model, nullptr);
  EXPECT_EQ(to_string(model->inputs()[0]), "uint8[2, 3]");
  EXPECT_EQ(to_string(model->outputs()[0]), "float32[2, 3]");
  for (uint8_t k = 0; k < 3; ++k) {
    const auto y = model->invoke({make_tensor<uint8_t>(WEIR_UINT8, {2, 3}, {0, 1, 2, 3, 254, k})});
    ASSERT_TRUE(y) << y.error().message();
    EXPECT_EQ((*y)[0].values<float>(),
              (std::vector<float>{0, 0.5f, 1, 1.5f, 127, static_cast<float>(k) / 2}));
  }
}

TEST_F(Lua, SeveralTensorsOfSeveralTypes) {
  const auto model = script(R"lua(
inputTensorsInfo = {num = 2, dim = {{2}, {1, 1, 3}}, type = {'int16', 'float64'}}
outputTensorsInfo = {num = 3, dim = {{1}, {2}, {3, 1, 1, 1}}, type = {'int64', 'INT8', 'float32'}}
function nnstreamer_invoke()
  output_tensor(1)[1] = #input_tensor(1) * 100 + #input_tensor(2)
  for i = 1, 2 do output_tensor(2)[i] = input_tensor(1)[3 - i] end
  for i = 1, 3 do output_tensor(3)[i] = input_tensor(2)[i] end
end
)lua");
  ASSERT_NE(model, nullptr);
  EXPECT_EQ(to_string(model->inputs()[1]), "float64[3, 1, 1]");
  EXPECT_EQ(to_string(model->outputs()[2]), "float32[1, 1, 1, 3]");
  const auto out = model->invoke({make_tensor<int16_t>(WEIR_INT16, {2}, {-5, 7}),
                                  make_tensor<double>(WEIR_FLOAT64, {3, 1, 1}, {0.5, -2, 1e6})});
  ASSERT_TRUE(out) << out.error().message();
  EXPECT_EQ((*out)[0].values<int64_t>(), (std::vector<int64_t>{203}));
  EXPECT_EQ((*out)[1].values<int8_t>(), (std::vector<int8_t>{7, -5}));
  EXPECT_EQ((*out)[2].values<float>(), (std::vector<float>{0.5f, -2, 1e6f}));
}

TEST_F(Lua, ZerosAfterTheDimensionsAreIgnored) {
  const auto model = script(R"lua(
inputTensorsInfo = {num = 1, dim = {{3, 2, 0, 0}}, type = {'uint8'}}
outputTensorsInfo = {num = 1, dim = {{1}}, type = {'uint8'}}
function nnstreamer_invoke() end
)lua");
  ASSERT_NE(model, nullptr);
  EXPECT_EQ(to_string(model->inputs()[0]), "uint8[2, 3]");
}

// The results of assigning 1.75, -1.75, 300.5 and 2^31 + 5: truncated to a whole number, then taken
// modulo 2 to the power of the type's bits.
template <class T>
std::vector<T> cut_and_wrapped() {
  const auto wrapped = [](int64_t value) {
    return static_cast<T>(static_cast<std::make_unsigned_t<T>>(static_cast<uint64_t>(value)));
  };
  return {wrapped(1), wrapped(-1), wrapped(300), wrapped((int64_t{1} << 31) + 5)};
}
constexpr char kAwkward[] = "y[1] = 1.75  y[2] = -1.75  y[3] = 300.5  y[4] = 2^31 + 5";

template <class T>
class LuaIntegers : public LuaTest {
 public:
  static std::string name() {
    return std::string(std::is_signed_v<T> ? "int" : "uint") + std::to_string(8 * sizeof(T));
  }
  static uint32_t type() {
    for (uint32_t type = 0; type < WEIR_TYPE_END; ++type) {
      weir_tensor_info info{};
      info.type = type;
      if (to_string(info).starts_with(name() + "[")) return type;
    }
    return WEIR_TYPE_END;
  }
};
using Integers =
    ::testing::Types<int8_t, uint8_t, int16_t, uint16_t, int32_t, uint32_t, int64_t, uint64_t>;
TYPED_TEST_SUITE(LuaIntegers, Integers);

TYPED_TEST(LuaIntegers, AreTruncatedAndWrapped) {
  const auto model = this->script(script_text(kAwkward, "uint8", TestFixture::name()));
  ASSERT_NE(model, nullptr);
  const auto y = model->invoke({make_tensor(WEIR_UINT8, {4})});
  ASSERT_TRUE(y) << y.error().message();
  EXPECT_EQ((*y)[0].template values<TypeParam>(), cut_and_wrapped<TypeParam>());
}

// The compiled loop (ten thousand elements) and the interpreter (the first four) must agree.
TYPED_TEST(LuaIntegers, AreTheSameWhenCompiled) {
  constexpr int kElements = 10000;
  const auto model = this->script(script_text("for i = 1, #y do y[i] = (i - 5000) * 3.7 end",
                                              "uint8", TestFixture::name(), kElements));
  ASSERT_NE(model, nullptr);
  const auto y = model->invoke({make_tensor(WEIR_UINT8, {kElements})});
  ASSERT_TRUE(y) << y.error().message();
  const auto values = (*y)[0].template values<TypeParam>();
  for (int i = 0; i < kElements; ++i) {
    const auto whole = static_cast<int64_t>((i + 1 - 5000) * 3.7);
    ASSERT_EQ(values[static_cast<size_t>(i)], static_cast<TypeParam>(static_cast<uint64_t>(whole)))
        << i;
  }
}

TYPED_TEST(LuaIntegers, AreUnchangedAtTheirLimits) {
  using Limits = std::numeric_limits<TypeParam>;
  // For 64 bits: the largest power of two up to which a Lua number is exact.
  const auto max =
      sizeof(TypeParam) == 8 ? static_cast<TypeParam>(int64_t{1} << 53) : Limits::max();
  const auto min = std::is_signed_v<TypeParam> ? static_cast<TypeParam>(-max) : TypeParam{0};
  const auto name = TestFixture::name();
  const auto model = this->script(script_text("for i = 1, 4 do y[i] = x[i] end", name, name));
  ASSERT_NE(model, nullptr);
  const std::vector<TypeParam> x{max, min, 1, 0};
  const auto y = model->invoke({make_tensor<TypeParam>(TestFixture::type(), {4}, x)});
  ASSERT_TRUE(y) << y.error().message();
  EXPECT_EQ((*y)[0].template values<TypeParam>(), x);
}

TEST_F(Lua, ReadsEveryTypeAsNumbers) {
  for (const char* type : {"int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64",
                           "float16", "float32", "float64"}) {
    const auto model = script(script_text(
        "y[1] = type(x[1]) == 'number' and 1 or 0  x[2] = 77  y[2] = x[2]  y[3] = x[3]", type));
    ASSERT_NE(model, nullptr);
    const auto y = model->invoke({make_tensor(model->inputs()[0].type, {4})});
    ASSERT_TRUE(y) << y.error().message();
    EXPECT_EQ((*y)[0].values<float>(), (std::vector<float>{1, 77, 0, 0})) << type;
  }
}

TEST_F(Lua, LargeIntegerLiteralsAreExact) {
  const auto model = script(script_text(
      "y[1] = 9007199254740993LL  y[2] = -1LL  y[3] = 0xFFFFFFFFFFFFFFFFULL  y[4] = x[1]", "uint64",
      "uint64"));
  ASSERT_NE(model, nullptr);
  const auto y =
      model->invoke({make_tensor<uint64_t>(WEIR_UINT64, {4}, {9007199254740993u, 0, 0, 0})});
  ASSERT_TRUE(y) << y.error().message();
  // A Lua number has 53 bits: reading gives the nearest one.
  EXPECT_EQ((*y)[0].values<uint64_t>(),
            (std::vector<uint64_t>{9007199254740993u, UINT64_MAX, UINT64_MAX, 9007199254740992u}));
}

TEST_F(Lua, DoublesKeepAllTheirBits) {
  const auto model = script(script_text("for i = 1, 4 do y[i] = x[i] end", "float64", "float64"));
  ASSERT_NE(model, nullptr);
  const std::vector<double> x{1.0 / 3, -1e300, std::numeric_limits<double>::infinity(), 5e-324};
  const auto y = model->invoke({make_tensor<double>(WEIR_FLOAT64, {4}, x)});
  ASSERT_TRUE(y) << y.error().message();
  EXPECT_EQ((*y)[0].values<double>(), x);
}

TEST_F(Lua, HalfFloats) {
  const auto model =
      script(script_text("for i = 1, #x do y[i] = x[i] end", "float16", "float32", 5));
  ASSERT_NE(model, nullptr);
  const auto y = model->invoke(
      {make_tensor<uint16_t>(WEIR_FLOAT16, {5}, {0x3C00, 0xC100, 0x7BFF, 0x0001, 0xFC00})});
  ASSERT_TRUE(y) << y.error().message();
  EXPECT_EQ((*y)[0].values<float>(), (std::vector<float>{1, -2.5f, 65504, 0x1p-24f,
                                                         -std::numeric_limits<float>::infinity()}));
  const auto back =
      script(script_text("for i = 1, #x do y[i] = x[i] end", "float32", "float16", 6));
  ASSERT_NE(back, nullptr);
  const auto h = back->invoke({make_tensor<float>(
      WEIR_FLOAT32, {6}, {1, -2.5f, 65520, 0x1p-25f, 1.0f + 0x1p-11f, 1.0f + 3 * 0x1p-11f})});
  ASSERT_TRUE(h) << h.error().message();
  // Rounded to nearest, ties to even.
  EXPECT_EQ((*h)[0].values<uint16_t>(),
            (std::vector<uint16_t>{0x3C00, 0xC100, 0x7C00, 0x0000, 0x3C00, 0x3C02}));
}

TEST_F(Lua, EachHalfFloatRoundTrips) {
  const auto model =
      script(script_text("for i = 1, #x do y[i] = x[i] end", "float16", "float16", 65536));
  ASSERT_NE(model, nullptr);
  std::vector<uint16_t> all(65536);
  for (size_t i = 0; i < all.size(); ++i) all[i] = static_cast<uint16_t>(i);
  const auto y = model->invoke({make_tensor<uint16_t>(WEIR_FLOAT16, {65536}, all)});
  ASSERT_TRUE(y) << y.error().message();
  const auto values = (*y)[0].values<uint16_t>();
  for (size_t i = 0; i < all.size(); ++i) {
    const bool nan = (i & 0x7C00) == 0x7C00 && (i & 0x3FF) != 0;
    if (nan)
      ASSERT_TRUE((values[i] & 0x7C00) == 0x7C00 && (values[i] & 0x3FF) != 0) << i;
    else
      ASSERT_EQ(values[i], all[i]) << i;
  }
}

TEST_F(Lua, UnwrittenElementsAreZero) {
  EXPECT_EQ(result("y[2] = 5"), (std::vector<float>{0, 5, 0, 0}));
}

TEST_F(Lua, AScriptCanWriteItsInputWithoutChangingTheStream) {
  const auto model = script(script_text("for i = 1, 4 do x[i] = x[i] * 2  y[i] = x[i] + 1 end"));
  ASSERT_NE(model, nullptr);
  const auto x = make_tensor<float>(WEIR_FLOAT32, {4}, {1, 2, 3, 4});
  for (int frame = 0; frame < 3; ++frame) {
    const auto y = model->invoke({x});
    ASSERT_TRUE(y) << y.error().message();
    EXPECT_EQ((*y)[0].values<float>(), (std::vector<float>{3, 5, 7, 9}));
    EXPECT_EQ(x.values<float>(), (std::vector<float>{1, 2, 3, 4}));
  }
}

TEST_F(Lua, GlobalsPersistUntilAReset) {
  const auto model = script("count = 0\n" + script_text("count = count + 1  y[1] = count"));
  ASSERT_NE(model, nullptr);
  const auto frame = make_tensor(WEIR_FLOAT32, {4});
  for (const float expected : {1.0f, 2.0f}) {
    const auto y = model->invoke({frame});
    ASSERT_TRUE(y);
    EXPECT_EQ((*y)[0].values<float>()[0], expected);
  }
  ASSERT_TRUE(model->control(WEIR_RESET_STATE));
  const auto y = model->invoke({frame});
  ASSERT_TRUE(y);
  EXPECT_EQ((*y)[0].values<float>()[0], 1);
}

TEST_F(Lua, AKeptTensorRefersToTheCurrentFrame) {
  const auto model = script(script_text("kept = kept or x  y[1] = kept[1]"));
  ASSERT_NE(model, nullptr);
  for (const float value : {3.0f, 4.0f}) {
    const auto y = model->invoke({make_tensor<float>(WEIR_FLOAT32, {4}, {value, 0, 0, 0})});
    ASSERT_TRUE(y) << y.error().message();
    EXPECT_EQ((*y)[0].values<float>()[0], value);
  }
}

TEST_F(Lua, GarbageCollectionKeepsTensors) {
  const auto model = script(script_text("collectgarbage()  y[1] = x[1] + #y  collectgarbage()"));
  ASSERT_NE(model, nullptr);
  for (const float value : {3.0f, 4.0f, 5.0f}) {
    const auto y = model->invoke({make_tensor<float>(WEIR_FLOAT32, {4}, {value, 0, 0, 0})});
    ASSERT_TRUE(y) << y.error().message();
    EXPECT_EQ((*y)[0].values<float>()[0], value + 4);
  }
}

TEST_F(Lua, FramesAfterAFailureSucceed) {
  const auto model = script(script_text("if x[1] < 0 then error('negative') end  y[1] = x[1]"));
  ASSERT_NE(model, nullptr);
  ASSERT_FALSE(model->invoke({make_tensor<float>(WEIR_FLOAT32, {4}, {-1, 0, 0, 0})}));
  const auto y = model->invoke({make_tensor<float>(WEIR_FLOAT32, {4}, {2, 0, 0, 0})});
  ASSERT_TRUE(y) << y.error().message();
  EXPECT_EQ((*y)[0].values<float>()[0], 2);
}

TEST_F(Lua, TensorsReportTheirTypeAndShape) {
  EXPECT_EQ(result("y[1] = #x  y[2] = tostring(x) == 'input_tensor(1): float32 4' and 1 or 0"),
            (std::vector<float>{4, 1, 0, 0}));
}

TEST_F(Lua, TextThatIsANumberIsOne) {
  EXPECT_EQ(result("y[1] = '2.5'"), (std::vector<float>{2.5f, 0, 0, 0}));
}

TEST_F(Lua, HarmlessLibrariesAreAvailable) {
  EXPECT_EQ(result(R"lua(
    y[1] = math.floor(2.5)
    y[2] = #string.rep('a', 3)
    y[3] = bit.band(7, 12)
    y[4] = coroutine.wrap(function() return table.maxn({1, 2}) end)()
  )lua"),
            (std::vector<float>{2, 3, 4, 2}));
}

TEST_F(Lua, TheModelCanBeTheScriptText) {
  // The element passes model= split at its commas.
  std::string text = script_text("y[1] = x[4], x[3]");
  std::vector<std::string> parts;
  for (size_t at = 0; at != std::string::npos;) {
    const size_t comma = text.find(',', at);
    parts.push_back(text.substr(at, comma == std::string::npos ? comma : comma - at));
    at = comma == std::string::npos ? comma : comma + 1;
  }
  std::vector<const char*> paths;
  for (const auto& part : parts) paths.push_back(part.c_str());
  weir_open request{};
  request.struct_size = sizeof request;
  request.n_models = static_cast<uint32_t>(paths.size());
  request.paths = paths.data();
  weir_error error;
  weir_model* model = nullptr;
  ASSERT_EQ(engine()->open(&request, &model, &error), WEIR_OK) << error.error.message();
  weir_model_info info{};
  info.struct_size = sizeof info;
  EXPECT_EQ(engine()->info(model, &info, &error), WEIR_OK);
  EXPECT_EQ(info.n_inputs, 1u);
  EXPECT_GT(info.weight_bytes, 0u);
  engine()->close(model);
}

TEST_F(Lua, SessionsHaveTheirOwnGlobalsAndRunConcurrently) {
  const auto path = folder_.write(
      "count.lua", to_bytes("count = 0\n" + script_text("count = count + 1  y[1] = count")));
  std::vector<std::thread> threads;
  std::vector<float> last(4);
  for (auto& seen : last)
    threads.emplace_back([&path, &seen] {
      const auto model = opened(path);
      for (int i = 0; model && i < 200; ++i) {
        const auto y = model->invoke({make_tensor(WEIR_FLOAT32, {4})});
        seen = y ? (*y)[0].values<float>()[0] : -1;
      }
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(last, (std::vector<float>{200, 200, 200, 200}));
}

TEST_F(Lua, AllocatesAnOutputWithoutMemory) {
  const auto model = script(script_text("y[4] = 9"));
  ASSERT_NE(model, nullptr);
  float x[4] = {};
  OneToOne frames({4}, x);
  const weir_tensor& out = frames.out;
  ASSERT_TRUE(frames.through(*model));
  ASSERT_EQ(out.bytes, 16u);
  EXPECT_EQ(static_cast<const float*>(out.data)[3], 9);
  out.release(out.owner);
}

TEST_F(Lua, RecognisesScripts) {
  const auto score = [](const char* path, const std::string& head) {
    int out = -1;
    weir_error error;
    EXPECT_EQ(engine()->probe(path, head.data(), head.size(), &out, &error), WEIR_OK);
    return out;
  };
  EXPECT_GT(score("a.lua", ""), 50);
  EXPECT_GT(score("a", "-- mine\ninputTensorsInfo = {"), 50);
  EXPECT_EQ(score("a.onnx", "ONNX"), 0);
}

}  // namespace lua_test
}  // namespace weir::engine_test
