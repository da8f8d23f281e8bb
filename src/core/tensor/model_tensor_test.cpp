// Models' tensors: their texts, and that nothing is lost on the way from and to the C ABI.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/model_tensor.hpp"

#include <gtest/gtest.h>

namespace weir {
namespace model_tensor_test {

const ModelTensor kImages{.type = ElementType::UInt8,
                          .rank_known = true,
                          .shape = {1, -1, -1, 3},
                          .name = "images",
                          .layout = WEIR_LAYOUT_NHWC,
                          .scale = 0.0078125f,
                          .zero_point = 128};

TEST(ModelTensor, IsWrittenInnermostFirstWithOpenPartsMarked) {
  EXPECT_EQ(kImages.to_string(), "uint8 3:?:?:1");
  EXPECT_EQ((ModelTensor{.type = ElementType::Int32, .rank_known = true}).to_string(), "int32 1");
  EXPECT_EQ(ModelTensor{}.to_string(), "any type of any dimension");
  EXPECT_EQ(list_tensors({kImages, {}}), "2 tensors: uint8 3:?:?:1, any type of any dimension");
}

TEST(ModelTensor, IsTheSameAfterTheAbi) {
  const ModelTensor scalar{.type = ElementType::Float32, .rank_known = true};
  for (const ModelTensor& tensor : {kImages, scalar, ModelTensor{}})
    EXPECT_EQ(model_tensor(tensor_info(tensor)), tensor) << tensor.to_string();
  EXPECT_EQ(tensor_info(scalar).rank, 0u);
  EXPECT_EQ(tensor_info(ModelTensor{}).rank, WEIR_RANK_UNKNOWN);
}

TEST(ModelTensor, OfADeeperShapeThanTheAbiHasIsCut) {
  weir_tensor_info info{};
  info.rank = WEIR_RANK_LIMIT + 1;
  EXPECT_EQ(model_tensor(info).shape.size(), size_t{WEIR_RANK_LIMIT});
}

TEST(ModelTensor, DescribesTensorsOfStreamsOutermostFirst) {
  const auto tensor =
      model_tensor(TensorSpec{ElementType::UInt8, Shape::parse("3:640:480:1"), "a"});
  EXPECT_EQ(tensor.type, ElementType::UInt8);
  EXPECT_EQ(tensor.shape, (std::vector<int64_t>{1, 480, 640, 3}));
  EXPECT_EQ(tensor.inner(0), 3);
  EXPECT_EQ(tensor.inner(4), 1);
  EXPECT_TRUE(tensor.fixed());
  EXPECT_EQ(tensor.name, "");
}

TEST(ModelTensor, WithOpenPartsIsNotFixed) {
  EXPECT_FALSE(kImages.fixed());
  EXPECT_FALSE((ModelTensor{.type = ElementType::UInt8}).fixed());
  EXPECT_FALSE((ModelTensor{.rank_known = true, .shape = {4}}).fixed());
}

}  // namespace model_tensor_test
}  // namespace weir
