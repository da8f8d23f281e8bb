// Tests of the protobuf converter with messages that are written down by hand, in every form that
// protobuf's encoding allows (protobuf.dev/programming-guides/encoding).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "message_converter_test_support.hpp"

namespace weir::testing_converters {
namespace protobuf_test {

const Bytes kOneUint8{0x08, 1, 0x12, 4, 0x08, 30,   0x10, 1, 0x1A, 10,
                      0x10, 5, 0x1A, 1, 3,    0x22, 3,    7, 8,    9};

TEST(ProtobufConverter, SharesTheBytesOfTheMessage) {
  MessageReader reader("protobuf");
  EXPECT_TRUE(reader.configure("other/protobuf-tensor,framerate=30/1").empty())
      << "the first frame decides";
  const auto made = reader.read(kOneUint8);
  EXPECT_EQ(made.error, "");
  EXPECT_EQ(made.specs, std::vector<std::string>{"uint8 3"});
  EXPECT_EQ(made.bytes, std::vector<Bytes>({{7, 8, 9}}));
  EXPECT_EQ(made.shared, std::vector<bool>{true});
  EXPECT_EQ(made.rate, "30/1");
  EXPECT_FALSE(made.is_flexible);
}

TEST(ProtobufConverter, TakesFieldsInAnyOrderUnpackedAndUnknown) {
  const auto made = MessageReader("protobuf")
                        .read(join({
                            {0x1A, 17, 0x22, 4, 1, 2, 3, 4},  // data before its type
                            {0x18, 1, 0x18, 2, 0x0A, 1, 'x', 0x10, 3, 0x28,
                             9},  // dimensions one by one, a name, a field 5
                            {0xA2, 0x06, 2, 0xFF, 0xFF},  // field 100
                            {0x08, 1},                    // num_tensor after the tensor
                            {0x2D, 1, 2, 3, 4},           // field 5, 32 bits
                        }));
  EXPECT_EQ(made.error, "");
  EXPECT_EQ(made.specs, std::vector<std::string>{"uint16 1:2"});
  EXPECT_EQ(made.bytes, std::vector<Bytes>({{1, 2, 3, 4}}));
  EXPECT_EQ(made.rate, "") << "the caps keep theirs";
}

TEST(ProtobufConverter, SharesElementsThatAreAlignedAndCopiesOthers) {
  const Bytes message =
      join({{0x08, 1, 0x1A, 11, 0x10, 7, 0x1A, 1, 1, 0x22, 4}, {0, 0, 0x80, 0x3F}});
  for (size_t shift = 0; shift < 8; ++shift) {
    const auto made = MessageReader("protobuf").read(message, shift);
    EXPECT_EQ(made.error, "");
    EXPECT_EQ(made.bytes, std::vector<Bytes>({{0, 0, 0x80, 0x3F}}));
    EXPECT_EQ(made.shared, std::vector<bool>{(11 + shift) % 4 == 0}) << shift;
  }
}

TEST(ProtobufConverter, JoinsAMessageInSeveralMemories) {
  MessageReader reader("protobuf");
  for (size_t cut = 1; cut < kOneUint8.size(); ++cut) {
    const auto middle = kOneUint8.begin() + static_cast<ptrdiff_t>(cut);
    const auto made =
        reader.read(std::vector<Bytes>{{kOneUint8.begin(), middle}, {middle, kOneUint8.end()}});
    EXPECT_EQ(made.error, "");
    EXPECT_EQ(made.bytes, std::vector<Bytes>({{7, 8, 9}}));
    EXPECT_EQ(made.shared, std::vector<bool>{false});
  }
}

TEST(ProtobufConverter, KeepsTheHeadersOfFlexibleTensors) {
  const Bytes chunk = with_header({ElementType::UInt8, Shape{3}, ""}, {7, 8, 9});
  const Bytes tensor = join({{0x10, 5, 0x1A, 1, 3, 0x22, 0x83, 0x01}, chunk});
  const Bytes message = join({{0x08, 1, 0x1A, 0x8B, 0x01}, tensor, {0x20, 1}});
  const auto made = MessageReader("protobuf").read(message);
  EXPECT_EQ(made.error, "");
  EXPECT_TRUE(made.is_flexible);
  EXPECT_EQ(made.specs, std::vector<std::string>{"uint8 3"});
  EXPECT_EQ(made.bytes, std::vector<Bytes>({chunk}));
  Bytes broken = message;
  broken[13] ^= 1;  // the header's magic
  EXPECT_SAYS(MessageReader("protobuf").read(broken).error, "WEIR-2005");
  Bytes other = message;
  other[13 + 8] = 4;  // the header says int8
  const auto error = MessageReader("protobuf").read(other).error;
  EXPECT_SAYS(error, "WEIR-2005: the header of a flexible tensor does not agree with its frame");
  EXPECT_SAYS(error, "offered: int8 3");
}

TEST(ProtobufConverter, NamesWhatIsDamaged) {
  const std::pair<Bytes, const char*> damaged[] = {
      {{0xFF}, "its fields cannot be read"},                        // a number that does not end
      {{0x00, 0x01}, "its fields cannot be read"},                  // field 0
      {{0x0B}, "its fields cannot be read"},                        // a group that does not end
      {{0x0C}, "its fields cannot be read"},                        // a group that did not begin
      {{0x08, 1, 0x1A, 99, 0x10, 5}, "its fields cannot be read"},  // a tensor beyond the end
      {{0x08, 1, 0x1A, 4, 0x22, 99, 1, 2}, "its fields cannot be read"},
      {{0x08, 1, 0x1A, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F}, "its fields cannot be read"},  // 4 GiB - 1
      {{0x08, 1, 0x12, 2, 0x08}, "its fields cannot be read"},
      {join({{0x08, 1, 0x1A, 20, 0x1A, 18}, Bytes(18, 1)}),
       "its fields cannot be read"},  // 17 dimensions
      {{0x08, 1, 0x1A, 8, 0x1A, 6, 0x83, 0x80, 0x80, 0x80, 0x80, 0x01}, "its fields"},  // 2^35 + 3
      {{0x08, 1}, "the number of tensors that it declares"},
      {{0x08, 2, 0x1A, 2, 0x10, 5}, "the number of tensors that it declares"},
      {{0x08, 1, 0x1A, 2, 0x10, 12}, "no known element type"},
      {{0x08, 1, 0x1A, 2, 0x10, 5}, "invalid dimensions"},
  };
  MessageReader reader("protobuf");
  for (const auto& [bytes, words] : damaged) {
    const auto error = reader.read(bytes).error;
    EXPECT_SAYS(error, "WEIR-2005: a protobuf message is damaged: ");
    EXPECT_SAYS(error, words);
    EXPECT_SAYS(error, "fix: check the program that wrote the stream");
  }
  EXPECT_EQ(reader.read(kOneUint8).error, "") << "and goes on";
}

}  // namespace protobuf_test
}  // namespace weir::testing_converters
