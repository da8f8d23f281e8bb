// Tests of the messages of every format: what is written can be parsed, damaged and lying messages
// are rejected with a reason, and no byte outside of a message is read.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <numeric>
#include <string_view>

#include "messages/flatbuf_message.hpp"
#include "messages/flexbuf_message.hpp"
#include "messages/protobuf_message.hpp"
#include "says.hpp"

namespace weir::messages {
namespace message_test {

using Bytes = std::vector<std::byte>;

// The bytes of a message in a block of exactly their size, so that sanitizers see reads beyond it.
struct Block {
  explicit Block(std::span<const std::byte> from)
      : size(from.size()), memory(new (std::align_val_t{64}) std::byte[size + (size == 0)]) {
    if (size > 0) std::memcpy(memory.get(), from.data(), size);
  }
  std::span<std::byte> bytes() const { return {memory.get(), size}; }

  struct Delete {
    void operator()(std::byte* p) const { operator delete[](p, std::align_val_t{64}); }
  };
  size_t size;
  std::unique_ptr<std::byte[], Delete> memory;
};

Bytes ramp(size_t size, int from = 0) {
  Bytes out(size);
  for (size_t i = 0; i < size; ++i) out[i] = static_cast<std::byte>(from + static_cast<int>(i));
  return out;
}

MessageTensor tensor(uint32_t type, std::initializer_list<uint32_t> dimensions,
                     std::span<const std::byte> data) {
  MessageTensor out;
  out.type = type;
  std::copy(dimensions.begin(), dimensions.end(), out.dimensions.begin());
  out.data = data;
  return out;
}

template <class Format>
class Messages : public testing::Test {
 protected:
  Bytes written(const TensorMessage& message) {
    Bytes out;
    const auto status = format_.write(message, [&](size_t size) {
      out.assign(size, std::byte{0xEE});  // unwritten bytes would show
      return out.data();
    });
    EXPECT_TRUE(status) << status.error().message();
    return out;
  }
  // "" when the message is accepted.
  std::string get_error(const Bytes& bytes) {
    const Block block(bytes);
    const auto status = format_.parse(block.bytes(), &parsed_);
    return status ? "" : status.error().message();
  }
  std::string get_error(const TensorMessage& message) { return get_error(written(message)); }

  // A parsed message describes memory inside of the block, completely.
  void expect_inside(std::span<const std::byte> block) {
    uint64_t total = 0;
    for (const auto& t : parsed_.tensors) {
      ASSERT_GE(t.data.data(), block.data());
      ASSERT_LE(t.data.data() + t.data.size(), block.data() + block.size());
      total += std::accumulate(t.data.begin(), t.data.end(), uint64_t{0},
                               [](uint64_t sum, std::byte b) { return sum + uint64_t(b); });
    }
    EXPECT_LE(total, 255 * block.size());
  }

  Format format_;
  TensorMessage parsed_;
  Bytes first_ = ramp(24), second_ = ramp(3, 100);
  TensorMessage two_{
      30, 1, kStatic, {tensor(WEIR_FLOAT32, {3, 2}, first_), tensor(WEIR_UINT8, {3}, second_)}};
};

using Formats = testing::Types<ProtobufMessage, FlatbufMessage, FlexbufMessage>;
TYPED_TEST_SUITE(Messages, Formats);

TYPED_TEST(Messages, AreParsedAsTheyWereWritten) {
  const Bytes bytes = this->written(this->two_);
  const Block block(bytes);
  ASSERT_TRUE(this->format_.parse(block.bytes(), &this->parsed_));
  const auto& made = this->parsed_;
  EXPECT_EQ(made.rate_n, 30);
  EXPECT_EQ(made.rate_d, 1);
  EXPECT_EQ(made.format, kStatic);
  ASSERT_EQ(made.tensors.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(made.tensors[i].type, this->two_.tensors[i].type);
    EXPECT_EQ(made.tensors[i].dimensions, this->two_.tensors[i].dimensions);
    const auto data = made.tensors[i].data;
    EXPECT_EQ(Bytes(data.begin(), data.end()), i == 0 ? this->first_ : this->second_);
  }
  this->expect_inside(block.bytes());
}

TYPED_TEST(Messages, CarryEveryTypeAndRank) {
  for (uint32_t type = 0; type < WEIR_TYPE_END; ++type)
    for (uint32_t rank = 1; rank <= WEIR_RANK_LIMIT; ++rank) {
      MessageTensor one;
      one.type = type;
      for (uint32_t i = 0; i < rank; ++i) one.dimensions[i] = i % 4 == 3 ? 2 : 1;
      const Bytes data =
          ramp((size_t{1} << rank / 4) * std::array{4, 4, 2, 2, 1, 1, 8, 4, 8, 8, 2}[type]);
      one.data = data;
      EXPECT_EQ(this->get_error(TensorMessage{0, 1, kStatic, {one}}), "");
      EXPECT_EQ(this->parsed_.tensors[0].type, type);
      EXPECT_EQ(describe_tensor(this->parsed_.tensors[0]).rank, rank);
    }
}

TYPED_TEST(Messages, CarryAnyFrameRateOrNone) {
  for (const auto& [n, d] : {std::pair{0, 1}, {30, 1}, {30000, 1001}, {INT32_MAX, INT32_MAX}}) {
    this->two_.rate_n = n;
    this->two_.rate_d = d;
    EXPECT_EQ(this->get_error(this->two_), "");
    EXPECT_TRUE(this->parsed_.has_rate());
    EXPECT_EQ(this->parsed_.rate_n, n);
    EXPECT_EQ(this->parsed_.rate_d, d);
  }
  for (const int none : {0, -1}) {
    this->two_.rate_n = this->two_.rate_d = none;
    EXPECT_EQ(this->get_error(this->two_), "");
    EXPECT_FALSE(this->parsed_.has_rate());
  }
  for (const auto& [n, d] : {std::pair{30, 0}, {-30, 1}, {30, -1}, {0, -5}}) {
    this->two_.rate_n = n;
    this->two_.rate_d = d;
    EXPECT_SAYS(this->get_error(this->two_), "the message has an invalid frame rate");
    EXPECT_SAYS(this->get_error(this->two_), "offered: " + std::to_string(n) + "/");
  }
}

TYPED_TEST(Messages, CarryHeadersOfFlexibleTensors) {
  const Bytes chunk = ramp(128 + 24);
  const TensorMessage message{0, 1, kFlexible, {tensor(WEIR_FLOAT32, {3, 2}, chunk)}};
  EXPECT_EQ(this->get_error(message), "");
  EXPECT_EQ(this->parsed_.format, kFlexible);
  EXPECT_EQ(this->parsed_.tensors[0].data.size(), 152u);
  const TensorMessage headless{0, 1, kFlexible, {tensor(WEIR_FLOAT32, {3, 2}, this->first_)}};
  EXPECT_SAYS(this->get_error(headless), "needed: 152 bytes for float32 3:2 with its header");
}

TYPED_TEST(Messages, AreDamagedAtEachByteWithoutHarm) {
  const Bytes good = this->written(this->two_);
  size_t refused = 0, accepted = 0;
  for (size_t at = 0; at < good.size(); ++at)
    for (const int by : {0x01, 0x02, 0x04, 0x08, 0x10, 0x20, 0x40, 0x80, 0xFF}) {
      Block block(good);
      block.bytes()[at] ^= static_cast<std::byte>(by);
      const auto status = this->format_.parse(block.bytes(), &this->parsed_);
      if (status) this->expect_inside(block.bytes());
      EXPECT_TRUE(status || !status.error().fix.empty());
      ++(status ? accepted : refused);
    }
  EXPECT_GT(refused, 0u);
  EXPECT_GT(accepted, 27u * 9) << "the content of tensors is no part of the message's structure";
}

TYPED_TEST(Messages, AreCutAtEachByteWithoutHarm) {
  const Bytes good = this->written(this->two_);
  for (size_t size = 0; size < good.size(); ++size) {
    const std::span<const std::byte> whole(good);
    const Block front(whole.first(size)), back(whole.last(size));
    for (const Block* block : {&front, &back}) {
      const auto status = this->format_.parse(block->bytes(), &this->parsed_);
      if (status) this->expect_inside(block->bytes());
    }
  }
  EXPECT_SAYS(this->get_error(Bytes{}),
              "WEIR-2005: a " + std::string(TypeParam::kName) + " message is damaged");
}

TYPED_TEST(Messages, AreParsedAtAnyAddress) {
  const Bytes good = this->written(this->two_);
  for (size_t shift = 1; shift < 8; ++shift) {
    Bytes shifted(shift);
    shifted.insert(shifted.end(), good.begin(), good.end());
    const auto status = this->format_.parse(std::span(shifted).subspan(shift), &this->parsed_);
    ASSERT_TRUE(status) << status.error().message();
    const auto data = this->parsed_.tensors[0].data;
    EXPECT_EQ(Bytes(data.begin(), data.end()), this->first_);
  }
}

TYPED_TEST(Messages, OfNoiseAreRefused) {
  uint64_t state = 88172645463325252u;  // xorshift
  for (int i = 0; i < 2000; ++i) {
    Bytes noise(static_cast<size_t>(i % 97));
    for (auto& b : noise) {
      state ^= state << 13, state ^= state >> 7, state ^= state << 17;
      b = static_cast<std::byte>(state);
    }
    EXPECT_NE(this->get_error(noise), "");
  }
}

TYPED_TEST(Messages, HoldAtMost256Tensors) {
  const Bytes data = ramp(1);
  TensorMessage message{0, 1, kStatic, {}};
  message.tensors.assign(256, tensor(WEIR_UINT8, {1}, data));
  EXPECT_EQ(this->get_error(message), "");
  EXPECT_EQ(this->parsed_.tensors.size(), 256u);
  for (const size_t count : {257, 300, 1000}) {
    message.tensors.assign(count, tensor(WEIR_UINT8, {1}, data));
    EXPECT_SAYS(this->get_error(message),
                "WEIR-2006: a " + std::string(TypeParam::kName) + " message has too many tensors");
    EXPECT_SAYS(this->get_error(message), "needed: at most 256");
  }
  message.tensors.clear();
  EXPECT_SAYS(this->get_error(message), "the number of tensors that it declares");
  EXPECT_SAYS(this->get_error(message), "needed: at least 1");
}

TYPED_TEST(Messages, ThatLieAreRefusedWithTheReason) {
  const auto lie = [this](MessageTensor second) {
    TensorMessage message = this->two_;
    message.tensors[1] = second;
    return this->get_error(message);
  };
  const Bytes& three = this->second_;
  EXPECT_SAYS(lie(tensor(WEIR_TYPE_END, {3}, three)),
              "tensor 1 of the message has no known element type\n  offered: type 11");
  EXPECT_SAYS(lie(tensor(WEIR_UINT8, {}, three)), "invalid dimensions");
  EXPECT_SAYS(lie(tensor(WEIR_UINT8, {3, 0, 1}, three)), "offered: 3:0:1:0");
  EXPECT_SAYS(lie(tensor(WEIR_UINT8, {0, 3}, three)), "needed: 1 to 16 dimensions of at least 1");
  EXPECT_SAYS(lie(tensor(WEIR_UINT8, {4}, three)),
              "a size that differs from its type and dimensions\n  offered: 3 bytes\n"
              "  needed: 4 bytes for uint8 4");
  EXPECT_SAYS(lie(tensor(WEIR_UINT8, {2}, three)), "needed: 2 bytes for uint8 2");
  EXPECT_SAYS(lie(tensor(WEIR_UINT8, {3}, {})), "offered: 0 bytes");
  EXPECT_SAYS(lie(tensor(WEIR_FLOAT64, {UINT32_MAX, UINT32_MAX, UINT32_MAX}, three)),
              "needed: more than a message can hold for float64");
  // 2^64 elements: the product is 0 in 64 bits.
  EXPECT_SAYS(lie(tensor(WEIR_UINT8, {1u << 16, 1u << 16, 1u << 16, 1u << 16}, {})),
              "more than a message can hold");
  EXPECT_EQ(lie(tensor(WEIR_UINT8, {3}, three)), "") << "the truth is accepted";
}

TYPED_TEST(Messages, OfSparseOrUnknownFormatAreRefused) {
  this->two_.format = kSparse;
  EXPECT_SAYS(this->get_error(this->two_),
              "WEIR-2002: a " + std::string(TypeParam::kName) + " message holds sparse tensors");
  EXPECT_SAYS(this->get_error(this->two_), "fix: tensor_sparse_dec ! tensor_decoder");
  for (const uint32_t format : {3u, 77u}) {
    this->two_.format = format;
    EXPECT_SAYS(this->get_error(this->two_), "the message has an unknown format");
  }
}

TYPED_TEST(Messages, NameTheModeThatWritesThem) {
  EXPECT_SAYS(this->get_error(ramp(40)),
              "fix: check the program that wrote the stream; tensor_decoder mode=" +
                  std::string(TypeParam::kName) + " writes such messages");
}

// 2 GiB of address space that is never touched.
TYPED_TEST(Messages, LargerThanTheirFormatAllowsAreNotWritten) {
  const std::span<const std::byte> half(this->first_.data(), size_t{1} << 30);  // never read
  const TensorMessage message{
      0, 1, kStatic, {tensor(WEIR_UINT8, {1u << 30}, half), tensor(WEIR_UINT8, {1u << 30}, half)}};
  const auto status = this->format_.write(message, [](size_t) -> std::byte* {
    ADD_FAILURE() << "allocates memory";
    return nullptr;
  });
  ASSERT_FALSE(status);
  EXPECT_SAYS(status.error().message(), "WEIR-2006: a frame is too large for a");
  EXPECT_SAYS(status.error().message(), "needed: at most 2147483647 bytes");
}

// The message that NNStreamer makes of a uint8 tensor 3:4:2:1 at 30/1, taken apart: the keys in the
// order of writing, the dimensions with 4 bytes each, and everything else as narrow as it can be.
TEST(Message, HasTheBytesOfNNStreamer) {
  const Bytes data(24, std::byte{7});
  TensorMessage message;
  message.rate_n = 30;
  message.rate_d = 1;
  message.tensors.push_back(tensor(WEIR_UINT8, {3, 4, 2, 1}, data));
  Bytes bytes;
  FlexbufMessage format;
  ASSERT_TRUE(format.write(message, [&](size_t size) {
    bytes.resize(size);
    return bytes.data();
  }));
  EXPECT_EQ(bytes.size(), 168u);
  constexpr std::string_view kKeys("num_tensors\0rate_n\0rate_d\0format\0tensor_0\0", 42);
  EXPECT_EQ(std::string_view(reinterpret_cast<const char*>(bytes.data()), kKeys.size()), kKeys);
  constexpr uint8_t kDimensions[] = {16, 0, 0, 0, 3, 0, 0, 0, 4, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0};
  const auto* at = reinterpret_cast<const uint8_t*>(bytes.data());
  const auto* end = at + bytes.size();
  EXPECT_NE(std::search(at, end, std::begin(kDimensions), std::end(kDimensions)), end);
}

// As Python's flexbuffers writes an array: docs/compatibility/io.md 7.7.
TEST(Message, MayHaveTheNumberOfElementsForThatOfBytes) {
  const Bytes data = ramp(24);
  FlexbufMessage format;
  Bytes bytes;
  ASSERT_TRUE(format.write({30, 1, kStatic, {tensor(WEIR_FLOAT32, {3, 2}, data)}},
                           [&](size_t size) { return bytes.assign(size, {}), bytes.data(); }));
  const auto blob = std::search(bytes.begin(), bytes.end(), data.begin(), data.end());
  ASSERT_NE(blob, bytes.end());
  ASSERT_EQ(*(blob - 1), std::byte{24});
  TensorMessage parsed;
  *(blob - 1) = std::byte{6};
  const auto status = format.parse(bytes, &parsed);
  ASSERT_TRUE(status) << status.error().message();
  EXPECT_TRUE(std::equal(data.begin(), data.end(), parsed.tensors[0].data.begin(),
                         parsed.tensors[0].data.end()));
  *(blob - 1) = std::byte{5};
  EXPECT_FALSE(format.parse(bytes, &parsed)) << "neither elements nor bytes";
}

TEST(Message, WhoseTensorsOverlapIsRefused) {
  const Bytes data = ramp(8);
  TensorMessage message{0, 1, kStatic, {}};
  message.tensors.assign(4, tensor(WEIR_UINT8, {8}, data));
  EXPECT_TRUE(check_message("flatbuf", 4, 32, message));
  const auto status = check_message("flatbuf", 4, 31, message);
  ASSERT_FALSE(status);
  EXPECT_SAYS(status.error().message(), "tensors of the message overlap");
}

TEST(Message, WhoseCountDiffersIsRefused) {
  const Bytes data = ramp(1);
  const TensorMessage message{0, 1, kStatic, {tensor(WEIR_UINT8, {1}, data)}};
  for (const uint64_t declared : {uint64_t{0}, uint64_t{2}, uint64_t{256}}) {
    const auto status = check_message("protobuf", declared, 1, message);
    ASSERT_FALSE(status);
    EXPECT_SAYS(status.error().message(),
                "WEIR-2005: a protobuf message is damaged: the message does not have the "
                "number of tensors that it declares");
    EXPECT_SAYS(status.error().message(), "needed: " + std::to_string(declared));
  }
  const auto many = check_message("protobuf", UINT32_MAX, 1, message);
  ASSERT_FALSE(many);
  EXPECT_SAYS(many.error().message(), "WEIR-2006");
}

}  // namespace message_test
}  // namespace weir::messages
