// Tests of what the ONNX Runtime engine rejects, and of the error texts.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdlib>
#include <filesystem>

#include "engine_test_support.hpp"
#include "onnxruntime/onnx_builder_test_support.hpp"
#include "says.hpp"

namespace weir::engine_test {
namespace onnxruntime_refusals_test {

OnnxBuilder negation(const std::vector<std::string>& shape = {"2", "3"}) {
  return OnnxBuilder()
      .input("x", kFloat, shape)
      .output("y", kFloat, shape)
      .node("Neg", {"x"}, {"y"});
}

class OnnxRuntimeRejects : public EngineTest {
 protected:
  std::unique_ptr<OpenEngine> opened(const OnnxBuilder& model) {
    return EngineTest::opened(model.bytes());
  }
};

TEST_F(OnnxRuntimeRejects, AModelThatDoesNotExist) {
  const auto model = OpenEngine::open(*engine(), folder_.path("none.onnx"));
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().code, Code::MODEL_NOT_FOUND);
  EXPECT_SAYS(model.error().offered, "none.onnx");
}

TEST_F(OnnxRuntimeRejects, AFolder) {
  const auto model = OpenEngine::open(*engine(), folder_.path(""));
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().code, Code::MODEL_NOT_FOUND);
}

TEST_F(OnnxRuntimeRejects, AnEmptyFile) {
  EXPECT_EQ(get_error({}).code, Code::MODEL_INVALID);
}

TEST_F(OnnxRuntimeRejects, ATruncatedModel) {
  const auto whole = negation().bytes();
  for (size_t size = 1; size < whole.size(); ++size) {
    const Error error = get_error({whole.begin(), whole.begin() + static_cast<ptrdiff_t>(size)});
    // A file cut between two fields is well-formed but incomplete.
    EXPECT_TRUE(error.code == Code::MODEL_INVALID || error.code == Code::MODEL_UNSUPPORTED)
        << size << ": " << error.message();
  }
}

TEST_F(OnnxRuntimeRejects, ATruncatedRealModel) {
  const auto path = shared_file("models/classification/mnist.onnx");
  if (path.empty()) GTEST_SKIP() << "../shared/models/classification/mnist.onnx is not there";
  const auto whole = read_bytes(path);
  for (const size_t size : {whole.size() - 1, whole.size() / 2, whole.size() / 10, size_t{100}}) {
    const Error error = get_error({whole.begin(), whole.begin() + static_cast<ptrdiff_t>(size)});
    EXPECT_EQ(error.code, Code::MODEL_INVALID) << size << ": " << error.message();
  }
}

TEST_F(OnnxRuntimeRejects, FilesThatAreNotAModel) {
  std::vector<std::byte> noise(4096);
  uint32_t state = 1;
  for (auto& byte : noise) byte = std::byte((state = state * 1664525 + 1013904223) >> 24);
  EXPECT_EQ(get_error(noise).code, Code::MODEL_INVALID);
  EXPECT_EQ(get_error(std::vector<std::byte>(4096)).code, Code::MODEL_INVALID);
  const Error error = get_error({std::byte('P'), std::byte('N'), std::byte('G')});
  EXPECT_EQ(error.code, Code::MODEL_INVALID);
  EXPECT_SAYS(error.message(), "not an ONNX model");
}

TEST_F(OnnxRuntimeRejects, AnUnknownOperatorByItsName) {
  const Error error = get_error(OnnxBuilder()
                                    .input("x", kFloat, {"2"})
                                    .output("y", kFloat, {"2"})
                                    .node("Frobnicate", {"x"}, {"y"}, "com.example")
                                    .also_uses("com.example")
                                    .bytes());
  EXPECT_EQ(error.code, Code::MODEL_UNSUPPORTED) << error.message();
  EXPECT_SAYS(error.message(), "Frobnicate");
}

TEST_F(OnnxRuntimeRejects, AnOperatorWithoutAKernelForItsType) {
  const Error error = get_error(OnnxBuilder()
                                    .input("x", kUint64, {"2"})
                                    .output("y", kUint64, {"2"})
                                    .node("Relu", {"x"}, {"y"})
                                    .bytes());
  EXPECT_TRUE(error.code == Code::MODEL_UNSUPPORTED || error.code == Code::MODEL_INVALID);
  EXPECT_SAYS(error.message(), "Relu");
}

TEST_F(OnnxRuntimeRejects, TensorsOfText) {
  const Error error = get_error(OnnxBuilder()
                                    .input("words", kString, {"2"})
                                    .output("y", kString, {"2"})
                                    .node("Identity", {"words"}, {"y"})
                                    .bytes());
  EXPECT_EQ(error.code, Code::MODEL_UNSUPPORTED);
  EXPECT_SAYS(error.message(), "words");
  EXPECT_SAYS(error.message(), "string");
}

TEST_F(OnnxRuntimeRejects, Sequences) {
  const Error error = get_error(OnnxBuilder()
                                    .input("x", kFloat, {"2"})
                                    .sequence_output("y", kFloat)
                                    .node("SequenceConstruct", {"x"}, {"y"})
                                    .bytes());
  EXPECT_EQ(error.code, Code::MODEL_UNSUPPORTED) << error.message();
}

TEST_F(OnnxRuntimeRejects, InvalidOptionValues) {
  for (const auto& [key, value] : OpenEngine::Options{{"NumThreads", "0"},
                                                      {"NumThreads", "many"},
                                                      {"NumThreads", "2x"},
                                                      {"GraphOptimization", "most"},
                                                      {"Spinning", "maybe"}}) {
    const Error error = get_error(negation().bytes(), {{key, value}});
    EXPECT_EQ(error.code, Code::OPTION_VALUE) << key << value;
    EXPECT_SAYS(error.offered, value);
    EXPECT_FALSE(error.fix.empty());
  }
}

// x[n] -> y[m]: only a run shows that m equals n.
TEST_F(OnnxRuntimeRejects, ADryRunAboveTheLimitForAnyCaps) {
  const auto model = opened(OnnxBuilder()
                                .input("x", kFloat, {"n"})
                                .output("y", kFloat, {"m"})
                                .node("Relu", {"x"}, {"y"}));
  ASSERT_NE(model, nullptr);
  const auto small = model->resolve({make_tensor(WEIR_FLOAT32, {7}).info});
  ASSERT_TRUE(small) << small.error().message();
  EXPECT_EQ(to_string((*small)[0]), "float32[7]");
  weir_tensor_info huge = make_tensor(WEIR_FLOAT32, {1}).info;
  huge.shape[0] = int64_t{1} << 40;
  const uint64_t before = peak_resident_bytes();
  take_log();
  const auto open = model->resolve({huge});
  ASSERT_TRUE(open) << open.error().message();
  EXPECT_EQ(to_string((*open)[0]), "float32[-1]") << "the first frame decides";
  const auto lines = take_log();
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_SAYS(lines[0], "the inputs are too large for a dry run");
  EXPECT_TRUE(model->control(WEIR_WARM));
  EXPECT_LT(peak_resident_bytes(), before + (uint64_t{1} << 28));
}

TEST_F(OnnxRuntimeRejects, ALargeFileOfADifferentFormatWithoutReadingIt) {
  const auto path = folder_.write("zeros.onnx", {std::byte{0}});
  std::filesystem::resize_file(path, (uint64_t{1} << 31) - 1);
  const uint64_t before = peak_resident_bytes();
  const auto model = OpenEngine::open(*engine(), path);
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().code, Code::MODEL_INVALID);
  EXPECT_SAYS(model.error().message(), "zeros.onnx: the file is not a sequence of ONNX fields");
  EXPECT_LT(peak_resident_bytes(), before + (uint64_t{1} << 28));
}

TEST_F(OnnxRuntimeRejects, InputsThatDoNotFit) {
  const auto model = opened(negation());
  ASSERT_NE(model, nullptr);
  const auto code = [&](const std::vector<TestTensor>& inputs) {
    const auto out = model->invoke(inputs);
    return out ? Code::INTERNAL : out.error().code;
  };
  EXPECT_EQ(code({}), Code::SPEC_MISMATCH);
  EXPECT_EQ(code({make_tensor(WEIR_FLOAT32, {2, 3}), make_tensor(WEIR_FLOAT32, {2, 3})}),
            Code::SPEC_MISMATCH);
  EXPECT_EQ(code({make_tensor(WEIR_FLOAT32, {2, 4})}), Code::SPEC_MISMATCH);
  EXPECT_EQ(code({make_tensor(WEIR_FLOAT32, {6})}), Code::SPEC_MISMATCH);
  EXPECT_EQ(code({make_tensor(WEIR_INT32, {2, 3})}), Code::SPEC_MISMATCH);
  const auto out = model->resolve({make_tensor(WEIR_FLOAT32, {2, 4}).info});
  ASSERT_FALSE(out);
  EXPECT_SAYS(out.error().offered, "float32 4:2") << out.error().message();
  EXPECT_SAYS(out.error().difference, "dimension 1 is 4 instead of 3") << out.error().message();
  EXPECT_SAYS(out.error().needed, "float32 3:2 (x)");
}

TEST_F(OnnxRuntimeRejects, InconsistentFrames) {
  const auto model = opened(negation());
  ASSERT_NE(model, nullptr);
  std::vector<float> x(6), y(6);
  OneToOne frames({2, 3}, x, {2, 3}, y);
  weir_tensor &in = frames.in, &out = frames.out;
  ASSERT_TRUE(frames.through(*model));
  const auto code = [&] { return frames.get_code(*model); };
  in.bytes = 20;
  EXPECT_EQ(code(), Code::FRAME_SIZE);
  in.bytes = 24;
  out.bytes = 28;
  EXPECT_EQ(code(), Code::FRAME_SIZE);
  out.bytes = 24;
  in.data = nullptr;
  EXPECT_EQ(code(), Code::FRAME_SIZE);
  in.data = x.data();
  in.memory_kind = WEIR_MEMORY_DMABUF;
  EXPECT_EQ(code(), Code::FORMAT_UNSUPPORTED);
  in.memory_kind = WEIR_MEMORY_HOST;
  in.stride[0] = 16;
  in.stride[1] = 4;
  EXPECT_EQ(code(), Code::FORMAT_UNSUPPORTED);
  in.stride[0] = 12;
  EXPECT_EQ(code(), Code::INTERNAL);  // no error: dense strides are the same as none
  in.info.shape[0] = -1;
  EXPECT_EQ(code(), Code::FRAME_SIZE);
  in.info.shape[0] = INT64_MAX;
  EXPECT_EQ(code(), Code::SPEC_MISMATCH);
  in.info.rank = 17;
  EXPECT_EQ(code(), Code::SPEC_MISMATCH);
}

// The first frame shows that the assumed shape is wrong: an error, not a write past the end.
TEST_F(OnnxRuntimeRejects, OutputMemoryOfADifferentShape) {
  const auto model = opened(
      OnnxBuilder().input("x", kFloat, {"n"}).output("y", kFloat, {"m"}).node("Neg", {"x"}, {"y"}));
  ASSERT_NE(model, nullptr);
  std::vector<float> x(6), y(2);
  OneToOne frames({6}, x, {2}, y);
  const auto status = frames.through(*model);
  ASSERT_FALSE(status);
  EXPECT_TRUE(status.error().code == Code::INVOKE_FAILED ||
              status.error().code == Code::SPEC_MISMATCH)
      << status.error().message();
}

}  // namespace onnxruntime_refusals_test
}  // namespace weir::engine_test
