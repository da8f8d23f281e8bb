// Tests which streams a described model belongs to, and what modules get of it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/filter/described_model.hpp"

#include <gtest/gtest.h>

namespace weir {
namespace described_model_test {

FrameSpec stream_of(std::vector<TensorSpec> tensors, Format format = Format::Static) {
  return {format, std::move(tensors), {30, 1}};
}
TensorSpec tensor(ElementType type, const char* dimensions) {
  return {type, Shape::parse(dimensions), {}};
}
DescribedModel model_of(std::vector<ModelTensor> outputs) {
  DescribedModel model;
  model.outputs = std::move(outputs);
  return model;
}

TEST(DescribedModel, BelongsToStreamsOfItsOutputs) {
  const auto model = model_of(
      {{.type = ElementType::Int8, .rank_known = true, .shape = {1, 84, 8400}, .name = "o"},
       {.type = ElementType::Float32, .rank_known = true, .shape = {}, .name = "scalar"}});
  const auto boxes = tensor(ElementType::Int8, "8400:84"),
             scalar = tensor(ElementType::Float32, "1");
  EXPECT_TRUE(has_outputs(model, stream_of({boxes, scalar})))
      << "outer dimensions of 1 do not count";
  EXPECT_TRUE(has_outputs(model, stream_of({}, Format::Flexible)));
  EXPECT_FALSE(has_outputs(model, stream_of({boxes})));
  EXPECT_FALSE(has_outputs(model, stream_of({scalar, boxes})));
  EXPECT_FALSE(has_outputs(model, stream_of({boxes, scalar, scalar})));
  EXPECT_FALSE(has_outputs(model, stream_of({tensor(ElementType::UInt8, "8400:84"), scalar})));
  EXPECT_FALSE(has_outputs(model, stream_of({tensor(ElementType::Int8, "84:8400"), scalar})));
  EXPECT_FALSE(has_outputs(model, stream_of({}, Format::Sparse)));
}

TEST(DescribedModel, OfUnknownOrImpossibleShapesBelongsToNoStaticStream) {
  for (const int64_t extent : {int64_t{-1}, int64_t{0}, int64_t{1} << 40}) {
    const auto model = model_of(
        {{.type = ElementType::Float32, .rank_known = true, .shape = {extent, 4}, .name = {}}});
    EXPECT_FALSE(has_outputs(model, stream_of({tensor(ElementType::Float32, "4:1")}))) << extent;
    EXPECT_TRUE(has_outputs(model, stream_of({}, Format::Flexible)));
  }
  const std::vector<int64_t> deep(17, 1);
  const auto model =
      model_of({{.type = ElementType::Float32, .rank_known = true, .shape = deep, .name = {}}});
  EXPECT_FALSE(has_outputs(model, stream_of({tensor(ElementType::Float32, "1")})));
}

TEST(DescribedModel, GoesToModulesWithNamesAndQuantisation) {
  DescribedModel model = model_of({{.type = ElementType::UInt8,
                                    .rank_known = true,
                                    .shape = {1, -1, 6},
                                    .name = "output0",
                                    .scale = 0.5f,
                                    .zero_point = 3}});
  model.inputs.push_back(
      {.type = ElementType::Float32, .rank_known = true, .shape = {1, 3, 640, 640}, .name = {}});
  model.path = "/models/a.onnx";
  AbiModel abi;
  const weir_stream_model& out = abi.fill(model);
  EXPECT_EQ(out.struct_size, sizeof out);
  ASSERT_EQ(out.n_outputs, 1u);
  EXPECT_EQ(out.outputs[0].type, uint32_t{WEIR_UINT8});
  EXPECT_EQ(out.outputs[0].rank, 3u);
  EXPECT_EQ(out.outputs[0].shape[1], -1);
  EXPECT_STREQ(out.outputs[0].name, "output0");
  EXPECT_EQ(out.outputs[0].scale, 0.5f);
  EXPECT_EQ(out.outputs[0].zero_point, 3);
  ASSERT_EQ(out.n_inputs, 1u);
  EXPECT_EQ(out.inputs[0].name, nullptr);
  EXPECT_EQ(out.inputs[0].scale, 0);
  EXPECT_EQ(out.inputs[0].shape[3], 640);
  EXPECT_STREQ(out.path, "/models/a.onnx");
  EXPECT_EQ(out.metadata_json, nullptr);
}

}  // namespace described_model_test
}  // namespace weir
