// Tests of what the TensorFlow Lite engine rejects, of the error texts, and that damage never
// crashes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>

#include "engine_test_support.hpp"
#include "says.hpp"
#include "tensorflow-lite/tflite_builder_test_support.hpp"

namespace weir::engine_test {
namespace tensorflow_lite_refusals_test {

// y = x with another shape.
std::vector<std::byte> reshaping(int8_t type) {
  return TfliteBuilder()
      .input("x", type, {2, 3})
      .constant<int32_t>("shape", kTfInt32, {2}, {3, 2})
      .output("y", type, {3, 2})
      .node(kOpReshape, {"x", "shape"}, {"y"})
      .bytes();
}

class TensorflowLiteRejects : public EngineTest {};

TEST_F(TensorflowLiteRejects, AModelThatDoesNotExist) {
  const auto model = OpenEngine::open(*engine(), folder_.path("none.tflite"));
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().code, Code::MODEL_NOT_FOUND);
  EXPECT_SAYS(model.error().message(), "none.tflite");
}

TEST_F(TensorflowLiteRejects, FilesThatAreNotAModel) {
  for (const std::string text : {"", "x", "not a model at all", "12345678TFL3"}) {
    const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
    const Error error = get_error({bytes, bytes + text.size()});
    EXPECT_EQ(error.code, Code::MODEL_INVALID) << text;
    EXPECT_SAYS(error.message(), "model.bin");
  }
}

TEST_F(TensorflowLiteRejects, ATruncatedModel) {
  const auto whole = reshaping(kTfFloat);
  for (size_t size = 0; size + 4 < whole.size(); ++size)
    EXPECT_EQ(get_error({whole.begin(), whole.begin() + static_cast<ptrdiff_t>(size)}).code,
              Code::MODEL_INVALID)
        << size;
}

// A changed byte never causes a crash: the model is rejected, or it runs.
TEST_F(TensorflowLiteRejects, HandlesEachChangedByte) {
  const auto whole = reshaping(kTfFloat);
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

TEST_F(TensorflowLiteRejects, OperatorsThatItLacks) {
  const Error error = get_error(TfliteBuilder()
                                    .input("x", kTfFloat, {2})
                                    .output("y", kTfFloat, {2})
                                    .node(kOpCustom, {"x"}, {"y"}, "MyOperator")
                                    .bytes());
  EXPECT_EQ(error.code, Code::MODEL_UNSUPPORTED) << error.message();
  EXPECT_SAYS(error.message(), "MyOperator");
}

TEST_F(TensorflowLiteRejects, Strings) {
  const Error error = get_error(reshaping(kTfString));
  EXPECT_TRUE(error.code == Code::MODEL_UNSUPPORTED || error.code == Code::MODEL_INVALID)
      << error.message();
}

TEST_F(TensorflowLiteRejects, InputsThatDoNotFit) {
  const auto model = opened(tflite_negation().bytes());
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

TEST_F(TensorflowLiteRejects, ThreadsThatAreNotANumber) {
  for (const char* value : {"0", "-1", "two", ""}) {
    const Error error = get_error(tflite_negation().bytes(), {{"NumThreads", value}});
    EXPECT_EQ(error.code, Code::OPTION_VALUE) << value;
    EXPECT_SAYS(error.message(), "NumThreads");
  }
}

TEST_F(TensorflowLiteRejects, LogsUnknownOptions) {
  ASSERT_NE(opened(tflite_negation().bytes(), {{"NumTreads", "1"}, {"Delegate", "GPU"}}), nullptr);
  const auto lines = take_log();
  const auto says = [&](const char* words) {
    return std::any_of(lines.begin(), lines.end(),
                       [&](const auto& line) { return line.find(words) != std::string::npos; });
  };
  EXPECT_TRUE(says("NumTreads"));
  EXPECT_TRUE(says("GPU"));
}

}  // namespace tensorflow_lite_refusals_test
}  // namespace weir::engine_test
