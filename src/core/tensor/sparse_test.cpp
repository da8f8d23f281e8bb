// Dense <-> sparse against a plain reading of the layout, and corrupt headers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/sparse.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "says.hpp"

namespace weir {
namespace sparse_test {

using Bytes = std::vector<std::byte>;

template <class T>
Bytes bytes_of(const std::vector<T>& values) {
  Bytes out(values.size() * sizeof(T));
  std::memcpy(out.data(), values.data(), out.size());
  return out;
}
void append(Bytes* to, const Bytes& more) {
  to->insert(to->end(), more.begin(), more.end());
}

// docs/compatibility/types-and-caps.md 1.8, element by element: those with any bit set, except
// minus zero.
template <class T>
Bytes expected_payload(const std::vector<T>& dense, bool floating) {
  Bytes values, indices;
  for (size_t i = 0; i < dense.size(); ++i) {
    Bytes one = bytes_of(std::vector<T>{dense[i]});
    Bytes magnitude = one;
    if (floating) magnitude.back() &= std::byte{0x7F};
    if (magnitude == Bytes(sizeof(T))) continue;
    append(&values, one);
    append(&indices, bytes_of(std::vector<uint32_t>{static_cast<uint32_t>(i)}));
  }
  append(&values, indices);
  return values;
}

template <class T>
void check(ElementType type, bool floating, std::mt19937* random) {
  for (const int percent : {0, 1, 10, 50, 99, 100})
    for (const uint32_t count : {1u, 7u, 8u, 9u, 64u, 1001u}) {
      std::vector<T> dense(count);
      Bytes raw(sizeof(T));
      for (T& value : dense) {
        if (static_cast<int>((*random)() % 100) >= percent) continue;
        for (auto& byte : raw) byte = std::byte(1 + (*random)() % 120);
        std::memcpy(&value, raw.data(), sizeof(T));
      }
      const TensorSpec spec{type, Shape{count}, ""};
      const auto sparse = to_sparse(spec, bytes_of(dense));
      ASSERT_TRUE(sparse);
      EXPECT_EQ(Bytes(sparse->begin() + 128, sparse->end()), expected_payload(dense, floating))
          << to_string(type) << " " << percent << " % of " << count;
      TensorSpec back;
      const auto again = to_dense(*sparse, &back);
      ASSERT_TRUE(again) << again.error().message();
      EXPECT_EQ(*again, bytes_of(dense));
      EXPECT_TRUE(back.same_layout(spec));
    }
}

TEST(Sparse, HoldsValuesAndIndicesOfEachTypeAtAnyDensity) {
  std::mt19937 random(11);
  check<int32_t>(ElementType::Int32, false, &random);
  check<uint32_t>(ElementType::UInt32, false, &random);
  check<int16_t>(ElementType::Int16, false, &random);
  check<uint16_t>(ElementType::UInt16, false, &random);
  check<int8_t>(ElementType::Int8, false, &random);
  check<uint8_t>(ElementType::UInt8, false, &random);
  check<double>(ElementType::Float64, true, &random);
  check<float>(ElementType::Float32, true, &random);
  check<int64_t>(ElementType::Int64, false, &random);
  check<uint64_t>(ElementType::UInt64, false, &random);
  check<uint16_t>(ElementType::Float16, true, &random);
}

TEST(Sparse, TreatsMinusZeroAsZeroAndKeepsNotANumber) {
  const std::vector<float> dense{-0.0f, std::nanf(""), 0.0f, -1.0f};
  const auto sparse = to_sparse({ElementType::Float32, Shape{4}, ""}, bytes_of(dense));
  ASSERT_TRUE(sparse);
  EXPECT_EQ(Bytes(sparse->begin() + 128, sparse->end()), [&] {
    Bytes out = bytes_of(std::vector<float>{dense[1], dense[3]});
    append(&out, bytes_of(std::vector<uint32_t>{1, 3}));
    return out;
  }());
}

TEST(Sparse, KeepsRankSixteen) {
  Shape shape;
  for (size_t i = 0; i < kRankLimit; ++i) shape[i] = i == 15 ? 3 : 1;
  const TensorSpec spec{ElementType::Int16, shape, ""};
  TensorSpec back;
  const auto sparse = to_sparse(spec, bytes_of(std::vector<int16_t>{0, 5, 0}));
  ASSERT_TRUE(sparse);
  ASSERT_TRUE(to_dense(*sparse, &back));
  EXPECT_EQ(back.shape.dims(), shape.dims());
}

// A chunk of five uint8, two of them nonzero, with one 32-bit word changed.
Result<Bytes> with_word(size_t at, uint32_t value) {
  Bytes chunk =
      *to_sparse({ElementType::UInt8, Shape{5}, ""}, bytes_of(std::vector<uint8_t>{0, 7, 0, 9, 0}));
  std::memcpy(chunk.data() + at, &value, 4);
  return to_dense(chunk, nullptr);
}
void expect_invalid(const Result<Bytes>& result, const std::string& words) {
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Code::HEADER_INVALID);
  EXPECT_SAYS(result.error().message(), words);
}

TEST(Sparse, ReportsEachFault) {
  ASSERT_TRUE(with_word(130, 1)) << "the index that is there";
  expect_invalid(with_word(134, 5), "offered: 5 as index 1\n  needed: ascending indices below 5");
  expect_invalid(with_word(134, 1), "offered: 1 as index 1");
  expect_invalid(with_word(130, 3), "offered: 3 as index 1");
  expect_invalid(with_word(84, 3), "declares more bytes than its memory holds");
  expect_invalid(with_word(84, 6), "more values than the tensor has elements");
  expect_invalid(with_word(76, 0), "a tensor is not sparse\n  offered: static");
  expect_invalid(with_word(0, 1), "does not start with a tensor header");
}

TEST(Sparse, RejectsOversizedDenseTensors) {
  TensorHeader header;
  header.spec = {ElementType::UInt8, Shape{1u << 31, 4}, ""};
  header.format = Format::Sparse;
  Bytes chunk(kTensorHeaderBytes);
  write_tensor_header(header, std::span(chunk).first<kTensorHeaderBytes>());
  const auto dense = to_dense(chunk, nullptr);
  ASSERT_FALSE(dense);
  EXPECT_EQ(dense.error().code, Code::LIMIT_EXCEEDED);
}

TEST(Sparse, RejectsAStaticHeader) {
  TensorHeader header;
  header.spec = {ElementType::UInt8, Shape{2}, ""};
  Bytes chunk(kTensorHeaderBytes + 2);
  write_tensor_header(header, std::span(chunk).first<kTensorHeaderBytes>());
  expect_invalid(to_dense(chunk, nullptr), "a tensor is not sparse\n  offered: static");
}

}  // namespace sparse_test
}  // namespace weir
