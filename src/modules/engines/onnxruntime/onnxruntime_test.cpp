// Tests of ONNX Runtime through the C table: types, shapes, memory, options.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "engine_contract_test_support.hpp"
#include "engine_library.hpp"
#include "onnxruntime/onnx_builder_test_support.hpp"
#include "says.hpp"
#include "usable_cores.hpp"

namespace weir::engine_test {
namespace onnxruntime_test {

class OnnxRuntime : public EngineTest {
 protected:
  Result<std::unique_ptr<OpenEngine>> open(const OnnxBuilder& model, const Options& options = {}) {
    return EngineTest::open(model.bytes(), options);
  }
};

struct TypeCase {
  int onnx;
  uint32_t weir;
};
class OnnxRuntimeTypes : public OnnxRuntime, public ::testing::WithParamInterface<TypeCase> {};

TEST_P(OnnxRuntimeTypes, PassThroughUnchanged) {
  auto model = open(OnnxBuilder()
                        .input("x", GetParam().onnx, {"2", "3"})
                        .output("y", GetParam().onnx, {"3", "2"})
                        .node("Transpose", {"x"}, {"y"}));
  ASSERT_TRUE(model) << model.error().message();
  auto x = make_tensor(GetParam().weir, {2, 3});
  for (size_t i = 0; i < x.bytes.size(); ++i) x.bytes[i] = std::byte(i % 2);  // valid as bool too
  const auto y = (*model)->invoke({x});
  ASSERT_TRUE(y) << y.error().message();
  EXPECT_EQ((*y)[0].info.type, GetParam().weir);
  EXPECT_EQ(to_shape((*y)[0].info), (std::vector<int64_t>{3, 2}));
  const size_t size = x.bytes.size() / 6;
  for (size_t row = 0; row < 2; ++row)
    for (size_t column = 0; column < 3; ++column)
      for (size_t byte = 0; byte < size; ++byte)
        EXPECT_EQ((*y)[0].bytes[(column * 2 + row) * size + byte],
                  x.bytes[(row * 3 + column) * size + byte]);
}
INSTANTIATE_TEST_SUITE_P(
    All, OnnxRuntimeTypes,
    ::testing::Values(TypeCase{kFloat, WEIR_FLOAT32}, TypeCase{kUint8, WEIR_UINT8},
                      TypeCase{kInt8, WEIR_INT8}, TypeCase{kUint16, WEIR_UINT16},
                      TypeCase{kInt16, WEIR_INT16}, TypeCase{kInt32, WEIR_INT32},
                      TypeCase{kInt64, WEIR_INT64}, TypeCase{kBool, WEIR_UINT8},
                      TypeCase{kFloat16, WEIR_FLOAT16}, TypeCase{kDouble, WEIR_FLOAT64},
                      TypeCase{kUint32, WEIR_UINT32}, TypeCase{kUint64, WEIR_UINT64}));

TEST_F(OnnxRuntime, AnyByteButZeroIsTrue) {
  auto model = open(
      OnnxBuilder().input("x", kBool, {"4"}).output("y", kBool, {"4"}).node("Not", {"x"}, {"y"}));
  ASSERT_TRUE(model) << model.error().message();
  const auto y = (*model)->invoke({make_tensor<uint8_t>(WEIR_UINT8, {4}, {0, 1, 2, 255})});
  ASSERT_TRUE(y) << y.error().message();
  EXPECT_EQ((*y)[0].values<uint8_t>(), (std::vector<uint8_t>{1, 0, 0, 0}));
}

TEST_F(OnnxRuntime, HalfFloatsKeepTheirBits) {
  auto model = open(OnnxBuilder()
                        .input("x", kFloat16, {"3"})
                        .output("y", kFloat, {"3"})
                        .node("Cast", {"x"}, {"y"})
                        .attribute("to", kFloat));
  ASSERT_TRUE(model) << model.error().message();
  const auto y =
      (*model)->invoke({make_tensor<uint16_t>(WEIR_FLOAT16, {3}, {0x3C00, 0xC100, 0x7BFF})});
  ASSERT_TRUE(y) << y.error().message();
  EXPECT_EQ((*y)[0].values<float>(), (std::vector<float>{1.0f, -2.5f, 65504.0f}));
}

TEST_F(OnnxRuntime, NotANumberIsAValueLikeOthers) {
  auto model = open(OnnxBuilder()
                        .input("x", kFloat, {"4"})
                        .output("y", kFloat, {"4"})
                        .node("Add", {"x", "x"}, {"y"}));
  ASSERT_TRUE(model) << model.error().message();
  const float infinity = std::numeric_limits<float>::infinity();
  const auto y =
      (*model)->invoke({make_tensor<float>(WEIR_FLOAT32, {4}, {NAN, infinity, -infinity, 2})});
  ASSERT_TRUE(y) << y.error().message();
  const auto values = (*y)[0].values<float>();
  EXPECT_TRUE(std::isnan(values[0]));
  EXPECT_EQ(values[1], infinity);
  EXPECT_EQ(values[2], -infinity);
  EXPECT_EQ(values[3], 4.0f);
}

TEST_F(OnnxRuntime, ScalarsHaveRankZero) {
  auto model = open(OnnxBuilder()
                        .input("x", kInt64, {})
                        .input("v", kInt64, {"2"})
                        .output("y", kInt64, {"2"})
                        .output("s", kInt64, {})
                        .node("Add", {"x", "v"}, {"y"})
                        .node("Add", {"x", "x"}, {"s"}));
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ((*model)->inputs()[0].rank, 0u);
  EXPECT_EQ((*model)->outputs()[1].rank, 0u);
  const auto out = (*model)->invoke(
      {make_tensor<int64_t>(WEIR_INT64, {}, {40}), make_tensor<int64_t>(WEIR_INT64, {2}, {2, -2})});
  ASSERT_TRUE(out) << out.error().message();
  EXPECT_EQ((*out)[0].values<int64_t>(), (std::vector<int64_t>{42, 38}));
  EXPECT_EQ((*out)[1].values<int64_t>(), (std::vector<int64_t>{80}));
}

TEST_F(OnnxRuntime, InputsAndOutputsKeepTheModelsOrderAndNames) {
  auto model = open(OnnxBuilder()
                        .input("b", kFloat, {"1"})
                        .input("a", kFloat, {"1"})
                        .output("difference", kFloat, {"1"})
                        .output("a sum", kFloat, {"1"})
                        .node("Sub", {"b", "a"}, {"difference"})
                        .node("Add", {"b", "a"}, {"a sum"}));
  ASSERT_TRUE(model) << model.error().message();
  expect_order_and_names(**model);
}

TEST_F(OnnxRuntime, OpenDimensionsAreMinusOneAndFollowTheInputByName) {
  auto model = open(OnnxBuilder()
                        .input("x", kFloat, {"n", "3"})
                        .output("y", kFloat, {"n", "3"})
                        .node("Neg", {"x"}, {"y"}));
  ASSERT_TRUE(model) << model.error().message();
  expect_rows_of_the_stream(**model);
}

TEST_F(OnnxRuntime, OpenDimensionsWithoutANameComeFromARunOnZeros) {
  auto model = open(OnnxBuilder()
                        .input("x", kFloat, {"n", "3"})
                        .input("y", kFloat, {"m", "3"})
                        .output("z", kFloat, {"k", "3"})
                        .node("Concat", {"x", "y"}, {"z"})
                        .attribute("axis", 0));
  ASSERT_TRUE(model) << model.error().message();
  const auto out = (*model)->resolve(
      {make_tensor(WEIR_FLOAT32, {2, 3}).info, make_tensor(WEIR_FLOAT32, {5, 3}).info});
  ASSERT_TRUE(out) << out.error().message();
  EXPECT_EQ(to_string((*out)[0]), "float32[7, 3]");
  EXPECT_EQ((*model)->inputs()[0].batch_axis, WEIR_NO_BATCH_AXIS);
}

TEST_F(OnnxRuntime, ShapesThatDependOnDataStayOpenAndAreAllocatedByTheEngine) {
  auto model = open(OnnxBuilder()
                        .input("x", kFloat, {"4"})
                        .output("y", kInt64, {"1", "found"})
                        .node("NonZero", {"x"}, {"y"}));
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_NE((*model)->info().flags & WEIR_MODEL_DYNAMIC_OUTPUT, 0u);
  for (const auto& [x, expected] : std::vector<std::pair<std::vector<float>, std::vector<int64_t>>>{
           {{0, 1, 0, 2}, {1, 3}}, {{0, 0, 0, 0}, {}}, {{1, 1, 1, 1}, {0, 1, 2, 3}}}) {
    const auto y = (*model)->invoke({make_tensor<float>(WEIR_FLOAT32, {4}, x)});
    ASSERT_TRUE(y) << y.error().message();
    EXPECT_EQ((*model)->engine_allocated(), 1u);
    EXPECT_EQ((*y)[0].values<int64_t>(), expected);
    EXPECT_EQ(to_shape((*y)[0].info), (std::vector<int64_t>{1, int64_t(expected.size())}));
  }
}

TEST_F(OnnxRuntime, AnOutputWithoutAShapeHasUnknownRank) {
  auto model = open(OnnxBuilder()
                        .input("x", kFloat, {"a", "b"})
                        .input("shape", kInt64, {"r"})
                        .shapeless_output("y", kFloat)
                        .node("Reshape", {"x", "shape"}, {"y"}));
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ((*model)->outputs()[0].rank, WEIR_RANK_UNKNOWN);
  const auto y = (*model)->invoke({make_tensor<float>(WEIR_FLOAT32, {2, 3}, {1, 2, 3, 4, 5, 6}),
                                   make_tensor<int64_t>(WEIR_INT64, {3}, {3, 1, 2})});
  ASSERT_TRUE(y) << y.error().message();
  EXPECT_EQ(to_shape((*y)[0].info), (std::vector<int64_t>{3, 1, 2}));
}

// The memory of an input that the model passes through must not be handed over as an output.
TEST_F(OnnxRuntime, AnInputThatIsAnOutputIsCopied) {
  auto model = open(OnnxBuilder()
                        .input("x", kFloat, {"2"})
                        .output("y", kFloat, {"2"})
                        .node("Identity", {"x"}, {"y"}));
  ASSERT_TRUE(model) << model.error().message();
  float x[] = {1, 2};
  OneToOne frames({2}, x);
  const auto status = frames.through(**model);
  ASSERT_TRUE(status) << status.error().message();
  const weir_tensor& out = frames.out;
  ASSERT_NE(out.release, nullptr);
  EXPECT_NE(out.data, x);
  EXPECT_EQ(static_cast<float*>(out.data)[1], 2);
  out.release(out.owner);
}

TEST_F(OnnxRuntime, ReportsMissingMemoryAndRecovers) {
  const auto bytes = OnnxBuilder()
                         .input("x", kFloat, {"n"})
                         .output("y", kFloat, {"n"})
                         .node("Neg", {"x"}, {"y"})
                         .bytes();
  expect_errors_without_memory({*engine(),
                                folder_.write("model.onnx", bytes),
                                {1 << 22},
                                folder_.path(""),
                                WEIR_ORT_OF_SYSTEM});
}

TEST_F(OnnxRuntime, TheTelemetryOfTheLibraryIsOff) {
  const char* off = std::getenv("ORT_DISABLE_TELEMETRY");
  ASSERT_NE(off, nullptr);
  EXPECT_STREQ(off, "1");
}

TEST_F(OnnxRuntime, ReadsAndWritesTheCallersMemory) {
  auto model = open(OnnxBuilder()
                        .input("x", kFloat, {"1024"})
                        .output("y", kFloat, {"1024"})
                        .node("Neg", {"x"}, {"y"}));
  ASSERT_TRUE(model) << model.error().message();
  const auto x = make_tensor<float>(WEIR_FLOAT32, {1024}, std::vector<float>(1024, 3));
  const auto y = (*model)->invoke({x});
  ASSERT_TRUE(y) << y.error().message();
  EXPECT_EQ((*model)->engine_allocated(), 0u);
  EXPECT_EQ((*y)[0].values<float>(), std::vector<float>(1024, -3));
}

TEST_F(OnnxRuntime, MemoryOfAnOutputOutlivesModelAndSession) {
  float x[] = {0, 7, 0, 0};
  OneToOne frames({4}, x);
  {
    auto model = open(OnnxBuilder()
                          .input("x", kFloat, {"4"})
                          .output("y", kInt64, {"1", "found"})
                          .node("NonZero", {"x"}, {"y"}));
    ASSERT_TRUE(model) << model.error().message();
    const auto status = frames.through(**model);
    ASSERT_TRUE(status) << status.error().message();
  }
  EXPECT_EQ(*static_cast<int64_t*>(frames.out.data), 1);
  frames.out.release(frames.out.owner);
}

TEST_F(OnnxRuntime, SessionsOfOneModelRunConcurrently) {
  const auto bytes = OnnxBuilder()
                         .input("x", kFloat, {"n"})
                         .output("y", kFloat, {"n"})
                         .node("Neg", {"x"}, {"y"})
                         .bytes();
  const auto path = folder_.write("model.onnx", bytes);
  expect_threads_to_run_at_once(path);
}

TEST_F(OnnxRuntime, WarmRunsWithoutAFrame) {
  auto model = open(
      OnnxBuilder().input("x", kFloat, {"2"}).output("y", kFloat, {"2"}).node("Neg", {"x"}, {"y"}));
  ASSERT_TRUE(model) << model.error().message();
  for (const int op : {WEIR_WARM, WEIR_RESUME, WEIR_RESET_STATE})
    EXPECT_TRUE((*model)->control(op)) << op;
  EXPECT_FALSE((*model)->control(WEIR_SUSPEND)) << "nothing to free: the host closes the model";
  EXPECT_FALSE((*model)->control(WEIR_SET_OPTION));
}

TEST_F(OnnxRuntime, ReportsTheOriginOfTheModel) {
  auto model = open(OnnxBuilder()
                        .input("x", kFloat, {"2"})
                        .output("y", kFloat, {"2"})
                        .node("Neg", {"x"}, {"y"})
                        .metadata("labels", "cat,dog")
                        .metadata("odd", "\xFF\xFE"));
  ASSERT_TRUE(model) << model.error().message();
  const auto json = nlohmann::json::parse((*model)->info().metadata_json);
  EXPECT_EQ(json["producer"], "weir tests");
  EXPECT_EQ(json["producer_version"], "3.1");
  EXPECT_EQ(json["opset"]["ai.onnx"], 13);
  EXPECT_EQ(json["custom_metadata_map"]["labels"], "cat,dog");
  EXPECT_TRUE(json["custom_metadata_map"].contains("odd"));
}

TEST_F(OnnxRuntime, AppliesItsOptions) {
  const auto model =
      OnnxBuilder().input("x", kFloat, {"2"}).output("y", kFloat, {"2"}).node("Neg", {"x"}, {"y"});
  EXPECT_TRUE(open(model, {{"numthreads", "2"},
                           {"GraphOptimization", "Basic"},
                           {"Spinning", "true"},
                           {"session.set_denormal_as_zero", "1"}}));
  // The engine may log that denormals are off.
  for (const auto& line : take_log()) EXPECT_LACKS(line, "not known");
  EXPECT_TRUE(open(model, {{"NumThread", "2"}}));
  const auto log = take_log();
  ASSERT_EQ(log.size(), 1u);
  EXPECT_SAYS(log[0], "NumThread is unknown");
}

TEST_F(OnnxRuntime, ASingleModelUsesAllCoresAndSpinsUnlessItIsSmall) {
  const auto model = OnnxBuilder()
                         .input("x", kFloat, {"2", "any"})
                         .output("y", kFloat, {"2", "any"})
                         .node("Neg", {"x"}, {"y"});
  const auto small =
      OnnxBuilder().input("x", kFloat, {"2"}).output("y", kFloat, {"2"}).node("Neg", {"x"}, {"y"});
  const auto cores = static_cast<uint32_t>(usable_cores());
  struct Case {
    const OnnxBuilder& model;
    Options options;
    int threads;
    uint32_t expected;
    bool spins;
  };
  const Case cases[] = {{model, {}, 0, cores, cores > 1},
                        {model, {{"Spinning", "false"}}, 0, cores, false},
                        {model, {{"session.intra_op.allow_spinning", "0"}}, 0, cores, false},
                        {model, {}, 3, 3, false},
                        {model, {}, 1, 1, false},
                        {model, {{"NumThreads", "2"}}, 2, 2, false},
                        {model, {{"Spinning", "true"}}, 2, 2, true},
                        {small, {}, 0, 1, false},
                        {small, {}, 3, 3, false},
                        {small, {{"NumThreads", "2"}}, 0, 2, true}};
  for (const auto& [network, options, threads, expected, spins] : cases) {
    const auto opened = EngineTest::open(network.bytes(), options, threads);
    ASSERT_TRUE(opened) << opened.error().message();
    EXPECT_EQ((*opened)->execution().threads, expected);
    EXPECT_EQ((*opened)->execution().spins, spins ? 1u : 0u);
  }
  EXPECT_TRUE(take_log().empty()) << "no key of the configuration is set twice";
}

TEST_F(OnnxRuntime, FindsWeightsInAFileNextToTheModel) {
  const float weights[] = {3, -2};
  const auto* bytes = reinterpret_cast<const std::byte*>(weights);
  folder_.write("weights.bin", {bytes, bytes + sizeof weights});
  const auto model = open(OnnxBuilder()
                              .input("x", kFloat, {"2"})
                              .output("y", kFloat, {"2"})
                              .constant_in_file("w", {2}, "weights.bin")
                              .node("Mul", {"x", "w"}, {"y"}));
  ASSERT_TRUE(model) << model.error().message();
  const auto y = (*model)->invoke({make_tensor<float>(WEIR_FLOAT32, {2}, {5, 7})});
  ASSERT_TRUE(y) << y.error().message();
  EXPECT_EQ((*y)[0].values<float>(), (std::vector<float>{15, -14}));
}

TEST_F(OnnxRuntime, ReportsItsThreadsToAnOlderHostAsFarAsItKnows) {
  const auto path = folder_.write("model.onnx", OnnxBuilder()
                                                    .input("x", kFloat, {"2"})
                                                    .output("y", kFloat, {"2"})
                                                    .node("Neg", {"x"}, {"y"})
                                                    .bytes());
  const char* const paths[] = {path.c_str()};
  weir_open request{};
  request.struct_size = sizeof request;
  request.n_models = 1;
  request.paths = paths;
  request.threads = 3;
  weir_model* model = nullptr;
  weir_error error;
  ASSERT_EQ(engine()->open(&request, &model, &error), 0) << error.error.message();
  const auto* calls = static_cast<const weir_execution_calls*>(engine()->extension(WEIR_EXECUTION));
  for (uint32_t size = 0; size <= sizeof(weir_execution); ++size) {
    weir_execution out{size, 77, 88};
    EXPECT_EQ(calls->describe(model, &out), 0);
    EXPECT_EQ(out.struct_size, size);
    EXPECT_EQ(out.threads, size >= offsetof(weir_execution, spins) ? 3u : 77u) << size;
    EXPECT_EQ(out.spins, size == sizeof out ? 0u : 88u) << size;
  }
  engine()->close(model);
}

TEST_F(OnnxRuntime, OpensAModelGivenAsBytes) {
  const auto bytes = OnnxBuilder()
                         .input("x", kFloat, {"2"})
                         .output("y", kFloat, {"2"})
                         .node("Neg", {"x"}, {"y"})
                         .bytes();
  weir_open request{};
  request.struct_size = sizeof request;
  request.bytes = bytes.data();
  request.n_bytes = bytes.size();
  weir_model* model = nullptr;
  weir_error error;
  ASSERT_EQ(engine()->open(&request, &model, &error), 0) << error.error.message();
  engine()->close(model);
}

}  // namespace onnxruntime_test
}  // namespace weir::engine_test
