// Tests of the engine through the C ABI: shapes, options and rejected input.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <limits>

#include "damaged_model_test_support.hpp"
#include "network_files_test_support.hpp"

namespace mtcnn::kernels {
namespace engine_test {

using weir::Code;
using weir::engine_test::make_tensor;
using weir::engine_test::OpenEngine;
using weir::engine_test::to_string;

class KernelsEngine : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_NE(weir::engine_test::engine(), nullptr);
    for (size_t i = 0; i < 3; ++i) files_[i] = test::network_file(network_plans()[i], false);
  }
  weir::Result<std::unique_ptr<OpenEngine>> open(const std::vector<std::byte>& file,
                                                 const OpenEngine::Options& options = {}) {
    return OpenEngine::open(*weir::engine_test::engine(), folder_.write("net.onnx", file), options);
  }
  std::unique_ptr<OpenEngine> opened(size_t network, const char* precision = "float32") {
    auto model = open(files_[network], {{"Precision", precision}});
    if (!model) ADD_FAILURE() << model.error().message();
    return model ? *std::move(model) : nullptr;
  }
  weir::engine_test::TemporaryFolder folder_;
  std::vector<std::byte> files_[3];
};

TEST_F(KernelsEngine, ReportsItsTensors) {
  EXPECT_STREQ(weir::engine_test::engine()->name, "mtcnn-kernels");
  const auto proposal = opened(0), landmarks = opened(2);
  ASSERT_TRUE(proposal && landmarks);
  EXPECT_EQ(to_string(proposal->inputs()[0]), "uint8[-1, -1, -1, 3]");
  EXPECT_EQ(to_string(proposal->outputs()[1]), "float32[-1, -1, -1, 4]");
  EXPECT_EQ(to_string(landmarks->inputs()[0]), "uint8[-1, 48, 48, 3]");
  EXPECT_EQ(landmarks->outputs().size(), 3u);
  EXPECT_EQ(to_string(landmarks->outputs()[2]), "float32[-1, 10]");
  const auto resolved = proposal->resolve({make_tensor(WEIR_UINT8, {1, 17, 13, 3}).info});
  ASSERT_TRUE(resolved) << resolved.error().message();
  EXPECT_EQ(to_string((*resolved)[0]), "float32[1, 4, 2, 2]");
}

TEST_F(KernelsEngine, AgreesWithPlainLoopsInBothPrecisions) {
  const auto model = opened(1), bytes = opened(1, "int8");
  ASSERT_TRUE(model && bytes);
  std::vector<uint8_t> pixels(2 * 24 * 24 * 3);
  for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<uint8_t>(i * i / 7);
  const auto in = make_tensor(WEIR_UINT8, {2, 24, 24, 3}, pixels);
  const auto out = model->invoke({in});
  ASSERT_TRUE(out) << out.error().message();
  const auto wanted = test::plain_run(network_plans()[1], &pixels[24 * 24 * 3], 24, 24);
  EXPECT_EQ(to_string((*out)[1].info), "float32[2, 4]");
  for (size_t i = 0; i < 4; ++i) EXPECT_NEAR((*out)[1].values<float>()[4 + i], wanted[1][i], 1e-4);
  const auto rough = bytes->invoke({in});
  ASSERT_TRUE(rough) << rough.error().message();
  EXPECT_EQ(to_string((*rough)[0].info), "float32[2, 2]");
}

TEST_F(KernelsEngine, MixedUsesEightBitsForTheProposalNetworkOnly) {
  std::vector<uint8_t> pixels(24 * 24 * 3);
  for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<uint8_t>(i * i / 7);
  const auto in = make_tensor(WEIR_UINT8, {1, 24, 24, 3}, pixels);
  std::vector<float> boxes[3][2];  // boxes of P- and R-Net in float32, mixed and int8
  for (size_t p = 0; p < 3; ++p)
    for (size_t network = 0; network < 2; ++network) {
      const char* kPrecisions[] = {"float32", "mixed", "int8"};
      const auto model = opened(network, kPrecisions[p]);
      ASSERT_TRUE(model);
      const auto out = model->invoke({in});
      ASSERT_TRUE(out) << out.error().message();
      boxes[p][network] = (*out)[1].values<float>();
    }
  EXPECT_EQ(boxes[1][0], boxes[2][0]);
  EXPECT_NE(boxes[1][0], boxes[0][0]);
  EXPECT_EQ(boxes[1][1], boxes[0][1]);
  EXPECT_NE(boxes[1][1], boxes[2][1]);
}

TEST_F(KernelsEngine, AnEmptyBatchReturnsNoRows) {
  const auto model = opened(1);
  ASSERT_TRUE(model);
  const auto out = model->invoke({make_tensor(WEIR_UINT8, {0, 24, 24, 3})});
  ASSERT_TRUE(out) << out.error().message();
  EXPECT_EQ(to_string((*out)[1].info), "float32[0, 4]");
}

TEST_F(KernelsEngine, RejectsOtherTensors) {
  const auto refinement = opened(1), proposal = opened(0);
  ASSERT_TRUE(refinement && proposal);
  const struct {
    OpenEngine* model;
    weir_type type;
    std::vector<int64_t> shape;
    const char *what, *difference;
  } kCases[] = {
      {refinement.get(),
       WEIR_FLOAT32,
       {1, 24, 24, 3},
       "input 0 does not fit the model",
       "type float32 instead of uint8"},
      {refinement.get(),
       WEIR_UINT8,
       {24, 24, 3},
       "input 0 does not fit the model",
       "rank 3 instead of 4"},
      {refinement.get(),
       WEIR_UINT8,
       {1, 48, 24, 3},
       "input 0 does not fit the model",
       "dimension 3 is 48 instead of 24"},
      {refinement.get(),
       WEIR_UINT8,
       {1, 24, 24, 4},
       "input 0 does not fit the model",
       "dimension 1 is 4 instead of 3"},
      {proposal.get(),
       WEIR_UINT8,
       {1, 11, 30, 3},
       "the picture is smaller than the receptive field of the network",
       ""},
  };
  for (const auto& one : kCases) {
    const auto out = one.model->invoke({make_tensor(one.type, one.shape)});
    ASSERT_FALSE(out) << one.what;
    EXPECT_EQ(out.error().code, Code::SPEC_MISMATCH);
    EXPECT_EQ(out.error().what, one.what);
    EXPECT_EQ(out.error().difference, one.difference);
  }
  EXPECT_FALSE(refinement->invoke({}));
}

TEST_F(KernelsEngine, RejectsInvalidOptionsAndFiles) {
  const auto option = open(files_[0], {{"Precision", "float16"}});
  ASSERT_FALSE(option);
  EXPECT_EQ(option.error().code, Code::OPTION_VALUE);
  EXPECT_EQ(option.error().offered, "Precision:float16");
  EXPECT_EQ(option.error().needed, "float32, mixed or int8");
  const auto nowhere = OpenEngine::open(*weir::engine_test::engine(), folder_.path("none.onnx"));
  ASSERT_FALSE(nowhere);
  EXPECT_EQ(nowhere.error().code, Code::MODEL_NOT_FOUND);
  const auto text = open(std::vector<std::byte>(100, std::byte{'a'}));
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().code, Code::MODEL_INVALID);
}

TEST_F(KernelsEngine, DamagedFilesAreRejectedOrRun) {
  for (const char* precision : {"float32", "int8"}) {
    const auto counts =
        run_damaged(*weir::engine_test::engine(), files_[1], folder_, {{"Precision", precision}});
    EXPECT_GT(counts.refused, weir::engine_test::kDamagedVersions / 3);
    EXPECT_GT(counts.ran, 0) << "weights take most of its bytes";
  }
}

}  // namespace engine_test
}  // namespace mtcnn::kernels
