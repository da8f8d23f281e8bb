// The TensorFlow Lite engine on models made here: types, shapes, memory, and what it refuses.
#include <gtest/gtest.h>

#include <algorithm>

#include "engine_test_host.hpp"
#include "tensorflow-lite/tflite_builder.hpp"

namespace weir::engine_test {
namespace {

const weir_engine* engine() {
  static const weir_engine* const loaded = load_module(WEIR_MODULE_FILE);
  return loaded;
}

class TensorflowLite : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_NE(engine(), nullptr);
    if (!engine()->extension("weir.library/1")) GTEST_SKIP() << "TensorFlow Lite is not installed";
    take_log();
  }
  std::unique_ptr<OpenEngine> opened(const std::vector<std::byte>& bytes,
                                     const OpenEngine::Options& options = {}) {
    auto model = OpenEngine::open(*engine(), folder_.write("model.tflite", bytes), options);
    if (!model) ADD_FAILURE() << model.error().message();
    return model ? *std::move(model) : nullptr;
  }
  Error error_of(const std::vector<std::byte>& bytes, const OpenEngine::Options& options = {}) {
    const auto model = OpenEngine::open(*engine(), folder_.write("model.tflite", bytes), options);
    return model ? Error{Code::INTERNAL, "it opened", "", "", "", ""} : model.error();
  }
  TemporaryFolder folder_;
};

#define EXPECT_SAYS(text, words) EXPECT_NE((text).find(words), std::string::npos) << (text)

const std::vector<float> kSix{1, -2, 3, -4, 5, -6};

TEST_F(TensorflowLite, NamesItself) {
  EXPECT_STREQ(engine()->name, "tensorflow-lite");
  const auto* library = static_cast<const char* const*>(engine()->extension("weir.library/1"));
  EXPECT_SAYS(std::string(library[0]), "libtensorflowlite_c.so");
  EXPECT_EQ(std::string(library[1]).substr(0, 2), "2.");
}

TEST_F(TensorflowLite, DescribesTheModel) {
  const auto model = opened(negation());
  ASSERT_NE(model, nullptr);
  EXPECT_EQ(text_of(model->inputs()[0]), "float32[2, 3]");
  EXPECT_STREQ(model->inputs()[0].name, "x");
  EXPECT_STREQ(model->outputs()[0].name, "y");
  EXPECT_SAYS(std::string(model->info().metadata_json), "made by a test");
}

TEST_F(TensorflowLite, Computes) {
  const auto model = opened(negation());
  ASSERT_NE(model, nullptr);
  const auto out = model->invoke({make_tensor<float>(WEIR_FLOAT32, {2, 3}, kSix)});
  ASSERT_TRUE(out) << out.error().message();
  EXPECT_EQ((*out)[0].values<float>(), (std::vector<float>{-1, 2, -3, 4, -5, 6}));
  EXPECT_EQ(model->engine_allocated(), 0u) << "the output was written into the caller's memory";
}

TEST_F(TensorflowLite, ComputesTheSameWithoutXnnpackAndWithThreads) {
  for (const auto& options : std::vector<OpenEngine::Options>{
           {{"Delegate", "None"}}, {{"Delegate", "XNNPACK"}, {"NumThreads", "2"}}}) {
    const auto model = opened(negation(), options);
    ASSERT_NE(model, nullptr);
    const auto out = model->invoke({make_tensor<float>(WEIR_FLOAT32, {2, 3}, kSix)});
    ASSERT_TRUE(out);
    EXPECT_EQ((*out)[0].values<float>(), (std::vector<float>{-1, 2, -3, 4, -5, 6}));
  }
}

TEST_F(TensorflowLite, PassesEveryElementType) {
  const std::pair<TfliteElement, uint32_t> types[] = {
      {kTfFloat32, WEIR_FLOAT32}, {kTfFloat16, WEIR_FLOAT16}, {kTfInt32, WEIR_INT32},
      {kTfUInt8, WEIR_UINT8},     {kTfInt64, WEIR_INT64},     {kTfInt16, WEIR_INT16},
      {kTfInt8, WEIR_INT8},       {kTfFloat64, WEIR_FLOAT64}, {kTfUInt64, WEIR_UINT64},
      {kTfUInt32, WEIR_UINT32}};
  for (const auto& [theirs, ours] : types) {
    SCOPED_TRACE(ours);
    const auto model = opened(reshaping(theirs));
    ASSERT_NE(model, nullptr);
    EXPECT_EQ(model->inputs()[0].type, ours);
    auto in = make_tensor(ours, {2, 3});
    for (size_t i = 0; i < in.bytes.size(); ++i) in.bytes[i] = static_cast<std::byte>(i + 1);
    const auto out = model->invoke({in});
    ASSERT_TRUE(out) << out.error().message();
    EXPECT_EQ((*out)[0].bytes, in.bytes);
    EXPECT_EQ(shape_of((*out)[0].info), (std::vector<int64_t>{3, 2}));
  }
}

TEST_F(TensorflowLite, TakesBytesForBooleans) {
  const auto model = opened(reshaping(kTfBool));
  ASSERT_NE(model, nullptr);
  EXPECT_EQ(model->inputs()[0].type, uint32_t{WEIR_UINT8});
  const auto out =
      model->invoke({make_tensor<uint8_t>(WEIR_UINT8, {2, 3}, {0, 1, 2, 255, 0, 128})});
  ASSERT_TRUE(out) << out.error().message();
  EXPECT_EQ((*out)[0].values<uint8_t>(), (std::vector<uint8_t>{0, 1, 1, 1, 0, 1}));
}

TEST_F(TensorflowLite, HasSeveralInputsAndOutputsInTheModelsOrder) {
  TfliteBuilder builder;
  const auto a = builder.tensor("a", kTfFloat32, {2}), b = builder.tensor("b", kTfFloat32, {2});
  const auto sum = builder.tensor("sum", kTfFloat32, {2}),
             minus = builder.tensor("minus", kTfFloat32, {2});
  builder.operation(kTfAdd, {a, b}, {sum}).operation(kTfNeg, {a}, {minus});
  const auto model = opened(builder.inputs({b, a}).outputs({minus, sum}).bytes());
  ASSERT_NE(model, nullptr);
  EXPECT_STREQ(model->inputs()[0].name, "b");
  EXPECT_STREQ(model->outputs()[1].name, "sum");
  const auto out = model->invoke({make_tensor<float>(WEIR_FLOAT32, {2}, {10, 20}),
                                  make_tensor<float>(WEIR_FLOAT32, {2}, {1, 2})});
  ASSERT_TRUE(out) << out.error().message();
  EXPECT_EQ((*out)[0].values<float>(), (std::vector<float>{-1, -2}));
  EXPECT_EQ((*out)[1].values<float>(), (std::vector<float>{11, 22}));
}

TEST_F(TensorflowLite, FollowsTheStreamWhereTheModelIsOpen) {
  const auto model = opened(negation({-1, 3}));
  ASSERT_NE(model, nullptr);
  EXPECT_EQ(text_of(model->inputs()[0]), "float32[-1, 3]");
  for (const int64_t rows : {4, 1, 7}) {
    const auto resolved = model->resolve({make_tensor(WEIR_FLOAT32, {rows, 3}).info});
    ASSERT_TRUE(resolved) << resolved.error().message();
    EXPECT_EQ(shape_of((*resolved)[0]), (std::vector<int64_t>{rows, 3}));
    const std::vector<float> values(static_cast<size_t>(rows) * 3, 2.5f);
    const auto out = model->invoke({make_tensor<float>(WEIR_FLOAT32, {rows, 3}, values)});
    ASSERT_TRUE(out) << out.error().message();
    EXPECT_EQ((*out)[0].values<float>(), std::vector<float>(values.size(), -2.5f));
  }
}

TEST_F(TensorflowLite, SaysHowNumbersAreQuantised) {
  TfliteBuilder builder;
  const auto x = builder.tensor("x", kTfUInt8, {2, 3}, 0.5f, 128);
  const auto y = builder.tensor("y", kTfUInt8, {3, 2}, 0.5f, 128),
             shape = builder.constant("s", {3, 2});
  const auto model =
      opened(builder.operation(kTfReshape, {x, shape}, {y}).inputs({x}).outputs({y}).bytes());
  ASSERT_NE(model, nullptr);
  EXPECT_EQ(model->inputs()[0].scale, 0.5f);
  EXPECT_EQ(model->inputs()[0].zero_point, 128);
}

// ---- refusals ---------------------------------------------------------------------------------

TEST_F(TensorflowLite, RefusesAModelThatIsNotThere) {
  const auto model = OpenEngine::open(*engine(), folder_.path("none.tflite"));
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().code, Code::MODEL_NOT_FOUND);
  EXPECT_SAYS(model.error().message(), "none.tflite");
}

TEST_F(TensorflowLite, RefusesWhatIsNoModel) {
  for (const std::string text : {"", "x", "not a model at all", "12345678TFL3"}) {
    const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
    const Error error = error_of({bytes, bytes + text.size()});
    EXPECT_EQ(error.code, Code::MODEL_INVALID) << text;
    EXPECT_SAYS(error.message(), "model.tflite");
  }
}

TEST_F(TensorflowLite, RefusesAModelCutAnywhere) {
  const auto whole = reshaping(kTfFloat32);
  for (size_t size = 0; size + 4 < whole.size(); ++size)
    EXPECT_EQ(error_of({whole.begin(), whole.begin() + static_cast<ptrdiff_t>(size)}).code,
              Code::MODEL_INVALID)
        << size;
}

// Whatever a changed byte makes of the model, nothing crashes: it is refused, or it runs.
TEST_F(TensorflowLite, SurvivesEachChangedByte) {
  const auto whole = reshaping(kTfFloat32);
  size_t refused = 0;
  for (size_t at = 0; at < whole.size(); ++at)
    for (const uint8_t change : {0x01, 0x80, 0xFF}) {
      auto bytes = whole;
      bytes[at] ^= static_cast<std::byte>(change);
      const auto model = OpenEngine::open(*engine(), folder_.write("model.tflite", bytes));
      if (!model) {
        ++refused;
        EXPECT_FALSE(model.error().what.empty());
        continue;
      }
      const auto inputs = zero_inputs(**model);
      const auto ignored = (*model)->invoke(inputs);
      (void)ignored;
    }
  EXPECT_GT(refused, whole.size() / 4);
}

TEST_F(TensorflowLite, RefusesOperatorsThatItLacks) {
  TfliteBuilder builder;
  const auto x = builder.tensor("x", kTfFloat32, {2}), y = builder.tensor("y", kTfFloat32, {2});
  const Error error = error_of(
      builder.operation(kTfCustom, {x}, {y}, "MyOperator").inputs({x}).outputs({y}).bytes());
  EXPECT_EQ(error.code, Code::MODEL_UNSUPPORTED) << error.message();
  EXPECT_SAYS(error.message(), "MyOperator");
}

TEST_F(TensorflowLite, RefusesStrings) {
  const Error error = error_of(reshaping(kTfString));
  EXPECT_TRUE(error.code == Code::MODEL_UNSUPPORTED || error.code == Code::MODEL_INVALID)
      << error.message();
}

TEST_F(TensorflowLite, RefusesInputsThatDoNotFit) {
  const auto model = opened(negation());
  ASSERT_NE(model, nullptr);
  const auto wrong_type = model->invoke({make_tensor(WEIR_UINT8, {2, 3})});
  ASSERT_FALSE(wrong_type);
  EXPECT_EQ(wrong_type.error().code, Code::SPEC_MISMATCH);
  EXPECT_SAYS(wrong_type.error().message(), "uint8");
  const auto wrong_rank = model->invoke({make_tensor(WEIR_FLOAT32, {2, 3, 1})});
  ASSERT_FALSE(wrong_rank);
  EXPECT_EQ(wrong_rank.error().code, Code::SPEC_MISMATCH);
  const auto wrong_count = model->invoke({});
  ASSERT_FALSE(wrong_count);
  EXPECT_SAYS(wrong_count.error().message(), "input");
}

TEST_F(TensorflowLite, RefusesThreadsThatAreNoNumber) {
  for (const char* value : {"0", "-1", "two", ""}) {
    const Error error = error_of(negation(), {{"NumThreads", value}});
    EXPECT_EQ(error.code, Code::OPTION_VALUE) << value;
    EXPECT_SAYS(error.message(), "NumThreads");
  }
}

TEST_F(TensorflowLite, LogsOptionsThatItDoesNotKnow) {
  ASSERT_NE(opened(negation(), {{"NumTreads", "1"}, {"Delegate", "GPU"}}), nullptr);
  const auto lines = take_log();
  const auto says = [&](const char* words) {
    return std::any_of(lines.begin(), lines.end(),
                       [&](const auto& line) { return line.find(words) != std::string::npos; });
  };
  EXPECT_TRUE(says("NumTreads"));
  EXPECT_TRUE(says("GPU"));
}

}  // namespace
}  // namespace weir::engine_test
