// Clips regions of each element type, and compares cuts with a model by coordinates.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/crop/regions.hpp"
#include "core/tensor/geometry.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace weir {
namespace regions_test {

using Bytes = std::vector<std::byte>;

template <class T>
Regions read(const std::vector<T>& numbers, ElementType type, uint32_t width = 100,
             uint32_t height = 50) {
  Bytes bytes(numbers.size() * sizeof(T));
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  const TensorSpec spec{type, Shape{4, static_cast<uint32_t>(numbers.size() / 4)}, ""};
  return read_regions(spec, bytes, width, height);
}

TEST(Regions, AreReadFromEveryType) {
  for (uint32_t t = 0; t < static_cast<uint32_t>(ElementType::End); ++t)
    visit_type(static_cast<ElementType>(t), [&](auto type) {
      using T = typename decltype(type)::type;
      const std::vector<T> numbers{T(1), T(2), T(30), T(4), T(5), T(6), T(7), T(8)};
      EXPECT_EQ(read(numbers, static_cast<ElementType>(t)).inside,
                (std::vector<Rect>{{1, 2, 30, 4}, {5, 6, 7, 8}}))
          << to_string(static_cast<ElementType>(t));
    });
}

TEST(Regions, AreClippedToTheTensor) {
  const std::vector<uint32_t> numbers{90, 40, 20, 20, 100, 0, 5, 5, 0, 0, 4000000000u, 4000000000u};
  const Regions got = read(numbers, ElementType::UInt32);
  EXPECT_EQ(got.inside, (std::vector<Rect>{{90, 40, 10, 10}, {0, 0, 100, 50}}));
  EXPECT_EQ(got.empty, 1u);
}

TEST(Regions, ThatBeginOutsideKeepTheirPartInside) {
  EXPECT_EQ(read(std::vector<int16_t>{-5, -1, 20, 3}, ElementType::Int16).inside,
            (std::vector<Rect>{{0, 0, 15, 2}}));
  EXPECT_EQ(read(std::vector<int8_t>{-20, 0, 20, 3}, ElementType::Int8).empty, 1u);
  EXPECT_EQ(read(std::vector<int8_t>{5, 5, -3, 3}, ElementType::Int8).empty, 1u);
}

TEST(Regions, NotANumberMakesARegionEmpty) {
  const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
  const Regions got =
      read(std::vector<float>{nan, 0, 5, 5, 0, 0, inf, 5, 0, -inf, 5, 5, 1.9F, 2, 3, 4},
           ElementType::Float32);
  EXPECT_EQ(got.empty, 3u);
  EXPECT_EQ(got.inside, (std::vector<Rect>{{1, 2, 3, 4}}));
}

TEST(Regions, MoreThanAFrameHoldsAreCounted) {
  std::vector<uint16_t> numbers;
  for (int i = 0; i < 300; ++i) numbers.insert(numbers.end(), {1, 1, 2, 2});
  const Regions got = read(numbers, ElementType::UInt16);
  EXPECT_EQ(got.inside.size(), 256u);
  EXPECT_EQ(got.beyond_limit, 44u);
}

TEST(Regions, AnIncompleteGroupIsIgnored) {
  const std::vector<uint8_t> numbers{1, 2, 3, 4, 5, 6, 7};
  Bytes bytes(7);
  std::memcpy(bytes.data(), numbers.data(), 7);
  EXPECT_EQ(read_regions({ElementType::UInt8, Shape{7}, ""}, bytes, 100, 50).inside,
            (std::vector<Rect>{{1, 2, 3, 4}}));
}

TEST(Regions, CutsAgreeWithTheCoordinates) {
  std::mt19937 random(1);
  for (int round = 0; round < 200; ++round) {
    const auto type = static_cast<ElementType>(random() % 11);
    const uint32_t channels = 1 + random() % 4, width = 1 + random() % 20,
                   height = 1 + random() % 20;
    const TensorSpec whole{type, Shape{channels, width, height}, ""};
    Bytes in(static_cast<size_t>(*whole.bytes()));
    for (auto& b : in) b = static_cast<std::byte>(random());
    Rect r;
    r.x = random() % width, r.y = random() % height;
    r.width = 1 + random() % (width - r.x), r.height = 1 + random() % (height - r.y);
    const TensorSpec part = make_part_spec(whole, r);
    Bytes out(static_cast<size_t>(*part.bytes())), expected;
    cut(whole, in, r, out);
    const size_t size = element_size(type);
    for (uint32_t y = r.y; y < r.y + r.height; ++y)
      for (uint32_t x = r.x; x < r.x + r.width; ++x)
        for (uint32_t c = 0; c < channels; ++c)
          for (size_t b = 0; b < size; ++b)
            expected.push_back(in[((size_t{y} * width + x) * channels + c) * size + b]);
    ASSERT_EQ(out, expected) << round;
    Bytes gathered;
    const Runs runs = make_runs(part, make_layout(whole, r));
    for_each_run(runs, [&](uint64_t at) {
      gathered.insert(gathered.end(), in.begin() + static_cast<ptrdiff_t>(at),
                      in.begin() + static_cast<ptrdiff_t>(at + runs.bytes));
      return true;
    });
    ASSERT_EQ(gathered, expected) << round;
  }
}

TEST(Regions, MissingDimensionsAreOne) {
  const TensorSpec line{ElementType::UInt8, Shape{3, 4}, ""};
  EXPECT_EQ(make_part_spec(line, {1, 0, 2, 1}).shape.to_string(), "3:2:1:1");
}

}  // namespace regions_test
}  // namespace weir
