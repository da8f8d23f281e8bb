// Tests of what the libtorch engine rejects, and of the error texts.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "engine_contract_test_support.hpp"
#include "pytorch/torchscript_builder_test_support.hpp"
#include "says.hpp"

namespace weir::engine_test {
namespace pytorch_refusals_test {

class PytorchRejects : public EngineTest {
 protected:
  Error get_error(const std::string& methods, const Options& options = {}) {
    return EngineTest::get_error(torchscript(methods), options);
  }
  Error error_of_entries(const ZipEntries& entries) { return EngineTest::get_error(zip(entries)); }
};

const char* const kIdentity = "def forward(self, x: Tensor) -> Tensor:\n  return torch.neg(x)";

TEST_F(PytorchRejects, AModelThatDoesNotExist) {
  const auto model = OpenEngine::open(*engine(), folder_.path("none.pt"));
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().code, Code::MODEL_NOT_FOUND);
  EXPECT_SAYS(model.error().offered, "none.pt");
}

TEST_F(PytorchRejects, ATruncatedModel) {
  const auto whole = torchscript(kIdentity);
  for (size_t size = 0; size < whole.size(); ++size) {
    const Error error =
        EngineTest::get_error({whole.begin(), whole.begin() + static_cast<ptrdiff_t>(size)});
    EXPECT_EQ(error.code, Code::MODEL_INVALID) << size << ": " << error.message();
  }
}

TEST_F(PytorchRejects, OtherZipArchives) {
  const Error state = error_of_entries({{"m/data.pkl", "\x80\x02}."}, {"m/version", "3\n"}});
  EXPECT_EQ(state.code, Code::MODEL_UNSUPPORTED);
  EXPECT_SAYS(state.offered, "a state dict or Python object");
  EXPECT_SAYS(state.fix, "torch.jit.script");
  const Error other = error_of_entries({{"readme.txt", "hello"}});
  EXPECT_EQ(other.code, Code::MODEL_INVALID);
  EXPECT_SAYS(other.offered, "without data.pkl and code");
}

TEST_F(PytorchRejects, AnEntryWithAWrongChecksum) {
  auto bytes = torchscript(kIdentity);
  const std::string whole(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const size_t at = whole.find("torch.neg");
  ASSERT_NE(at, std::string::npos);
  bytes[at] = std::byte{'T'};
  const Error error = EngineTest::get_error(bytes);
  EXPECT_EQ(error.code, Code::MODEL_INVALID);
  EXPECT_SAYS(error.offered, "code/__torch__.py has a wrong checksum");
}

TEST_F(PytorchRejects, AnOperatorThatLibtorchLacksByItsName) {
  const Error error =
      get_error("def forward(self, x: Tensor) -> Tensor:\n  return ops.torchvision.nms(x, x, 0.5)");
  EXPECT_EQ(error.code, Code::MODEL_UNSUPPORTED) << error.message();
  EXPECT_SAYS(error.offered, "torchvision::nms");
}

TEST_F(PytorchRejects, AFileOfANewerPyTorch) {
  const Error error = EngineTest::get_error(torchscript(kIdentity, "9999"));
  EXPECT_EQ(error.code, Code::MODEL_UNSUPPORTED) << error.message();
  EXPECT_SAYS(error.what, "newer PyTorch");
  EXPECT_SAYS(error.offered, "9999");
}

TEST_F(PytorchRejects, CodeThatIsNotTorchScript) {
  const Error error = get_error("def forward(self, x: Tensor) -> Tensor:\n  return )");
  EXPECT_EQ(error.code, Code::MODEL_INVALID) << error.message();
  EXPECT_LT(error.message().size(), 600u) << "one line of libtorch's pages";
}

TEST_F(PytorchRejects, InputsAndOutputsThatAreNotTensors) {
  const Error input = get_error(
      "def forward(self, x: Tensor, y: List[Tensor]) -> Tensor:\n  return torch.add(x, y[0])");
  EXPECT_EQ(input.code, Code::MODEL_UNSUPPORTED) << input.message();
  EXPECT_SAYS(input.what, "input y");
  EXPECT_SAYS(input.offered, "List[Tensor]");
  const Error output = get_error("def forward(self, x: Tensor) -> int:\n  return torch.dim(x)");
  EXPECT_EQ(output.code, Code::MODEL_UNSUPPORTED) << output.message();
  EXPECT_SAYS(output.offered, "int");
  const Error none = get_error("def other(self, x: Tensor) -> Tensor:\n  return x");
  EXPECT_EQ(none.code, Code::MODEL_UNSUPPORTED) << none.message();
  EXPECT_SAYS(none.what, "forward");
}

const char* const kProduct =
    "def forward(self, x: Tensor) -> Tensor:\n"
    "  w = torch.ones([3, 5])\n"
    "  return torch.matmul(x, w)";

TEST_F(PytorchRejects, UnsuitableShapesWithLibtorchsMessage) {
  const auto model = opened(torchscript(kProduct));
  ASSERT_NE(model, nullptr);
  const auto good = model->resolve({make_tensor(WEIR_FLOAT32, {2, 3}).info});
  ASSERT_TRUE(good) << good.error().message();
  EXPECT_EQ(to_string((*good)[0]), "float32[2, 5]");
  const auto bad = model->resolve({make_tensor(WEIR_FLOAT32, {2, 4}).info});
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().code, Code::SPEC_MISMATCH);
  EXPECT_SAYS(bad.error().offered, "float32 4:2");
  EXPECT_SAYS(bad.error().difference, "mat1 and mat2 shapes cannot be multiplied (2x4 and 3x5)");
  EXPECT_SAYS(bad.error().difference, "torch.matmul");
  EXPECT_EQ(bad.error().difference.find('\n'), std::string::npos);
  const auto frame = model->invoke({make_tensor(WEIR_FLOAT32, {2, 4})});
  ASSERT_FALSE(frame);
}

// Freezing deletes the methods that libtorch's error trace refers to.
TEST_F(PytorchRejects, ShapesThatAMethodOfTheModelDoesNotAccept) {
  const auto model =
      opened(torchscript("def forward(self, x: Tensor) -> Tensor:\n"
                         "  return torch.relu((self).second((self).first(x)))\n"
                         "def first(self, x: Tensor) -> Tensor:\n"
                         "  return torch.transpose(x, 1, 0)\n"
                         "def second(self, x: Tensor) -> Tensor:\n"
                         "  return torch.matmul(x, torch.ones([2, 5]))"));
  ASSERT_NE(model, nullptr);
  ASSERT_TRUE(model->resolve({make_tensor(WEIR_FLOAT32, {2, 3}).info}));
  for (int i = 0; i < 20; ++i) {
    const auto rank = model->resolve({make_tensor(WEIR_FLOAT32, {3}).info});
    ASSERT_FALSE(rank);
    EXPECT_EQ(rank.error().code, Code::SPEC_MISMATCH);
    EXPECT_SAYS(rank.error().difference, "Dimension out of range");
    const auto size = model->resolve({make_tensor(WEIR_FLOAT32, {4, 3}).info});
    ASSERT_FALSE(size);
    EXPECT_SAYS(size.error().difference, "mat1 and mat2 shapes cannot be multiplied (3x4 and 2x5)");
  }
}

TEST_F(PytorchRejects, AWrongRank) {
  const auto model =
      opened(torchscript("def forward(self, x: Tensor) -> Tensor:\n"
                         "  w = torch.ones([4, 3, 1, 1])\n"
                         "  return torch.conv2d(x, w, None, [1, 1], [0, 0], [1, 1], 1)"));
  ASSERT_NE(model, nullptr);
  const auto rank = model->resolve({make_tensor(WEIR_FLOAT32, {3, 8}).info});
  ASSERT_FALSE(rank);
  EXPECT_EQ(rank.error().code, Code::SPEC_MISMATCH);
  EXPECT_SAYS(rank.error().difference, "rank 2 instead of 4");
  const auto colours = model->resolve({make_tensor(WEIR_FLOAT32, {1, 4, 8, 8}).info});
  ASSERT_FALSE(colours);
  EXPECT_SAYS(colours.error().difference, "dimension 3 is 4 instead of 3");
  const auto type = model->resolve({make_tensor(WEIR_UINT8, {1, 3, 8, 8}).info});
  ASSERT_FALSE(type);
  EXPECT_SAYS(type.error().difference, "type uint8 instead of float32");
}

TEST_F(PytorchRejects, ElementTypesThatLibtorchLacks) {
  const auto model = opened(torchscript(kIdentity));
  ASSERT_NE(model, nullptr);
  for (const uint32_t type : {WEIR_UINT16, WEIR_UINT32, WEIR_UINT64}) {
    const auto shapes = model->resolve({make_tensor(type, {4}).info});
    ASSERT_FALSE(shapes);
    EXPECT_EQ(shapes.error().code, Code::SPEC_MISMATCH);
    EXPECT_SAYS(shapes.error().fix, "mode=typecast");
  }
}

TEST_F(PytorchRejects, AFrameOnWhichTheModelRaises) {
  const auto model =
      opened(torchscript("def forward(self, x: Tensor) -> Tensor:\n"
                         "  if bool(torch.gt(torch.sum(x), 100)):\n"
                         "    ops.prim.RaiseException(\"far too bright\")\n"
                         "  else:\n"
                         "    pass\n"
                         "  return torch.neg(x)"));
  ASSERT_NE(model, nullptr);
  ASSERT_TRUE(model->invoke({make_tensor<float>(WEIR_FLOAT32, {1}, {7})}));
  const auto bright = model->invoke({make_tensor<float>(WEIR_FLOAT32, {1}, {700})});
  ASSERT_FALSE(bright);
  EXPECT_EQ(bright.error().code, Code::INVOKE_FAILED);
  EXPECT_SAYS(bright.error().message(), "far too bright");
  EXPECT_TRUE(model->invoke({make_tensor<float>(WEIR_FLOAT32, {1}, {7})})) << "and goes on";
}

TEST_F(PytorchRejects, AnInputTooLargeForAnyMemory) {
  const auto model =
      opened(torchscript("def forward(self, x: Tensor) -> Tensor:\n"
                         "  return torch.zeros([1000000, 1000000, 1000])"));
  ASSERT_NE(model, nullptr);
  const auto shapes = model->resolve({make_tensor(WEIR_FLOAT32, {1}).info});
  ASSERT_FALSE(shapes);
  EXPECT_EQ(shapes.error().code, Code::OUT_OF_MEMORY) << shapes.error().message();
}

TEST_F(PytorchRejects, ADryRunAboveTheLimitForAnyCaps) {
  const auto model =
      opened(torchscript("def forward(self, x: Tensor) -> Tensor:\n  return x[0:2]"));
  ASSERT_NE(model, nullptr);
  weir_tensor_info huge = make_tensor(WEIR_FLOAT32, {1}).info;
  huge.shape[0] = int64_t{1} << 29;
  const uint64_t before = peak_resident_bytes();
  const auto open = model->resolve({huge});
  ASSERT_TRUE(open) << open.error().message();
  EXPECT_EQ((*open)[0].rank, WEIR_RANK_UNKNOWN) << "the first frame decides";
  EXPECT_TRUE(model->control(WEIR_WARM));
  EXPECT_LT(peak_resident_bytes(), before + (uint64_t{1} << 28));
}

TEST_F(PytorchRejects, ToRunWithoutMemoryAndRecovers) {
  const auto bytes = torchscript("def forward(self, x: Tensor) -> Tensor:\n  return -x");
  expect_errors_without_memory(
      {*engine(), folder_.write("model.pt", bytes), {1 << 22}, folder_.path("")});
}

TEST_F(PytorchRejects, InvalidOptionValues) {
  for (const auto& [key, value] : Options{
           {"NumThreads", "0"}, {"NumThreads", "many"}, {"Freeze", "maybe"}, {"Optimize", "2"}}) {
    const Error error = get_error(kIdentity, {{key, value}});
    EXPECT_EQ(error.code, Code::OPTION_VALUE) << key << value;
    EXPECT_SAYS(error.offered, value);
    EXPECT_FALSE(error.fix.empty());
  }
  EXPECT_EQ(get_error(kIdentity, {{"input", "3:x"}}).code, Code::DIMENSION_SYNTAX);
  EXPECT_EQ(get_error(kIdentity, {{"inputtype", "float"}}).code, Code::TYPE_SYNTAX);
  const Error two = get_error(kIdentity, {{"input", "3,4"}});
  EXPECT_EQ(two.code, Code::SPEC_MISMATCH) << two.message();
  EXPECT_SAYS(two.what, "number of inputs");
}

TEST_F(PytorchRejects, InconsistentFrames) {
  const auto model = opened(torchscript(kIdentity));
  ASSERT_NE(model, nullptr);
  std::vector<float> x(6), y(6);
  OneToOne frames({2, 3}, x, {2, 3}, y);
  weir_tensor &in = frames.in, &out = frames.out;
  ASSERT_TRUE(frames.through(*model));
  const auto code = [&] { return frames.get_code(*model); };
  in.bytes = 20;
  EXPECT_EQ(code(), Code::FRAME_SIZE);
  in.bytes = 24;
  out.bytes = 20;
  EXPECT_EQ(code(), Code::FRAME_SIZE);
  out.info.shape[1] = 2;
  out.bytes = 16;
  EXPECT_EQ(code(), Code::INVOKE_FAILED) << "a smaller output is not written past its end";
  out.info.shape[1] = 3;
  out.bytes = 24;
  in.data = nullptr;
  EXPECT_EQ(code(), Code::FRAME_SIZE);
  in.data = x.data();
  frames.in_frame.n_tensors = 0;
  EXPECT_EQ(code(), Code::SPEC_MISMATCH);
}

}  // namespace pytorch_refusals_test
}  // namespace weir::engine_test
