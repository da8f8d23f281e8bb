// Tests of the flatbuf decoder: FlatBuffers' own verifier and classes read what it writes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "message_decoder_test_support.hpp"
#include "tensors_generated.h"

namespace weir::testing_decoders {
namespace flatbuf_test {

namespace schema = nnstreamer::flatbuf;

// Valid as long as `made` is.
const schema::Tensors* read(const WrittenMessage& made) {
  EXPECT_EQ(made.error, "");
  flatbuffers::Verifier verifier(made.bytes.data(), made.bytes.size());
  EXPECT_TRUE(schema::VerifyTensorsBuffer(verifier));
  return schema::GetTensors(made.bytes.data());
}
Bytes get_bytes(const schema::Tensor* tensor) {
  return {tensor->data()->begin(), tensor->data()->end()};
}

TEST(FlatbufDecoder, WritesTablesThatFlatBuffersReads) {
  const auto made = write_message(
      "flatbuf", {30000, 1001}, Format::Static,
      {{ElementType::UInt8, {2, 3}, {1, 2, 3, 4, 5, 6}}, {ElementType::Float16, {1}, {7, 8}}});
  EXPECT_EQ(made.caps, "other/flatbuf-tensor");
  EXPECT_EQ(made.memories, 1u);
  const auto* root = read(made);
  EXPECT_EQ(root->num_tensor(), 2);
  EXPECT_EQ(root->fr()->rate_n(), 30000);
  EXPECT_EQ(root->fr()->rate_d(), 1001);
  EXPECT_EQ(root->format(), schema::Tensor_format::NNS_TENSOR_FORMAT_STATIC);
  ASSERT_EQ(root->tensor()->size(), 2u);
  const auto* first = root->tensor()->Get(0);
  EXPECT_EQ(first->type(), schema::Tensor_type::NNS_UINT8);
  ASSERT_EQ(first->dimension()->size(), 16u) << "always";
  for (uint32_t i = 0; i < 16; ++i)
    EXPECT_EQ(first->dimension()->Get(i), i == 0 ? 3u : i == 1 ? 2u : 0u);
  EXPECT_EQ(first->name()->str(), "");
  EXPECT_EQ(get_bytes(first), (Bytes{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(root->tensor()->Get(1)->type(), schema::Tensor_type::NNS_FLOAT16);
  EXPECT_EQ(get_bytes(root->tensor()->Get(1)), (Bytes{7, 8}));
}

TEST(FlatbufDecoder, BeginsEachTensorAtAMultipleOf64Bytes) {
  const auto made = write_message("flatbuf", {0, 1}, Format::Static,
                                  {{ElementType::UInt8, {1}, {1}},
                                   {ElementType::UInt8, {65}, Bytes(65, 2)},
                                   {ElementType::Float64, {1}, Bytes(8, 3)}});
  for (const auto* tensor : *read(made)->tensor())
    EXPECT_EQ((tensor->data()->data() - made.bytes.data()) % 64, 0);
}

TEST(FlatbufDecoder, WritesFlexibleTensorsWithTheirHeader) {
  const auto made = write_message("flatbuf", {0, 1}, Format::Flexible,
                                  {{ElementType::UInt8, {2}, Bytes(130, 6)}});
  const auto* root = read(made);
  EXPECT_EQ(root->format(), schema::Tensor_format::NNS_TENSOR_FORMAT_FLEXIBLE);
  EXPECT_EQ(get_bytes(root->tensor()->Get(0)), Bytes(130, 6));
}

}  // namespace flatbuf_test
}  // namespace weir::testing_decoders
