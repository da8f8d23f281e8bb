// Tests of the libtorch engine on small models: shapes, types, kinds of output, options, memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>

#include "engine_test_support.hpp"
#include "pytorch/torchscript_builder_test_support.hpp"
#include "says.hpp"
#include "usable_cores.hpp"

#if defined(__SANITIZE_ADDRESS__)
// LeakSanitizer crashes when it scans libtorch's thread-local memory.
extern "C" __attribute__((visibility("default"))) const char* __asan_default_options() {
  return "detect_leaks=0";
}
#endif

namespace weir::engine_test {
namespace pytorch_test {

class Pytorch : public EngineTest {
 protected:
  std::unique_ptr<OpenEngine> opened(const std::string& methods, const Options& options = {}) {
    return EngineTest::opened(torchscript(methods), options);
  }
  static std::vector<TestTensor> invoke(const std::unique_ptr<OpenEngine>& model,
                                        const std::vector<TestTensor>& inputs) {
    if (!model) return {};
    auto out = model->invoke(inputs);
    if (!out) ADD_FAILURE() << out.error().message();
    return out ? *std::move(out) : std::vector<TestTensor>{};
  }
};

TestTensor floats(const std::vector<int64_t>& shape, const std::vector<float>& values) {
  return make_tensor<float>(WEIR_FLOAT32, shape, values);
}

const char* const kDouble = "def forward(self, x: Tensor) -> Tensor:\n  return torch.mul(x, 2)";

TEST_F(Pytorch, AModelWithoutAShapeUsesTheStreams) {
  const auto model = opened(kDouble);
  ASSERT_NE(model, nullptr);
  ASSERT_EQ(model->inputs().size(), 1u);
  EXPECT_EQ(model->inputs()[0].type, uint32_t{WEIR_TYPE_END});
  EXPECT_EQ(model->inputs()[0].rank, WEIR_RANK_UNKNOWN);
  EXPECT_STREQ(model->inputs()[0].name, "x");
  const auto shapes = model->resolve({make_tensor(WEIR_FLOAT32, {2, 3}).info});
  ASSERT_TRUE(shapes) << shapes.error().message();
  EXPECT_EQ(to_string((*shapes)[0]), "float32[2, 3]");
  const auto out = invoke(model, {floats({2, 3}, {1, 2, 3, 4, 5, 6})});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].values<float>(), (std::vector<float>{2, 4, 6, 8, 10, 12}));
}

TEST_F(Pytorch, EveryElementTypeOfLibtorchIsSupported) {
  const auto model = opened("def forward(self, x: Tensor) -> Tensor:\n  return torch.clone(x)");
  for (const uint32_t type : {WEIR_INT8, WEIR_UINT8, WEIR_INT16, WEIR_INT32, WEIR_INT64,
                              WEIR_FLOAT16, WEIR_FLOAT32, WEIR_FLOAT64}) {
    auto input = make_tensor(type, {3, 2});
    for (size_t i = 0; i < input.bytes.size(); ++i) input.bytes[i] = std::byte(i + 1);
    const auto out = invoke(model, {input});
    ASSERT_EQ(out.size(), 1u);
    EXPECT_EQ(to_string(out[0].info), to_string(input.info));
    EXPECT_EQ(out[0].bytes, input.bytes);
  }
}

TEST_F(Pytorch, TuplesAndListsWithinEachOtherAreFlattened) {
  const auto model = opened(
      "def forward(self, x: Tensor) -> Tuple[Tensor, Tuple[Tensor, List[Tensor]]]:\n"
      "  a = torch.add(x, 1)\n"
      "  b = torch.add(x, 2)\n"
      "  c = torch.add(x, 3)\n"
      "  d = torch.add(x, 4)\n"
      "  return (a, (b, [c, d]))");
  ASSERT_NE(model, nullptr);
  EXPECT_EQ(model->outputs().size(), 4u);
  const auto out = invoke(model, {floats({1}, {10})});
  ASSERT_EQ(out.size(), 4u);
  for (size_t i = 0; i < 4; ++i)
    EXPECT_EQ(out[i].values<float>(), std::vector<float>{11.0f + static_cast<float>(i)});
}

const char* const kChunks =
    "def forward(self, x: Tensor) -> List[Tensor]:\n  return torch.chunk(x, 3)";

TEST_F(Pytorch, ADryRunFindsTheLengthOfAListForTheUsersInput) {
  const auto model = opened(kChunks, {{"input", "2:6"}, {"inputtype", "float32"}});
  ASSERT_NE(model, nullptr);
  EXPECT_EQ(model->outputs().size(), 3u);
  EXPECT_EQ(to_string(model->inputs()[0]), "float32[6, 2]");
  const auto out = invoke(model, {floats({6, 2}, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11})});
  ASSERT_EQ(out.size(), 3u);
  EXPECT_EQ(out[1].values<float>(), (std::vector<float>{4, 5, 6, 7}));
  const auto reported = opened(kChunks, {{"output", "2:2,2:2,2:2"}});
  ASSERT_NE(reported, nullptr);
  EXPECT_EQ(reported->outputs().size(), 3u);
}

TEST_F(Pytorch, AListOfUnknownLengthIsRejectedWithAFix) {
  const Error error = get_error(torchscript(kChunks));
  EXPECT_EQ(error.code, Code::SPEC_MISMATCH) << error.message();
  EXPECT_SAYS(error.what, "the number of outputs is decided at run time");
  EXPECT_SAYS(error.fix, "framework=pytorch");
  EXPECT_SAYS(error.fix, "inputtype=float32");
}

TEST_F(Pytorch, BoolsBecomeBytes) {
  const auto model = opened("def forward(self, x: Tensor) -> Tensor:\n  return torch.gt(x, 0)");
  const auto out = invoke(model, {floats({3}, {-1, 0, 1})});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(to_string(out[0].info), "uint8[3]");
  EXPECT_EQ(out[0].values<uint8_t>(), (std::vector<uint8_t>{0, 0, 1}));
}

TEST_F(Pytorch, AScalarHasRankZero) {
  const auto model = opened("def forward(self, x: Tensor) -> Tensor:\n  return torch.sum(x)");
  const auto out = invoke(model, {floats({4}, {1, 2, 3, 4})});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].info.rank, 0u);
  EXPECT_EQ(out[0].values<float>(), std::vector<float>{10});
}

// A tensor whose memory order differs from its shape is output in the order of the shape.
TEST_F(Pytorch, ATransposedViewIsMadeDense) {
  const auto model =
      opened("def forward(self, x: Tensor) -> Tensor:\n  return torch.transpose(x, 0, 1)");
  const auto out = invoke(model, {floats({2, 3}, {1, 2, 3, 4, 5, 6})});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(to_string(out[0].info), "float32[3, 2]");
  EXPECT_EQ(out[0].values<float>(), (std::vector<float>{1, 4, 2, 5, 3, 6}));
}

// The weights of a convolution determine the input's rank, channels and type.
TEST_F(Pytorch, WeightsOfAConvolutionDefineTheInput) {
  const auto model = opened(
      "def forward(self, x: Tensor) -> Tensor:\n"
      "  w = torch.ones([4, 3, 1, 1])\n"
      "  return torch.conv2d(x, w, None, [1, 1], [0, 0], [1, 1], 1)");
  ASSERT_NE(model, nullptr);
  EXPECT_EQ(to_string(model->inputs()[0]), "float32[-1, 3, -1, -1]");
  EXPECT_EQ(model->inputs()[0].layout, uint32_t{WEIR_LAYOUT_NCHW});
}

// Four invokes, because libtorch profiles the first and compiles for the second.
TEST_F(Pytorch, ShapesCanChangeFromFrameToFrame) {
  const auto model = opened(
      "def forward(self, x: Tensor) -> Tensor:\n  return torch.relu(torch.sub(torch.mul(x, x), "
      "1))");
  for (const int64_t n : {1, 5, 2, 5, 7}) {
    const auto out = invoke(model, {floats({n}, std::vector<float>(static_cast<size_t>(n), 3))});
    ASSERT_EQ(out.size(), 1u);
    EXPECT_EQ(out[0].values<float>(), std::vector<float>(static_cast<size_t>(n), 8));
  }
}

TEST_F(Pytorch, ASizeThatDependsOnDataIsReportedPerFrame) {
  const auto model = opened("def forward(self, x: Tensor) -> Tensor:\n  return torch.nonzero(x)");
  ASSERT_NE(model, nullptr);
  EXPECT_TRUE(model->info().flags & WEIR_MODEL_DYNAMIC_OUTPUT);
  const auto shapes = model->resolve({make_tensor(WEIR_FLOAT32, {4}).info});
  ASSERT_TRUE(shapes) << shapes.error().message();
  EXPECT_EQ(to_string((*shapes)[0]), "int64[-1, -1]");
  const auto out = invoke(model, {floats({4}, {0, 7, 0, 9})});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].values<int64_t>(), (std::vector<int64_t>{1, 3}));
}

TEST_F(Pytorch, AModelThatWritesItsInputDoesNotChangeTheStream) {
  const auto model = opened(
      "def forward(self, x: Tensor) -> Tensor:\n"
      "  y = torch.view(x, [-1])\n"
      "  z = torch.add_(y, 1)\n"
      "  return torch.mul(x, 10)");
  ASSERT_NE(model, nullptr);
  std::vector<float> data{1, 2};
  OneToOne frames({2}, data);
  ASSERT_TRUE(frames.through(*model));
  EXPECT_EQ(data, (std::vector<float>{1, 2}));
  EXPECT_EQ(static_cast<const float*>(frames.out.data)[1], 30);
  frames.out.release(frames.out.owner);
}

// A result in libtorch's own memory is handed over; an input passed through is not.
TEST_F(Pytorch, OutputsAreTransferredAndInputsAreNot) {
  const auto model =
      opened("def forward(self, x: Tensor) -> Tuple[Tensor, Tensor]:\n  return (x, torch.neg(x))");
  ASSERT_NE(model, nullptr);
  EXPECT_TRUE(model->info().flags & WEIR_MODEL_ALLOCATES_OUTPUT);
  std::vector<float> data{1, 2};
  weir_tensor in{}, out[2]{};
  in.info = make_tensor(WEIR_FLOAT32, {2}).info;
  in.data = data.data();
  in.bytes = 8;
  weir_frame in_frame{}, out_frame{};
  in_frame.n_tensors = 1;
  in_frame.tensors = &in;
  out_frame.n_tensors = 2;
  out_frame.tensors = out;
  ASSERT_TRUE(model->invoke(in_frame, out_frame));
  EXPECT_NE(out[0].data, in.data);
  data = {0, 0};
  EXPECT_EQ(static_cast<const float*>(out[0].data)[1], 2);
  EXPECT_EQ(static_cast<const float*>(out[1].data)[1], -2);
  for (auto& tensor : out) tensor.release(tensor.owner);
}

TEST_F(Pytorch, ArgumentsWithDefaultsKeepThem) {
  const auto model =
      opened("def forward(self, x: Tensor, scale: int=3) -> Tensor:\n  return torch.mul(x, scale)");
  ASSERT_NE(model, nullptr);
  EXPECT_EQ(model->inputs().size(), 1u);
  EXPECT_EQ(invoke(model, {floats({1}, {5})})[0].values<float>(), std::vector<float>{15});
}

TEST_F(Pytorch, AModelWhoseWorkIsUnknownGetsAllCores) {
  const auto model = open(torchscript("def forward(self, x: Tensor) -> Tensor:\n  return x"));
  ASSERT_TRUE(model) << model.error().message();
  ASSERT_TRUE((*model)->resolve({make_tensor(WEIR_FLOAT32, {4}).info}));
  EXPECT_EQ((*model)->execution().threads, static_cast<uint32_t>(usable_cores()));
}

TEST_F(Pytorch, OptionsTurnFreezingAndOptimisingOff) {
  for (const Options& options : {Options{{"Freeze", "false"}}, {{"optimize", "off"}}, {}}) {
    const auto model = opened(kDouble, options);
    EXPECT_EQ(invoke(model, {floats({1}, {4})})[0].values<float>(), std::vector<float>{8});
    const std::string metadata = model->info().metadata_json;
    EXPECT_SAYS(metadata, options.empty() ? R"("optimized":true)" : R"("optimized":false)");
  }
  EXPECT_TRUE(take_log().empty());
  opened(kDouble, {{"Frezze", "false"}});
  const auto log = take_log();
  ASSERT_EQ(log.size(), 1u);
  EXPECT_SAYS(log[0], "Frezze is unknown");
}

// A module that returns the previous frame, kept in an attribute.
std::vector<std::byte> frame_before() {
  auto entries = torchscript_entries(
      "last : Optional[Tensor]\n"
      "def forward(self, x: Tensor) -> Tensor:\n"
      "  last = self.last\n"
      "  if torch.__isnot__(last, None):\n"
      "    out = torch.mul(unchecked_cast(Tensor, last), 1)\n"
      "  else:\n"
      "    out = torch.mul(x, 0)\n"
      "  self.last = x\n"
      "  return out");
  auto& object = entries[0].second;
  object.insert(object.rfind("ub."), std::string("X\4\0\0\0last", 9) + "N");
  return zip(entries);
}

TEST_F(Pytorch, AnInputThatAModelKeepsIsItsOwnCopy) {
  const auto model = EngineTest::opened(frame_before(), {{"input", "2"}, {"inputtype", "float32"}});
  ASSERT_NE(model, nullptr);
  std::vector<float> x{1, 2};
  OneToOne first({2}, x);
  ASSERT_TRUE(first.through(*model));
  first.out.release(first.out.owner);
  x = {8, 9};  // the frame is gone, and its memory is reused
  std::vector<float> next{3, 4};
  OneToOne second({2}, next);
  const auto status = second.through(*model);
  ASSERT_TRUE(status) << status.error().message();
  const auto* out = static_cast<const float*>(second.out.data);
  EXPECT_EQ(out[0], 1);
  EXPECT_EQ(out[1], 2);
  second.out.release(second.out.owner);
}

}  // namespace pytorch_test
}  // namespace weir::engine_test
