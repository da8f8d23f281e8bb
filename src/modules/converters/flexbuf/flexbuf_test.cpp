// Tests of the flexbuf converter with messages that FlexBuffers' own builder writes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <flatbuffers/flexbuffers.h>

#include "message_converter_test_support.hpp"

namespace weir::testing_converters {
namespace flexbuf_test {

using flexbuffers::Builder;

Bytes built(const std::function<void(Builder&)>& fill) {
  Builder builder;
  builder.Map([&] { fill(builder); });
  builder.Finish();
  return builder.GetBuffer();
}
void add_tensor(Builder& builder, const std::string& key, const std::vector<uint32_t>& dimensions,
                int type, const Bytes& data) {
  builder.Vector(key.c_str(), [&] {
    builder.String("a name");
    builder.Int(type);
    builder.Vector(dimensions);
    builder.Blob(data);
  });
}
Bytes make_message(size_t count, int64_t declared, int64_t format = 0,
                   const Bytes& data = {7, 8, 9}) {
  return built([&](Builder& b) {
    b.Int("num_tensors", declared);
    b.Int("rate_n", 30);
    b.Int("rate_d", 1);
    b.Int("format", format);
    for (size_t i = 0; i < count; ++i) add_tensor(b, "tensor_" + std::to_string(i), {3}, 5, data);
  });
}
// A message whose only tensor is this value.
Bytes message_with(const std::function<void(Builder&)>& tensor) {
  return built([&](Builder& b) {
    b.UInt("num_tensors", 1);
    b.Key("tensor_0");
    tensor(b);
  });
}

TEST(FlexbufConverter, SharesTheBytesOfTheMessage) {
  MessageReader reader("flexbuf");
  EXPECT_TRUE(reader.configure("other/flexbuf,framerate=30/1").empty())
      << "the first frame decides";
  const auto made = reader.read(make_message(1, 1));
  EXPECT_EQ(made.error, "");
  EXPECT_EQ(made.specs, std::vector<std::string>{"uint8 3"});
  EXPECT_EQ(made.bytes, std::vector<Bytes>({{7, 8, 9}}));
  EXPECT_EQ(made.shared, std::vector<bool>{true});
  EXPECT_EQ(made.rate, "30/1");
}

TEST(FlexbufConverter, SortsTensorsByTheirNumberNotTheirKey) {
  const auto made = MessageReader("flexbuf").read(built([](Builder& b) {
    b.Int("num_tensors", 12);
    for (uint8_t i = 0; i < 12; ++i) add_tensor(b, "tensor_" + std::to_string(i), {1}, 5, {i});
  }));
  EXPECT_EQ(made.error, "");
  ASSERT_EQ(made.bytes.size(), 12u);
  for (uint8_t i = 0; i < 12; ++i) EXPECT_EQ(made.bytes[i], Bytes{i});
  EXPECT_EQ(made.rate, "");
}

TEST(FlexbufConverter, TakesNumbersInEveryForm) {
  const auto made = [](const std::function<void(Builder&)>& dimensions) {
    return MessageReader("flexbuf").read(message_with([&](Builder& b) {
      b.Vector([&] {
        b.String("");
        b.IndirectInt(5);
        dimensions(b);
        b.Blob(Bytes(6, 1));
        b.Add("one more element");
      });
    }));
  };
  const std::vector<std::function<void(Builder&)>> forms{
      [](Builder& b) {
        b.Vector(std::vector<uint8_t>{3, 2});
      },
      [](Builder& b) {
        b.Vector(std::vector<int64_t>{3, 2});
      },
      [](Builder& b) { b.Vector([&] { b.UInt(3), b.IndirectUInt(2); }); },
      [](Builder& b) { b.TypedVector([&] { b.Int(3), b.Int(2); }); },
      [](Builder& b) {
        const int two[] = {3, 2};
        b.FixedTypedVector(two, 2);
      },
      [](Builder& b) {
        const unsigned three[] = {3, 2, 1};
        b.FixedTypedVector(three, 3);
      },
      [](Builder& b) {
        const unsigned four[] = {3, 2, 0, 0};
        b.FixedTypedVector(four, 4);
      }};
  for (const auto& form : forms) {
    EXPECT_EQ(made(form).error, "");
    EXPECT_EQ(made(form).bytes, std::vector<Bytes>({Bytes(6, 1)}));
  }
  EXPECT_SAYS(made([](Builder& b) { b.Int(6); }).error, "tensor_0 cannot be read");
  EXPECT_SAYS(made([](Builder& b) {
                b.Vector(std::vector<float>{3, 2});
              }).error,
              "tensor_0 cannot");
  EXPECT_SAYS(made([](Builder& b) { b.Vector(std::vector<int>{3, -2}); }).error, "tensor_0 cannot");
  EXPECT_SAYS(made([](Builder& b) { b.Vector(std::vector<uint64_t>{uint64_t{1} << 32}); }).error,
              "tensor_0 cannot");
  EXPECT_SAYS(made([](Builder& b) { b.Vector(std::vector<uint8_t>(17, 1)); }).error,
              "tensor_0 cannot");
}

TEST(FlexbufConverter, SkipsKeysThatItDoesNotKnow) {
  const auto made = MessageReader("flexbuf").read(built([](Builder& b) {
    b.UInt("num_tensors", 1);
    b.Map("more", [&] { b.Int("x", 1); });
    b.Add("tensor_", "text");
    b.Add("tensor_00", "text");
    b.Add("tensor_-1", "text");
    b.Add("a key that is much longer than all others and longer than thirty-two bytes", 5);
    add_tensor(b, "tensor_0", {3}, 5, {7, 8, 9});
  }));
  EXPECT_EQ(made.error, "");
  EXPECT_EQ(made.bytes, std::vector<Bytes>({{7, 8, 9}}));
}

TEST(FlexbufConverter, KeepsTheHeadersOfFlexibleTensors) {
  const Bytes chunk = with_header({ElementType::UInt8, Shape{3}, ""}, {7, 8, 9});
  const auto made = MessageReader("flexbuf").read(make_message(1, 1, 1, chunk));
  EXPECT_EQ(made.error, "");
  EXPECT_TRUE(made.is_flexible);
  EXPECT_EQ(made.bytes, std::vector<Bytes>({chunk}));
}

TEST(FlexbufConverter, NamesWhatIsDamaged) {
  MessageReader reader("flexbuf");
  const auto error = [&](const Bytes& bytes) { return reader.read(bytes).error; };
  EXPECT_SAYS(error({1, 2}), "WEIR-2005: a flexbuf message is damaged: its map cannot be read");
  EXPECT_SAYS(error({5, 4, 1}), "its map cannot be read\n  offered: 3 bytes");  // an int
  EXPECT_SAYS(error(Bytes(64, 0xFF)), "its map cannot be read");
  EXPECT_SAYS(error(make_message(1, 2)), "the number of tensors that it declares");
  EXPECT_SAYS(error(make_message(1, -1)), "WEIR-2006");
  EXPECT_SAYS(error(make_message(0, 0)), "the number of tensors that it declares");
  EXPECT_SAYS(error(make_message(257, 257)), "WEIR-2006: a flexbuf message has too many tensors");
  EXPECT_SAYS(error(make_message(1, int64_t{1} << 40)), "num_tensors cannot be read");
  EXPECT_SAYS(error(make_message(1, 1, 9)), "an unknown format");
  EXPECT_SAYS(error(make_message(1, 1, 0, {7})), "offered: 1 bytes");
  EXPECT_SAYS(error(message_with([](Builder& b) { b.Int(1); })), "tensor_0 cannot be read");
  EXPECT_SAYS(
      error(message_with([](Builder& b) { b.Vector([&] { b.Int(1), b.Int(2), b.Int(3); }); })),
      "tensor_0 cannot be read");
  EXPECT_SAYS(error(built([](Builder& b) {
                b.UInt("num_tensors", 2);
                add_tensor(b, "tensor_1", {3}, 5, {7, 8, 9});
              })),
              "its tensors are not numbered from 0");
  EXPECT_EQ(error(make_message(1, 1)), "") << "and goes on";
}

// The verifier of FlexBuffers 2.0.8 accepts it: it looks for a byte that is not zero.
TEST(FlexbufConverter, RefusesAKeyThatDoesNotEnd) {
  const Bytes unending{'a',               // the key: no zero follows up to the end
                       1,   2,            // keys: one, two bytes back
                       1,   1,  1, 5, 4,  // map: keys one byte back, their width; one entry: int 5
                       2,   36, 1};       // root: a map two bytes back
  EXPECT_SAYS(MessageReader("flexbuf").read(unending).error, "a key cannot be read");
}

}  // namespace flexbuf_test
}  // namespace weir::testing_converters
