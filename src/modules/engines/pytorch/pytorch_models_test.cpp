// Tests real TorchScript models against ../shared/MANIFEST.md and their code.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>

#include "engine_test_support.hpp"
#include "says.hpp"
#include "usable_cores.hpp"

namespace weir::engine_test {
namespace pytorch_models_test {

class PytorchModels : public EngineTest {
 protected:
  static std::vector<TestTensor> invoke(const std::unique_ptr<OpenEngine>& model,
                                        const std::vector<TestTensor>& inputs) {
    if (!model) return {};
    auto out = model->invoke(inputs);
    if (!out) ADD_FAILURE() << out.error().message();
    return out ? *std::move(out) : std::vector<TestTensor>{};
  }
};

// A smooth picture: v(i) = sin(i / 7) / 2.
TestTensor wave(const std::vector<int64_t>& shape) {
  auto tensor = make_tensor(WEIR_FLOAT32, shape);
  auto* at = reinterpret_cast<float*>(tensor.bytes.data());
  for (size_t i = 0; i < tensor.bytes.size() / sizeof(float); ++i)
    at[i] = std::sin(static_cast<float>(i) / 7) / 2;
  return tensor;
}

TEST_F(PytorchModels, LenetReadsTheNine) {
  const auto path = shared_file("models/torchscript/pytorch_lenet5.pt");
  if (path.empty()) GTEST_SKIP() << "../shared/models/torchscript is not there";
  const auto model = opened(path);
  const auto pixels = read_png(shared_file("media/image/9.png"));
  ASSERT_EQ(pixels.size(), 28u * 28u);
  const std::vector<uint8_t> bytes(pixels.begin(), pixels.end());
  const auto out = invoke(model, {make_tensor<uint8_t>(WEIR_UINT8, {1, 28, 28, 1}, bytes)});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(to_string(out[0].info), "uint8[1, 10]");
  const auto scores = out[0].values<uint8_t>();
  EXPECT_EQ(scores[9], 254);  // MANIFEST
  for (size_t i = 0; i < 9; ++i) EXPECT_LE(scores[i], 1) << i;
}

TEST_F(PytorchModels, LenetRejectsOtherShapesWithAMessage) {
  const auto path = shared_file("models/torchscript/pytorch_lenet5.pt");
  if (path.empty()) GTEST_SKIP() << "../shared/models/torchscript is not there";
  for (int i = 0; i < 4; ++i) {
    const auto model = OpenEngine::open(*engine(), path);
    ASSERT_TRUE(model) << model.error().message();
    for (const std::vector<int64_t>& shape : {std::vector<int64_t>{1}, {28, 28}, {1, 28, 28}}) {
      const auto found = (*model)->resolve({make_tensor(WEIR_UINT8, shape).info});
      ASSERT_FALSE(found);
      EXPECT_EQ(found.error().code, Code::SPEC_MISMATCH) << found.error().message();
    }
  }
}

// P-Net accepts pictures of any size, so the stream's shape decides.
TEST_F(PytorchModels, ThreadsFollowTheWorkOfAFrame) {
  struct Case {
    const char* name;
    int64_t size;
    int max;
  };
  for (const auto& [name, size, max] : {Case{"rnet.pt", 24, 1}, Case{"onet.pt", 48, 1},
                                        Case{"pnet.pt", 96, 1}, Case{"pnet.pt", 320, 9}}) {
    const auto path = shared_file(std::string("models/face/mtcnn/torchscript/") + name);
    if (path.empty()) GTEST_SKIP() << name << " is not there";
    const auto model = opened(path);
    EXPECT_EQ(model->execution().threads, 0u) << "not known before the stream's shape is";
    const auto outputs = model->resolve({make_tensor(WEIR_FLOAT32, {1, 3, size, size}).info});
    ASSERT_TRUE(outputs) << outputs.error().message();
    EXPECT_EQ(model->execution().threads, static_cast<uint32_t>(std::min(max, usable_cores())))
        << name << " " << size;
  }
}

TEST_F(PytorchModels, RequestedThreadsAreUsed) {
  const auto path = shared_file("models/torchscript/pytorch_lenet5.pt");
  if (path.empty()) GTEST_SKIP() << "models/torchscript is not there";
  const auto model = OpenEngine::open(*engine(), path, {}, 2);
  ASSERT_TRUE(model) << model.error().message();
  ASSERT_TRUE((*model)->resolve({make_tensor(WEIR_UINT8, {1, 28, 28, 1}).info}));
  EXPECT_EQ((*model)->execution().threads, 2u);
}

// Their code returns (x + 1, h + 2), and x + y.
TEST_F(PytorchModels, SamplesOfTwoInputs) {
  const auto two = shared_file("models/torchscript/sample_3x4_two_input_two_output.pt");
  const auto one = shared_file("models/torchscript/sample_4x4x4x4x4_two_input_one_output.pt");
  if (two.empty() || one.empty()) GTEST_SKIP() << "../shared/models/torchscript is not there";
  const auto x = wave({3, 4}), h = wave({3, 4});
  auto out = invoke(opened(two), {x, h});
  ASSERT_EQ(out.size(), 2u);
  EXPECT_EQ(to_string(out[1].info), "float32[3, 4]");
  const auto xs = x.values<float>(), a = out[0].values<float>(), b = out[1].values<float>();
  for (size_t i = 0; i < xs.size(); ++i) {
    EXPECT_EQ(a[i], xs[i] + 1);
    EXPECT_EQ(b[i], xs[i] + 2);
  }
  const auto cube = wave({4, 4, 4, 4, 4});
  out = invoke(opened(one), {cube, cube});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(to_string(out[0].info), "float32[4, 4, 4, 4, 4]");
  const auto values = cube.values<float>(), sums = out[0].values<float>();
  for (size_t i = 0; i < values.size(); ++i) EXPECT_EQ(sums[i], values[i] + values[i]);
}

// MANIFEST: P-Net's map is ceil((H-2)/2) - 4 high; the same rule gives the width. Channels 0 and 1
// of the first output are a softmax.
TEST_F(PytorchModels, PnetFollowsTheSizeOfThePicture) {
  const auto path = shared_file("models/face/mtcnn/torchscript/pnet.pt");
  if (path.empty()) GTEST_SKIP() << "../shared/models/face/mtcnn is not there";
  const auto model = opened(path);
  ASSERT_NE(model, nullptr);
  EXPECT_EQ(to_string(model->inputs()[0]), "float32[-1, 3, -1, -1]");
  for (const auto& [h, w] :
       std::vector<std::pair<int64_t, int64_t>>{{12, 12}, {13, 17}, {37, 51}, {64, 64}}) {
    const auto map = [](int64_t side) { return (side - 2 + 1) / 2 - 4; };
    const auto shapes = model->resolve({make_tensor(WEIR_FLOAT32, {1, 3, h, w}).info});
    ASSERT_TRUE(shapes) << shapes.error().message();
    EXPECT_EQ(to_shape((*shapes)[0]), (std::vector<int64_t>{1, 2, map(h), map(w)}));
    EXPECT_EQ(to_shape((*shapes)[1]), (std::vector<int64_t>{1, 4, map(h), map(w)}));
    const auto out = invoke(model, {wave({1, 3, h, w})});
    const auto p = out[0].values<float>();
    const size_t cells = p.size() / 2;
    for (size_t i = 0; i < cells; ++i) EXPECT_NEAR(p[i] + p[cells + i], 1, 1e-5);
  }
}

TEST_F(PytorchModels, FreezingAndOptimisingChangeNothingButTheLastBits) {
  for (const char* name : {"rnet", "onet"}) {
    const auto path = shared_file(std::string("models/face/mtcnn/torchscript/") + name + ".pt");
    if (path.empty()) GTEST_SKIP() << "../shared/models/face/mtcnn is not there";
    const int64_t side = name[0] == 'r' ? 24 : 48;
    const auto input = wave({2, 3, side, side});
    const auto plain = OpenEngine::open(*engine(), path, {{"Freeze", "false"}});
    ASSERT_TRUE(plain) << plain.error().message();
    const auto expected =
        invoke(*OpenEngine::open(*engine(), path, {{"Freeze", "false"}}), {input});
    const auto got = invoke(opened(path), {input});
    ASSERT_EQ(got.size(), expected.size());
    ASSERT_EQ(got.size(), side == 24 ? 2u : 3u);
    for (size_t i = 0; i < got.size(); ++i) {
      const auto a = got[i].values<float>(), b = expected[i].values<float>();
      ASSERT_EQ(a.size(), b.size());
      for (size_t k = 0; k < a.size(); ++k) EXPECT_NEAR(a[k], b[k], 1e-5) << name << i;
    }
  }
}

TEST_F(PytorchModels, StateDictsAreRejectedByName) {
  for (const char* name : {"pnet", "rnet", "onet"}) {
    const auto path = shared_file(std::string("models/face/mtcnn/") + name + ".pt");
    if (path.empty()) GTEST_SKIP() << "../shared/models/face/mtcnn is not there";
    const auto model = OpenEngine::open(*engine(), path);
    ASSERT_FALSE(model);
    EXPECT_EQ(model.error().code, Code::MODEL_UNSUPPORTED);
    EXPECT_SAYS(model.error().offered, "state dict") << model.error().message();
    EXPECT_SAYS(model.error().fix, "torch.jit.script");
  }
}

}  // namespace pytorch_models_test
}  // namespace weir::engine_test
