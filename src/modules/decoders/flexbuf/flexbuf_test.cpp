// Tests of the flexbuf decoder: FlexBuffers' own verifier and classes read what it writes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <flatbuffers/flexbuffers.h>

#include "message_decoder_test_support.hpp"

namespace weir::testing_decoders {
namespace flexbuf_test {

flexbuffers::Map read(const WrittenMessage& made) {
  EXPECT_EQ(made.error, "");
  std::vector<uint8_t> tracker;
  EXPECT_TRUE(flexbuffers::VerifyBuffer(made.bytes.data(), made.bytes.size(), &tracker));
  return flexbuffers::GetRoot(made.bytes).AsMap();
}
Bytes get_bytes(const flexbuffers::Vector& tensor) {
  const auto blob = tensor[3].AsBlob();
  return {blob.data(), blob.data() + blob.size()};
}

TEST(FlexbufDecoder, WritesAMapThatFlexBuffersReads) {
  const auto made = write_message(
      "flexbuf", {30000, 1001}, Format::Static,
      {{ElementType::UInt8, {2, 3}, {1, 2, 3, 4, 5, 6}}, {ElementType::Float16, {1}, {7, 8}}});
  EXPECT_EQ(made.caps, "other/flexbuf");
  EXPECT_EQ(made.memories, 1u);
  const auto map = read(made);
  EXPECT_EQ(map.size(), 6u);
  EXPECT_TRUE(map["num_tensors"].IsUInt());
  EXPECT_EQ(map["num_tensors"].AsUInt32(), 2u);
  EXPECT_TRUE(map["rate_n"].IsInt());
  EXPECT_EQ(map["rate_n"].AsInt32(), 30000);
  EXPECT_EQ(map["rate_d"].AsInt32(), 1001);
  EXPECT_EQ(map["format"].AsInt32(), 0);
  const auto first = map["tensor_0"].AsVector(), second = map["tensor_1"].AsVector();
  ASSERT_EQ(first.size(), 4u);
  EXPECT_TRUE(first[0].IsString());
  EXPECT_EQ(first[0].AsString().str(), "");
  EXPECT_EQ(first[1].AsInt32(), 5);
  EXPECT_TRUE(first[2].IsTypedVector());
  const auto dimensions = first[2].AsTypedVector();
  ASSERT_EQ(dimensions.size(), 16u) << "always";
  for (size_t i = 0; i < 16; ++i)
    EXPECT_EQ(dimensions[i].AsUInt32(), i == 0 ? 3u : i == 1 ? 2u : 0u);
  EXPECT_EQ(get_bytes(first), (Bytes{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(second[1].AsInt32(), 10);
  EXPECT_EQ(get_bytes(second), (Bytes{7, 8}));
}

TEST(FlexbufDecoder, FindsEachOfManyTensorsByItsKey) {
  std::vector<MessageInput> inputs;
  for (uint8_t i = 0; i < 120; ++i) inputs.push_back({ElementType::UInt8, {1}, {i}});
  const auto made = write_message("flexbuf", {0, 1}, Format::Static, inputs);
  const auto map = read(made);
  for (uint8_t i = 0; i < 120; ++i)  // keys are sorted as text: tensor_10 before tensor_2
    EXPECT_EQ(get_bytes(map["tensor_" + std::to_string(i)].AsVector()), Bytes{i});
}

TEST(FlexbufDecoder, WritesLargeAndFlexibleTensors) {
  const Bytes large(1 << 20, 9);
  const auto made = write_message(
      "flexbuf", {0, 1}, Format::Flexible,
      {{ElementType::UInt8, {(1 << 20) - 128}, large}, {ElementType::UInt8, {2}, Bytes(130, 6)}});
  const auto map = read(made);
  EXPECT_EQ(map["format"].AsInt32(), 1);
  EXPECT_EQ(get_bytes(map["tensor_0"].AsVector()), large);
  EXPECT_EQ(get_bytes(map["tensor_1"].AsVector()), Bytes(130, 6));
}

}  // namespace flexbuf_test
}  // namespace weir::testing_decoders
