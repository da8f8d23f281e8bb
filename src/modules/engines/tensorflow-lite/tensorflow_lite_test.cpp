// Tests of TensorFlow Lite through the C table: types, shapes, memory, options.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <nlohmann/json.hpp>

#include "engine_contract_test_support.hpp"
#include "says.hpp"
#include "tensorflow-lite/tflite_builder_test_support.hpp"
#include "usable_cores.hpp"

namespace weir::engine_test {
namespace tensorflow_lite_test {

class TensorflowLite : public EngineTest {
 protected:
  Result<std::unique_ptr<OpenEngine>> open(const TfliteBuilder& model, const Options& options = {},
                                           int threads = 0) {
    return EngineTest::open(model.bytes(), options, threads);
  }
};

struct TypeCase {
  int8_t tflite;
  uint32_t weir;
};
class TensorflowLiteTypes : public TensorflowLite,
                            public ::testing::WithParamInterface<TypeCase> {};

TEST_P(TensorflowLiteTypes, PassThroughUnchanged) {
  auto model = open(TfliteBuilder()
                        .input("x", GetParam().tflite, {2, 3})
                        .constant<int32_t>("shape", kTfInt32, {2}, {3, 2})
                        .output("y", GetParam().tflite, {3, 2})
                        .node(kOpReshape, {"x", "shape"}, {"y"}));
  ASSERT_TRUE(model) << model.error().message();
  auto x = make_tensor(GetParam().weir, {2, 3});
  for (size_t i = 0; i < x.bytes.size(); ++i) x.bytes[i] = std::byte(i % 2);  // valid as bool too
  const auto y = (*model)->invoke({x});
  ASSERT_TRUE(y) << y.error().message();
  EXPECT_EQ((*y)[0].info.type, GetParam().weir);
  EXPECT_EQ(to_shape((*y)[0].info), (std::vector<int64_t>{3, 2}));
  EXPECT_EQ((*y)[0].bytes, x.bytes);
}
INSTANTIATE_TEST_SUITE_P(
    All, TensorflowLiteTypes,
    ::testing::Values(TypeCase{kTfFloat, WEIR_FLOAT32}, TypeCase{kTfUint8, WEIR_UINT8},
                      TypeCase{kTfInt8, WEIR_INT8}, TypeCase{kTfInt16, WEIR_INT16},
                      TypeCase{kTfInt32, WEIR_INT32}, TypeCase{kTfInt64, WEIR_INT64},
                      TypeCase{kTfBool, WEIR_UINT8}, TypeCase{kTfFloat16, WEIR_FLOAT16},
                      TypeCase{kTfDouble, WEIR_FLOAT64}, TypeCase{kTfUint32, WEIR_UINT32},
                      TypeCase{kTfUint64, WEIR_UINT64}));

TEST_F(TensorflowLite, AnyByteButZeroIsTrue) {
  auto model = open(TfliteBuilder()
                        .input("x", kTfBool, {4})
                        .output("y", kTfBool, {4})
                        .node(kOpLogicalNot, {"x"}, {"y"}));
  ASSERT_TRUE(model) << model.error().message();
  const auto y = (*model)->invoke({make_tensor<uint8_t>(WEIR_UINT8, {4}, {0, 1, 2, 255})});
  ASSERT_TRUE(y) << y.error().message();
  EXPECT_EQ((*y)[0].values<uint8_t>(), (std::vector<uint8_t>{1, 0, 0, 0}));
}

TEST_F(TensorflowLite, HalfFloatsKeepTheirBits) {
  auto model = open(TfliteBuilder()
                        .input("x", kTfFloat16, {3})
                        .output("y", kTfFloat, {3})
                        .node(kOpDequantize, {"x"}, {"y"}));
  ASSERT_TRUE(model) << model.error().message();
  const auto y =
      (*model)->invoke({make_tensor<uint16_t>(WEIR_FLOAT16, {3}, {0x3C00, 0xC100, 0x7BFF})});
  ASSERT_TRUE(y) << y.error().message();
  EXPECT_EQ((*y)[0].values<float>(), (std::vector<float>{1.0f, -2.5f, 65504.0f}));
}

// real = scale * (q - zero point): (q - 2) / 2, twice, summed, requantised in steps of 1 from -10.
TEST_F(TensorflowLite, QuantisedTensorsReportScaleAndZeroPointAndStayQuantised) {
  auto model = open(TfliteBuilder()
                        .input("x", kTfInt8, {4})
                        .quantized({{0.5f}, {2}})
                        .output("y", kTfInt8, {4})
                        .quantized({{1.0f}, {-10}})
                        .node(kOpAdd, {"x", "x"}, {"y"}));
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_FLOAT_EQ((*model)->inputs()[0].scale, 0.5f);
  EXPECT_EQ((*model)->inputs()[0].zero_point, 2);
  EXPECT_FLOAT_EQ((*model)->outputs()[0].scale, 1.0f);
  EXPECT_EQ((*model)->outputs()[0].zero_point, -10);
  const auto y = (*model)->invoke({make_tensor<int8_t>(WEIR_INT8, {4}, {2, 12, -8, 127})});
  ASSERT_TRUE(y) << y.error().message();
  EXPECT_EQ((*y)[0].values<int8_t>(), (std::vector<int8_t>{-10, 0, -20, 115}));
}

TEST_F(TensorflowLite, Uint8CanBeQuantised) {
  auto model = open(TfliteBuilder()
                        .input("x", kTfUint8, {3})
                        .quantized({{0.25f}, {128}})
                        .output("y", kTfFloat, {3})
                        .node(kOpDequantize, {"x"}, {"y"}));
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ((*model)->inputs()[0].zero_point, 128);
  const auto y = (*model)->invoke({make_tensor<uint8_t>(WEIR_UINT8, {3}, {0, 128, 255})});
  ASSERT_TRUE(y) << y.error().message();
  EXPECT_EQ((*y)[0].values<float>(), (std::vector<float>{-32, 0, 31.75}));
}

TEST_F(TensorflowLite, ScalarsHaveRankZero) {
  auto model = open(TfliteBuilder()
                        .input("x", kTfFloat, {})
                        .input("v", kTfFloat, {2})
                        .output("y", kTfFloat, {2})
                        .output("s", kTfFloat, {})
                        .node(kOpAdd, {"x", "v"}, {"y"})
                        .node(kOpAdd, {"x", "x"}, {"s"}));
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ((*model)->inputs()[0].rank, 0u);
  EXPECT_EQ((*model)->outputs()[1].rank, 0u);
  const auto out = (*model)->invoke(
      {make_tensor<float>(WEIR_FLOAT32, {}, {40}), make_tensor<float>(WEIR_FLOAT32, {2}, {2, -2})});
  ASSERT_TRUE(out) << out.error().message();
  EXPECT_EQ((*out)[0].values<float>(), (std::vector<float>{42, 38}));
  EXPECT_EQ((*out)[1].values<float>(), (std::vector<float>{80}));
}

TEST_F(TensorflowLite, InputsAndOutputsKeepTheModelsOrderAndNames) {
  auto model = open(TfliteBuilder()
                        .input("b", kTfFloat, {1})
                        .input("a", kTfFloat, {1})
                        .output("difference", kTfFloat, {1})
                        .output("a sum", kTfFloat, {1})
                        .node(kOpSub, {"b", "a"}, {"difference"})
                        .node(kOpAdd, {"b", "a"}, {"a sum"}));
  ASSERT_TRUE(model) << model.error().message();
  expect_order_and_names(**model);
}

TEST_F(TensorflowLite, OpenDimensionsAreMinusOneAndFollowTheStream) {
  auto model = open(tflite_negation({-1, 3}));
  ASSERT_TRUE(model) << model.error().message();
  expect_rows_of_the_stream(**model);
}

TEST_F(TensorflowLite, AFixedShapeIsResizedAndBackAgain) {
  auto model = open(tflite_negation({2, 3}));
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ(to_string((*model)->inputs()[0]), "float32[2, 3]");
  EXPECT_EQ((*model)->inputs()[0].batch_axis, WEIR_NO_BATCH_AXIS);
  for (const int64_t rows : {2, 5, 1, 2, 300}) {
    const std::vector<float> x(static_cast<size_t>(rows) * 3, static_cast<float>(rows));
    const auto y = (*model)->invoke({make_tensor<float>(WEIR_FLOAT32, {rows, 3}, x)});
    ASSERT_TRUE(y) << y.error().message();
    EXPECT_EQ(to_shape((*y)[0].info), (std::vector<int64_t>{rows, 3}));
    EXPECT_EQ((*y)[0].values<float>(), std::vector<float>(x.size(), -static_cast<float>(rows)));
  }
}

TEST_F(TensorflowLite, AFixedShapeIsOpenIfTheUserRequestsIt) {
  auto model = EngineTest::open(tflite_negation({2, 3}).bytes(), {{"resize", "true"}});
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ(to_string((*model)->inputs()[0]), "float32[-1, -1]");
  const auto shapes = (*model)->resolve({make_tensor(WEIR_FLOAT32, {4, 5}).info});
  ASSERT_TRUE(shapes) << shapes.error().message();
  EXPECT_EQ(to_string((*shapes)[0]), "float32[4, 5]");
  EXPECT_FALSE((*model)->resolve({make_tensor(WEIR_FLOAT32, {4}).info})) << "the rank stays";
  const auto refused = EngineTest::open(tflite_negation({2, 3}).bytes(), {{"Resize", "perhaps"}});
  ASSERT_FALSE(refused);
  EXPECT_SAYS(refused.error().message(), "true, false or rank");
}

TEST_F(TensorflowLite, TheRankIsOpenTooIfTheUserRequestsIt) {
  auto model = EngineTest::open(tflite_negation({2, 3}).bytes(), {{"Resize", "rank"}});
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ((*model)->inputs()[0].rank, WEIR_RANK_UNKNOWN);
  EXPECT_EQ((*model)->inputs()[0].batch_axis, WEIR_NO_BATCH_AXIS);
  for (const auto& shape : {std::vector<int64_t>{4}, {2, 3}, {2, 1, 3, 2}}) {
    const auto shapes = (*model)->resolve({make_tensor(WEIR_FLOAT32, shape).info});
    ASSERT_TRUE(shapes) << shapes.error().message();
    EXPECT_EQ(to_shape((*shapes)[0]), shape);
  }
  EXPECT_FALSE((*model)->resolve({make_tensor(WEIR_INT32, {2, 3}).info})) << "the type stays";
}

// A rejected shape leaves the session unchanged.
TEST_F(TensorflowLite, ContinuesAfterAShapeThatItsLayersReject) {
  auto model = open(TfliteBuilder()
                        .input("x", kTfFloat, {2, 3})
                        .constant<float>("c", kTfFloat, {3}, {1, 2, 3})
                        .output("y", kTfFloat, {2, 3})
                        .node(kOpAdd, {"x", "c"}, {"y"}));
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_FALSE((*model)->invoke({make_tensor(WEIR_FLOAT32, {2, 4})}));
  const auto y = (*model)->invoke({make_tensor(WEIR_FLOAT32, {2, 3})});
  ASSERT_TRUE(y) << y.error().message();
  EXPECT_EQ((*y)[0].values<float>(), (std::vector<float>{1, 2, 3, 1, 2, 3}));
}

TEST_F(TensorflowLite, ShapesThatDependOnDataStayOpenAndAreAllocatedByTheEngine) {
  auto model = open(TfliteBuilder()
                        .input("x", kTfBool, {4})
                        .output("y", kTfInt64, {1, 1})
                        .node(kOpWhere, {"x"}, {"y"}));
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_NE((*model)->info().flags & WEIR_MODEL_DYNAMIC_OUTPUT, 0u);
  for (const auto& [x, expected] :
       std::vector<std::pair<std::vector<uint8_t>, std::vector<int64_t>>>{
           {{0, 1, 0, 1}, {1, 3}}, {{0, 0, 0, 0}, {}}, {{1, 1, 1, 1}, {0, 1, 2, 3}}}) {
    const auto y = (*model)->invoke({make_tensor<uint8_t>(WEIR_UINT8, {4}, x)});
    ASSERT_TRUE(y) << y.error().message();
    EXPECT_EQ((*model)->engine_allocated(), 1u);
    EXPECT_EQ((*y)[0].values<int64_t>(), expected);
    EXPECT_EQ(to_shape((*y)[0].info), (std::vector<int64_t>{int64_t(expected.size()), 1}));
  }
}

TEST_F(TensorflowLite, WritesIntoTheCallersMemory) {
  auto model = open(tflite_negation({1024}));
  ASSERT_TRUE(model) << model.error().message();
  const auto x = make_tensor<float>(WEIR_FLOAT32, {1024}, std::vector<float>(1024, 3));
  const auto y = (*model)->invoke({x});
  ASSERT_TRUE(y) << y.error().message();
  EXPECT_EQ((*model)->engine_allocated(), 0u);
  EXPECT_EQ((*y)[0].values<float>(), std::vector<float>(1024, -3));
  EXPECT_EQ(x.values<float>(), std::vector<float>(1024, 3));
}

TEST_F(TensorflowLite, MemoryOfAnOutputOutlivesModelAndSession) {
  float x[] = {0, 7, 0, 0};
  OneToOne frames({4}, x);
  {
    auto model = open(tflite_negation({4}));
    ASSERT_TRUE(model) << model.error().message();
    const auto status = frames.through(**model);
    ASSERT_TRUE(status) << status.error().message();
  }
  const weir_tensor& out = frames.out;
  ASSERT_NE(out.release, nullptr);
  EXPECT_EQ(static_cast<float*>(out.data)[1], -7);
  EXPECT_EQ(out.bytes, sizeof x);
  out.release(out.owner);
}

TEST_F(TensorflowLite, WarmRunsWithoutAFrame) {
  auto model = open(tflite_negation({2}));
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ((*model)->info().flags & WEIR_MODEL_STATEFUL, 0u);
  for (const int op : {WEIR_WARM, WEIR_RESUME, WEIR_RESET_STATE})
    EXPECT_TRUE((*model)->control(op)) << op;
  const auto suspended = (*model)->control(WEIR_SUSPEND);
  ASSERT_FALSE(suspended) << "nothing to free: the host closes the model";
  EXPECT_EQ(suspended.error().what, "TensorFlow Lite cannot free the memory of an open model");
  const auto option = (*model)->control(WEIR_SET_OPTION);
  ASSERT_FALSE(option);
  EXPECT_EQ(option.error().what, "TensorFlow Lite accepts options only when a model is opened");
  EXPECT_EQ(option.error().needed, "custom= at the start");
}

// Each interpreter with XNNPACK has its own packed weights.
TEST_F(TensorflowLite, OneSessionHoldsThePackedWeights) {
  for (const auto& [delegate, max] : {std::pair{"XNNPACK", 1u}, {"None", 0u}}) {
    auto model = EngineTest::open(tflite_negation({2}).bytes(), {{"Delegate", delegate}});
    ASSERT_TRUE(model) << model.error().message();
    EXPECT_EQ((*model)->info().max_sessions, max) << delegate;
  }
}

TEST_F(TensorflowLite, ReportsTheOriginOfTheModel) {
  auto model = open(tflite_negation().description("made by \xFF hand"));
  ASSERT_TRUE(model) << model.error().message();
  const auto json = nlohmann::json::parse((*model)->info().metadata_json);
  EXPECT_SAYS(json["description"].get<std::string>(), "hand");
  EXPECT_EQ(json["operators"], 1);
  EXPECT_EQ(json["xnnpack"], true);
}

TEST_F(TensorflowLite, RunsEquallyWithAndWithoutTheDelegate) {
  for (const auto& [delegate, used] :
       std::vector<std::pair<std::string, bool>>{{"XNNPACK", true}, {"none", false}}) {
    auto model = open(tflite_negation({3}), {{"delegate", delegate}});
    ASSERT_TRUE(model) << model.error().message();
    EXPECT_EQ(nlohmann::json::parse((*model)->info().metadata_json)["xnnpack"], used);
    const auto y = (*model)->invoke({make_tensor<float>(WEIR_FLOAT32, {3}, {1, -2, 0.5})});
    ASSERT_TRUE(y) << y.error().message();
    EXPECT_EQ((*y)[0].values<float>(), (std::vector<float>{-1, 2, -0.5}));
  }
  EXPECT_TRUE(take_log().empty());
}

TEST_F(TensorflowLite, UsesThreadsOfTheOptionAndOfTheHost) {
  for (const auto* threads : {"1", "2", "999"}) {  // never more than the number of cores
    auto model = open(tflite_negation({4}), {{"numthreads", threads}});
    ASSERT_TRUE(model) << model.error().message();
    EXPECT_EQ((*model)->execution().threads,
              static_cast<uint32_t>(std::min(std::atoi(threads), usable_cores())));
    EXPECT_TRUE((*model)->invoke({make_tensor(WEIR_FLOAT32, {4})}));
  }
  const auto small = open(tflite_negation({4}));
  ASSERT_TRUE(small) << small.error().message();
  EXPECT_EQ((*small)->execution().threads, 1u);
  EXPECT_TRUE(open(tflite_negation({4}), {}, 2));
  EXPECT_TRUE(take_log().empty());
}

TEST_F(TensorflowLite, WarnsAboutUnknownOptions) {
  EXPECT_TRUE(open(tflite_negation(), {{"NumThread", "2"}}));
  auto log = take_log();
  ASSERT_EQ(log.size(), 1u);
  EXPECT_SAYS(log[0], "NumThread is unknown");
  EXPECT_SAYS(log[0], "NumThreads, Delegate");
  EXPECT_TRUE(open(tflite_negation(), {{"Delegate", "GPU"}}));
  log = take_log();
  ASSERT_EQ(log.size(), 1u);
  EXPECT_SAYS(log[0], "delegate GPU is not available");
}

TEST_F(TensorflowLite, OpensAModelFromTemporaryBytes) {
  auto bytes = tflite_negation({2}).bytes();
  weir_open request{};
  request.struct_size = sizeof request;
  request.bytes = bytes.data();
  request.n_bytes = bytes.size();
  weir_model* model = nullptr;
  weir_error error;
  ASSERT_EQ(engine()->open(&request, &model, &error), 0) << error.error.message();
  std::fill(bytes.begin(), bytes.end(), std::byte{0xFF});
  weir_session* session = nullptr;
  ASSERT_EQ(engine()->session_new(model, nullptr, 0, &session, &error), 0) << error.error.message();
  engine()->session_free(session);
  engine()->close(model);
}

}  // namespace tensorflow_lite_test
}  // namespace weir::engine_test
