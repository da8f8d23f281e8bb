// Tests of the protobuf decoder: its bytes are those of protobuf's encoding, written down by hand
// (protobuf.dev/programming-guides/encoding).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "message_decoder_test_support.hpp"

namespace weir::testing_decoders {
namespace protobuf_test {

Bytes join(std::initializer_list<Bytes> parts) {
  Bytes out;
  for (const auto& part : parts) out.insert(out.end(), part.begin(), part.end());
  return out;
}

TEST(ProtobufDecoder, WritesTheFieldsInOrder) {
  const auto made =
      write_message("protobuf", {30, 1}, Format::Static, {{ElementType::UInt8, {3}, {7, 8, 9}}});
  EXPECT_EQ(made.error, "");
  EXPECT_EQ(made.caps, "other/protobuf-tensor");
  EXPECT_EQ(made.memories, 1u);
  const Bytes dimensions = join({{0x1A, 16, 3}, Bytes(15)});
  EXPECT_EQ(made.bytes, join({{0x08, 1},                     // num_tensor
                              {0x12, 4, 0x08, 30, 0x10, 1},  // fr
                              {0x1A, 25, 0x10, 5},           // tensor: type
                              dimensions,
                              {0x22, 3, 7, 8, 9}}));  // data; format STATIC is left out
}

TEST(ProtobufDecoder, LeavesZerosOutAndWritesLargeNumbersInSevenBits) {
  const auto made = write_message("protobuf", {0, 1}, Format::Static,
                                  {{ElementType::Int32, {1, 300}, Bytes(1200, 5)}});
  const Bytes dimensions = join({{0x1A, 17, 0xAC, 0x02, 1}, Bytes(14)});  // innermost first: 300, 1
  EXPECT_EQ(made.bytes, join({{0x08, 1, 0x12, 2, 0x10, 1},
                              {0x1A, 0xC6, 0x09},  // 19 + 3 + 1200 = 1222 bytes; int32 is 0
                              dimensions,
                              {0x22, 0xB0, 0x09},
                              Bytes(1200, 5)}));
}

TEST(ProtobufDecoder, WritesFlexibleTensorsWithTheirHeader) {
  const auto made = write_message("protobuf", {0, 1}, Format::Flexible,
                                  {{ElementType::UInt8, {2}, Bytes(130, 6)}});
  ASSERT_EQ(made.error, "");
  const Bytes end = join({{0x22, 0x82, 0x01}, Bytes(130, 6), {0x20, 1}});
  ASSERT_GT(made.bytes.size(), end.size());
  EXPECT_EQ(Bytes(made.bytes.end() - static_cast<ptrdiff_t>(end.size()), made.bytes.end()), end);
}

TEST(ProtobufDecoder, WritesNoFrameRateThatCannotBe) {
  for (const Fraction& rate : {Fraction{-1, -1}, Fraction{30, 0}}) {
    const auto made =
        write_message("protobuf", rate, Format::Static, {{ElementType::UInt8, {1}, {1}}});
    EXPECT_EQ(Bytes(made.bytes.begin() + 2, made.bytes.begin() + 6), (Bytes{0x12, 2, 0x10, 1}));
  }
}

}  // namespace protobuf_test
}  // namespace weir::testing_decoders
