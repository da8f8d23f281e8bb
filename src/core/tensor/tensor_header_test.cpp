// Headers against bytes written from docs/compatibility/types-and-caps.md 1.7, and corrupt headers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/tensor_header.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <vector>

#include "core/tensor/packed_tensors.hpp"
#include "core/tensor/sparse.hpp"
#include "says.hpp"

namespace weir {
namespace tensor_header_test {

using Bytes = std::vector<std::byte>;

void put(Bytes& bytes, size_t at, uint32_t value) {
  std::memcpy(bytes.data() + at, &value, 4);
}

// float32 4:2, version 1.0, format flexible, media tensor; 32 bytes of payload.
Bytes golden() {
  Bytes b(128 + 32);
  put(b, 0, 0xFEEDCCED);
  put(b, 4, 0xDE001000);
  put(b, 8, 7);
  put(b, 12, 4);
  put(b, 16, 2);
  put(b, 76, 1);
  put(b, 80, 4);
  return b;
}

TEST(TensorHeader, IsReadInTheDocumentedLayout) {
  const auto header = read_tensor_chunk(golden());
  ASSERT_TRUE(header) << header.error().message();
  EXPECT_EQ(header->spec.type, ElementType::Float32);
  EXPECT_EQ(header->spec.shape, (Shape{4, 2}));
  EXPECT_EQ(header->format, Format::Flexible);
  EXPECT_EQ(header->payload_bytes(), 32u);
}

TEST(TensorHeader, IsWrittenInTheDocumentedLayout) {
  TensorHeader header;
  header.spec = {ElementType::Float32, Shape{4, 2}, ""};
  header.format = Format::Flexible;
  std::array<std::byte, 128> out;
  write_tensor_header(header, out);
  EXPECT_EQ(std::memcmp(out.data(), golden().data(), 128), 0);
}

Shape empty(std::initializer_list<uint32_t> dims) {
  Shape shape(dims);
  shape.set_rank(dims.size());
  return shape;
}

// Readers of NNStreamer reject the header: its first dimension is 0.
TEST(TensorHeader, WithoutElementsIsReadAndWrittenInTheDocumentedLayout) {
  Bytes bytes = golden();
  put(bytes, 12, 0);
  put(bytes, 16, 1);
  put(bytes, 22 * 4, 2);
  put(bytes, 23 * 4, 5);
  bytes.resize(128);
  const auto header = read_tensor_chunk(bytes);
  ASSERT_TRUE(header) << header.error().message();
  EXPECT_EQ(header->spec.to_string(), "float32 5:0");
  EXPECT_EQ(header->payload_bytes(), 0u);
  std::array<std::byte, 128> out;
  write_tensor_header(*header, out);
  EXPECT_EQ(std::memcmp(out.data(), bytes.data(), 128), 0);
}

TEST(TensorHeader, WithoutElementsComesBack) {
  for (const Shape& shape : {empty({0}), empty({5, 0}), empty({0, 5}), empty({3, 0, 2, 0}),
                             empty({1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0})}) {
    std::array<std::byte, 128> out;
    write_tensor_header({.spec = {ElementType::UInt8, shape, ""}}, out);
    const auto header = read_tensor_chunk(out);
    ASSERT_TRUE(header) << shape.to_string();
    EXPECT_EQ(header->spec.shape, shape);
    EXPECT_EQ(header->spec.shape.to_string(), shape.to_string());
    EXPECT_TRUE(header->spec.shape.is_empty());
  }
}

TEST(TensorHeader, WithWrongEmptyDimensionsIsRejected) {
  struct Lie {
    uint32_t first, second, empty, format;
  };
  // None is 0; one beyond the rank; one that is not written as 1; a bit beyond all; sparse.
  for (const Lie lie : {Lie{5, 1, 0, 1}, Lie{5, 1, 4, 1}, Lie{5, 3, 2, 1}, Lie{5, 1, 1u << 16, 1},
                        Lie{5, 1, 2, 2}, Lie{0, 1, 2, 1}}) {
    Bytes bytes = golden();
    put(bytes, 12, 0);
    put(bytes, 16, lie.second);
    put(bytes, 76, lie.format);
    put(bytes, 22 * 4, lie.empty);
    put(bytes, 23 * 4, lie.first);
    const auto header = read_tensor_chunk(bytes);
    ASSERT_FALSE(header) << lie.empty;
    EXPECT_EQ(header.error().code, Code::HEADER_INVALID);
  }
}

TEST(TensorHeader, InconsistentIsRejected) {
  const struct {
    size_t at;
    uint32_t value;
    const char* words;
  } lies[] = {{0, 1, "does not start"}, {4, 0x01001000, "version"},
              {8, 11, "element type"},  {8, 0xFFFFFFFF, "element type"},
              {12, 0, "dimensions"},    {20, 0xFFFFFFFF, "declares"},
              {24, 7, "dimensions"},    {76, 3, "format"},
              {80, 5, "media"},         {12, 5, "declares"}};
  for (const auto& lie : lies) {
    Bytes b = golden();
    if (lie.at == 24) put(b, 20, 0);
    put(b, lie.at, lie.value);
    const auto header = read_tensor_chunk(b);
    ASSERT_FALSE(header) << lie.at;
    EXPECT_EQ(header.error().code, Code::HEADER_INVALID);
    EXPECT_SAYS(header.error().what, lie.words);
  }
}

TEST(TensorHeader, WithAProductBeyondLimitsIsRejected) {
  Bytes b = golden();
  for (size_t i = 0; i < 16; ++i) put(b, 12 + 4 * i, 0xFFFFFFFF);
  EXPECT_SAYS(read_tensor_header(b).error().what, "overflow");
}

TEST(TensorHeader, TruncatedIsRejected) {
  for (size_t size = 0; size < 160; ++size) {
    const Bytes full = golden();
    const Bytes cut(full.begin(), full.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_FALSE(read_tensor_chunk(cut)) << size;
  }
}

TEST(Sparse, RoundTripsEveryElementType) {
  std::mt19937 random(7);
  for (uint32_t t = 0; t < 11; ++t) {
    const TensorSpec spec{static_cast<ElementType>(t), Shape{5, 7, 3}, ""};
    Bytes dense(*spec.bytes());
    for (size_t i = 0; i < 105; i += 1 + random() % 5)
      dense[i * element_size(spec.type)] = std::byte(1 + random() % 100);
    const auto sparse = to_sparse(spec, dense);
    ASSERT_TRUE(sparse);
    TensorSpec back;
    const auto again = to_dense(*sparse, &back);
    ASSERT_TRUE(again) << again.error().message();
    EXPECT_EQ(*again, dense);
    EXPECT_TRUE(back.same_layout(spec));
  }
}

TEST(Sparse, RejectsBadIndicesAndCounts) {
  const TensorSpec spec{ElementType::UInt8, Shape{10}, ""};
  Bytes dense(10);
  dense[3] = dense[5] = std::byte{9};
  const Bytes good = *to_sparse(spec, dense);
  ASSERT_EQ(good.size(), 128u + 2 + 8);
  Bytes bad = good;
  put(bad, 130, 10);  // index 10 of 10
  EXPECT_FALSE(to_dense(bad, nullptr));
  bad = good;
  put(bad, 134, 3);  // the same index twice
  EXPECT_FALSE(to_dense(bad, nullptr));
  bad = good;
  put(bad, 84, 11);  // more values than elements
  EXPECT_FALSE(to_dense(bad, nullptr));
  bad = good;
  put(bad, 84, 3);  // more values than the memory holds
  EXPECT_FALSE(to_dense(bad, nullptr));
  bad = good;
  put(bad, 76, 1);
  EXPECT_FALSE(to_dense(bad, nullptr));
  EXPECT_FALSE(to_sparse(spec, Bytes(9)));
}

// Tensors 15, 16 and 17 of uint8 with 3, 2 and 1 bytes, written byte by byte.
Bytes packed() {
  Bytes b(19224 + 6);
  put(b, 0, 0xF00DC0DE);
  put(b, 8, 2);
  put(b, 16, 3);
  put(b, 24 + 8, 5);
  put(b, 24 + 12, 2);
  put(b, 24 + 80 + 8, 5);
  put(b, 24 + 80 + 12, 1);
  return b;
}

TEST(PackedTensors, AreFoundAfterTheirHeader) {
  const auto ranges = read_packed_tensors(packed(), Format::Static);
  ASSERT_TRUE(ranges) << ranges.error().message();
  EXPECT_EQ(*ranges, (std::vector<ByteRange>{{19224, 3}, {19227, 2}, {19229, 1}}));
}

TEST(PackedTensors, AreWrittenInTheDocumentedLayout) {
  const std::vector<TensorSpec> specs{{ElementType::UInt8, Shape{3}, ""},
                                      {ElementType::UInt8, Shape{2}, ""},
                                      {ElementType::UInt8, Shape{1}, ""}};
  const std::vector<uint64_t> sizes{3, 2, 1};
  Bytes out(19224);
  write_packed_header(specs, sizes, std::span(out).first<kPackedHeaderBytes>());
  EXPECT_EQ(std::memcmp(out.data(), packed().data(), 19224), 0);
}

TEST(PackedTensors, InconsistentAreRejected) {
  for (const auto& [at, value] : std::vector<std::pair<size_t, uint32_t>>{
           {0, 1}, {8, 0}, {8, 241}, {8, 3}, {16, 5}, {20, 1}, {32, 11}, {36, 0}, {36, 9}}) {
    Bytes b = packed();
    put(b, at, value);
    EXPECT_FALSE(read_packed_tensors(b, Format::Static)) << at;
  }
  EXPECT_FALSE(read_packed_tensors(Bytes(100), Format::Static));
}

TEST(PackedTensors, OfAFlexibleStreamAreWalkedByTheirHeaders) {
  Bytes b = packed();
  b.resize(19224);
  put(b, 8, 1);
  const Bytes chunk = golden();
  b.insert(b.end(), chunk.begin(), chunk.end());
  EXPECT_FALSE(read_packed_tensors(b, Format::Flexible));  // the second is missing
  b.insert(b.end(), chunk.begin(), chunk.end());
  const auto ranges = read_packed_tensors(b, Format::Flexible);
  ASSERT_TRUE(ranges);
  EXPECT_EQ(*ranges, (std::vector<ByteRange>{{19224, 160}, {19384, 160}}));
}

TEST(WalkChunks, FindsChunksBackToBackAndKeepsTheRestInTheLast) {
  const Bytes one = golden();
  Bytes many;
  for (int i = 0; i < 3; ++i) many.insert(many.end(), one.begin(), one.end());
  EXPECT_EQ(walk_chunks(many)->size(), 3u);
  EXPECT_EQ((*walk_chunks(many, 2))[1], (ByteRange{160, 320}));
  many.resize(many.size() - 1);
  EXPECT_FALSE(walk_chunks(many));
  EXPECT_FALSE(walk_chunks({}));
}

}  // namespace tensor_header_test
}  // namespace weir
