// Tests errors of programs and engines, each reported with the tensor's name.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <array>

#include "core/direct/direct_test_support.hpp"

namespace weir::direct {
namespace direct_refusals_test {

using Values = std::vector<float>;
const Values kTwo{1, 2}, kFour{1, 2, 3, 4};

TEST_F(DirectTest, RejectsAWrongNumberOfInputs) {
  const auto model = open();
  EXPECT_REFUSED(model->invoke({}), SPEC_MISMATCH,
                 "the model has a different number of inputs\n  offered: 0\n"
                 "  needed: 1: float32 (?, 2) x");
  EXPECT_REFUSED(model->invoke(std::array{lend(kTwo), lend(kTwo)}), SPEC_MISMATCH, "offered: 2");
}

TEST_F(DirectTest, RejectsADifferentType) {
  const auto model = open();
  auto input = lend(kTwo, {1, 2});
  input.info.type = WEIR_INT32;
  EXPECT_REFUSED(model->invoke(std::array{input}), SPEC_MISMATCH,
                 "input 0 (x) has a different type than the model's\n  offered: int32\n"
                 "  needed: float32");
  input.info.type = 99;
  EXPECT_REFUSED(model->invoke(std::array{input}), TYPE_SYNTAX, "has an unknown type");
}

TEST_F(DirectTest, RejectsAShapeThatTheModelDoesNotHave) {
  const auto model = open();
  EXPECT_REFUSED(model->invoke(std::array{lend(kFour, {1, 4})}), SPEC_MISMATCH,
                 "first difference: axis 1 is 4 instead of 2");
  EXPECT_REFUSED(model->invoke(std::array{lend(kTwo, {2})}), SPEC_MISMATCH, "rank 1 instead of 2");
  EXPECT_REFUSED(model->invoke(std::array{lend(kTwo, {-1, 2})}), SPEC_MISMATCH,
                 "an extent is unknown");
}

TEST_F(DirectTest, RequiresAShapeThatIsOpen) {
  EXPECT_REFUSED(open()->invoke(std::array{lend(kTwo)}), SPEC_MISMATCH,
                 "fix: model.reshape({{1, 2}})");
}

TEST_F(DirectTest, RejectsAWrongSizeAndMissingMemory) {
  const auto model = open();
  EXPECT_REFUSED(model->invoke(std::array{lend(kTwo, {2, 2})}), FRAME_SIZE,
                 "offered: 8 bytes\n  needed: 16 bytes: float32 (2, 2) x");
  auto nothing = lend(kTwo, {1, 2});
  nothing.data = nullptr;
  EXPECT_REFUSED(model->invoke(std::array{nothing}), FRAME_SIZE, "input 0 (x) has no memory");
  EXPECT_REFUSED(model->invoke(std::array{lend(kTwo, {int64_t{1} << 60, 2})}), LIMIT_EXCEEDED,
                 "input 0 (x) is too large");
  auto device = lend(kTwo, {1, 2});
  device.memory_kind = WEIR_MEMORY_CUDA;
  EXPECT_REFUSED(model->invoke(std::array{device}), FORMAT_UNSUPPORTED, "is not in host memory");
}

TEST_F(DirectTest, RejectsUnsuitableOutputMemory) {
  const auto model = open();
  Values small(1), right(2);
  std::array input{lend(kTwo, {1, 2})};
  std::array into{lend(small)};
  EXPECT_REFUSED(model->invoke(input, into), FRAME_SIZE,
                 "output 0 (y) has a size that does not match its shape");
  std::array two{lend(right), lend(right)};
  EXPECT_REFUSED(model->invoke(input, two), SPEC_MISMATCH,
                 "the model has a different number of outputs");
  std::array typed{lend(right)};
  typed[0].info.type = WEIR_UINT8;
  EXPECT_REFUSED(model->invoke(input, typed), SPEC_MISMATCH, "output 0 (y) has a different type");
}

TEST_F(DirectTest, RejectsReshapingAFixedShape) {
  const auto model = open();
  EXPECT_REFUSED(model->reshape({}), SPEC_MISMATCH, "the model has a different number of inputs");
  EXPECT_REFUSED(model->reshape({tensor_info("", WEIR_TYPE_END, {3, 3})}), SPEC_MISMATCH,
                 "axis 1 is 3 instead of 2");
  EXPECT_REFUSED(model->reshape({tensor_info("", WEIR_TYPE_END, {0, 2})}), SPEC_MISMATCH,
                 "first difference: axis 0 is 0");
  EXPECT_REFUSED(model->reshape({tensor_info("", WEIR_INT8, {1, 2})}), SPEC_MISMATCH,
                 "has a different type");
  EXPECT_EQ(shape_text(model->inputs()[0]), "(?, 2)") << "as it was";
}

TEST_F(DirectTest, KeepsItsShapesWhenTheEngineRejectsOthers) {
  const auto model = open();
  ASSERT_TRUE(model->reshape({tensor_info("", WEIR_TYPE_END, {1, 2})}));
  TestModel::resolve_body = [](auto in, auto out) {
    if (in[0].shape[0] > 1) throw Failure({.code = Code::MODEL_UNSUPPORTED, .what = "too many"});
    out[0].shape[0] = in[0].shape[0];
  };
  EXPECT_REFUSED(model->reshape({tensor_info("", WEIR_TYPE_END, {2, 2})}), MODEL_UNSUPPORTED,
                 "too many");
  const auto outcome = model->invoke(std::array{lend(kTwo)});
  ASSERT_TRUE(outcome) << outcome.error().message();
  EXPECT_EQ(values(outcome->results), (Values{2, 3}));
}

TEST_F(DirectTest, PassesOnTheEnginesError) {
  TestModel::invoke_body = [](In, Out) -> bool { throw std::runtime_error("thrown inside"); };
  EXPECT_REFUSED(open()->invoke(std::array{lend(kTwo, {1, 2})}), CALLBACK_FAILED, "thrown inside");
}

TEST_F(DirectTest, RejectsOutputsThatTheEngineDoesNotDescribe) {
  TestModel::resolve_body = nullptr;
  const auto model = open();
  std::array input{lend(kTwo, {1, 2})};
  TestModel::invoke_body = [](In, Out) { return true; };
  EXPECT_REFUSED(model->invoke(input), INVOKE_FAILED, "an output without a complete description");
  TestModel::invoke_body = [](In, Out out) {
    static float memory[2];
    out[0].data = memory;
    out[0].bytes = sizeof memory;
    out[0].info.shape[0] = 1000;
    return true;
  };
  EXPECT_REFUSED(model->invoke(input), INVOKE_FAILED, "8 bytes of float32 (1000, 2) y");
  TestModel::invoke_body = [](In, Out out) {
    out[0].info.rank = 17;
    return true;
  };
  EXPECT_REFUSED(model->invoke(input), INVOKE_FAILED, "any shape");
}

TEST_F(DirectTest, RejectsAnOpenOutputOfAnotherSizeThanTheCallersMemory) {
  TestModel::resolve_body = nullptr;
  TestModel::invoke_body = [](In, Out out) {
    static float memory[4];
    out[0].data = memory;
    out[0].bytes = sizeof memory;
    out[0].info.shape[0] = 2;
    return true;
  };
  Values y(2);
  std::array into{lend(y)};
  EXPECT_REFUSED(open()->invoke(std::array{lend(kTwo, {1, 2})}, into), FRAME_SIZE,
                 "offered: 8 bytes\n  needed: 16 bytes");
}

TEST(DirectEngine, IsFoundByNameOrByTheFiles) {
  const std::vector<std::string> none, missing{"model.txt"}, text{"/etc/passwd"};
  EXPECT_REFUSED(engine_for("", missing), MODEL_NOT_FOUND, "the model file does not exist");
  EXPECT_REFUSED(engine_for("", text), ENGINE_UNKNOWN, "no engine can be selected for this model");
  EXPECT_REFUSED(engine_for("AUTO", none), ENGINE_UNKNOWN, "no engine can be selected");
  EXPECT_REFUSED(engine_for("onnxruntim", none), ENGINE_UNKNOWN, "did you mean onnxruntime?");
}

}  // namespace direct_refusals_test
}  // namespace weir::direct
