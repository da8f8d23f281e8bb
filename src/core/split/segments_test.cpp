// Compares cuts of a tensor with a plain walk over its elements.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/split/segments.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <random>
#include <span>

#include "core/split/pick_list.hpp"
#include "says.hpp"

namespace weir {
namespace segments_test {

using Bytes = std::vector<std::byte>;

TensorSpec tensor(ElementType type, Shape shape) {
  return {type, shape, ""};
}

Bytes ramp(size_t size) {
  Bytes out(size);
  for (size_t i = 0; i < size; ++i) out[i] = static_cast<std::byte>(i * 7 + i / 251);
  return out;
}

SplitRequest line(const char* segments) {
  return {*parse_segments(segments), {}, std::nullopt, 0};
}
SplitRequest along(size_t dimension, const char* segments) {
  return {*parse_segments(segments), {}, dimension, 0};
}

Bytes taken(const Segment& segment, const Bytes& in) {
  Bytes out(static_cast<size_t>(*segment.spec.bytes()));
  copy_segment(segment, in, out);
  return out;
}

// Visits each element by its coordinates; keeps those with an index in [from, to) along
// `dimension`.
Bytes walked(const TensorSpec& spec, const Bytes& in, size_t dimension, size_t from, size_t to) {
  Bytes out;
  const size_t size = element_size(spec.type);
  for (size_t element = 0; element < in.size() / size; ++element) {
    size_t rest = element, index = 0;
    for (size_t d = 0; d <= dimension; ++d) {
      const size_t extent = d < spec.shape.rank() ? spec.shape[d] : 1;
      index = rest % extent;
      rest /= extent;
    }
    if (index >= from && index < to)
      for (size_t b = 0; b < size; ++b) out.push_back(in[element * size + b]);
  }
  return out;
}

TEST(Segments, AreReadWithAllSeparators) {
  const auto shapes = parse_segments("1:2:3, 4 . 5:6;7/8:1");
  ASSERT_TRUE(shapes);
  ASSERT_EQ(shapes->size(), 5u);
  EXPECT_EQ((*shapes)[0].to_string(), "1:2:3");
  EXPECT_EQ((*shapes)[1].to_string(), "4");
  EXPECT_EQ((*shapes)[4].to_string(), "8:1");
  EXPECT_EQ((*parse_segments("3:4:0:0"))[0].to_string(), "3:4");
  EXPECT_EQ((*parse_segments("1:1:1:1:1:1:1:1:1:1:1:1:1:1:1:2"))[0].rank(), 16u);
  EXPECT_TRUE(parse_segments(" ")->empty());
}

TEST(Segments, ReportThePlaceOfASyntaxError) {
  const auto at = [](const char* text) {
    const auto shapes = parse_segments(text);
    EXPECT_FALSE(shapes) << text;
    return shapes ? std::string() : shapes.error().message();
  };
  EXPECT_SAYS(at("3:4,3:b"), "WEIR-1002: segment 1 of tensorseg cannot be read");
  EXPECT_SAYS(at("3:4,3:b"), "at character 7:\n    3:4,3:b\n          ^");
  EXPECT_SAYS(at("3:4,"), "segment 1");
  EXPECT_SAYS(at("0:4"), "segment 0");
  EXPECT_SAYS(at("3:0:4"), "at character 5:");
  EXPECT_SAYS(at("3:-4"), "at character 3:");
  EXPECT_SAYS(at("4294967296"), "segment 0");
  EXPECT_SAYS(at("1:1:1:1:1:1:1:1:1:1:1:1:1:1:1:1:2"), "at character 33:");
}

TEST(Split, WithoutADimensionUsesConsecutiveBytes) {
  const auto input = tensor(ElementType::Int16, {2, 3, 4});
  const Bytes bytes = ramp(48);
  const auto plan = plan_split(line("2:3,5,1:7,6:1"), input);
  ASSERT_TRUE(plan);
  EXPECT_FALSE(plan->left_over);
  const size_t sizes[] = {12, 10, 14, 12};
  size_t at = 0;
  for (size_t i = 0; i < 4; ++i) {
    const Segment& segment = plan->segments[i];
    EXPECT_TRUE(segment.dense());
    EXPECT_EQ(segment.offset, at);
    EXPECT_EQ(segment.spec.type, ElementType::Int16);
    EXPECT_EQ(taken(segment, bytes), Bytes(bytes.begin() + static_cast<int>(at),
                                           bytes.begin() + static_cast<int>(at + sizes[i])));
    at += sizes[i];
  }
  EXPECT_EQ(plan->segments[2].spec.shape.to_string(), "1:7");
}

// docs/compatibility/routing.md 6.5: pads are numbered in the order of the segments.
TEST(Split, PickedSegmentsKeepTheirOrderAndTheirOwnDimensions) {
  auto request = line("1:4,2:4,3:4");
  for (const auto& picks : {std::vector<size_t>{2, 0}, {0, 2}, {2, 0, 2}}) {
    request.picks = picks;
    const auto plan = plan_split(request, tensor(ElementType::UInt8, {4, 6}));
    ASSERT_TRUE(plan);
    ASSERT_EQ(plan->segments.size(), 2u);
    EXPECT_EQ(plan->segments[0].spec.shape.to_string(), "1:4");
    EXPECT_EQ(plan->segments[0].offset, 0u);
    EXPECT_EQ(plan->segments[1].spec.shape.to_string(), "3:4");
    EXPECT_EQ(plan->segments[1].offset, 12u);
  }
}

TEST(Split, AlongADimensionEqualsAWalkOverTheElements) {
  std::mt19937 random(4);
  const auto below = [&](uint32_t n) { return random() % n; };
  for (int round = 0; round < 300; ++round) {
    TensorSpec input;
    input.type = static_cast<ElementType>(below(11));
    const size_t rank = 1 + below(16);
    for (size_t d = 0; d < rank; ++d) input.shape[d] = 1 + below(rank > 6 ? 2 : 5);
    const size_t k = below(16);
    const uint32_t extent = std::max(input.shape[k], 1u);
    SplitRequest request;
    request.dimension = k;
    for (uint32_t left = extent; left > 0;) {
      const uint32_t size = 1 + below(left);
      request.segments.push_back(Shape{size});
      left -= size;
    }
    const Bytes bytes = ramp(static_cast<size_t>(*input.bytes()));
    const auto plan = plan_split(request, input);
    ASSERT_TRUE(plan) << plan.error().message();
    EXPECT_FALSE(plan->left_over);
    size_t from = 0, total = 0;
    for (const Segment& segment : plan->segments) {
      const size_t size = request.segments[segment.index][0];
      EXPECT_EQ(taken(segment, bytes), walked(input, bytes, k, from, from + size))
          << input.to_string() << " along " << k;
      EXPECT_EQ(std::max(segment.spec.shape[k], 1u), size);
      from += size;
      total += static_cast<size_t>(*segment.spec.bytes());
    }
    EXPECT_EQ(total, bytes.size());
  }
}

TEST(Split, AlongTheOutermostDimensionIsDense) {
  const auto input = tensor(ElementType::Float32, {3, 4, 6, 1});
  const auto rows = plan_split(along(2, "2,4"), input);
  for (const auto& segment : rows->segments) EXPECT_TRUE(segment.dense());
  const auto channels = plan_split(along(0, "1,2"), input);
  for (const auto& segment : channels->segments) EXPECT_FALSE(segment.dense());
  EXPECT_TRUE(plan_split(along(0, "3"), input)->segments[0].dense()) << "all of it";
}

TEST(Split, AlongADimensionAcceptsWholeDimensions) {
  const auto plan = plan_split(along(0, "1:4:5,2:4:5"), tensor(ElementType::UInt8, {3, 4, 5}));
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->segments[1].spec.shape.to_string(), "2:4:5");
  EXPECT_EQ(plan->segments[1].block_bytes, 2u);
}

TEST(Split, IntoEqualParts) {
  SplitRequest request;
  request.dimension = 1;
  request.parts = 3;
  const auto plan = plan_split(request, tensor(ElementType::UInt8, {2, 6, 2}));
  ASSERT_TRUE(plan);
  ASSERT_EQ(plan->segments.size(), 3u);
  EXPECT_EQ(plan->segments[2].spec.shape.to_string(), "2:2:2");
  EXPECT_EQ(plan->segments[2].offset, 8u);
}

std::string refused(const SplitRequest& request, const TensorSpec& input) {
  const auto plan = plan_split(request, input);
  EXPECT_FALSE(plan);
  return plan ? "" : plan.error().message();
}

TEST(Split, NamesTheSegmentAndTheSums) {
  const auto text = refused(line("2:3,3:4,5"), tensor(ElementType::Int16, {2, 3, 3}));
  EXPECT_SAYS(text, "WEIR-2001: the segments are larger than the tensor");
  EXPECT_SAYS(text, "offered: int16 2:3:3 = 36 bytes");
  EXPECT_SAYS(text, "needed: segments 0 to 2 = 46 bytes");
  EXPECT_SAYS(text, "segment 2 (5) begins at byte 36 and has 10 bytes");
  const auto cut = refused(along(1, "2,3"), tensor(ElementType::UInt8, {2, 4}));
  EXPECT_SAYS(cut, "needed: segments 0 to 1 = 5 along dimension 1 of 4");
  EXPECT_SAYS(cut, "segment 1 begins at 2 and is 3 long");
  EXPECT_SAYS(refused(line("4294967295:4294967295:4294967295"), tensor(ElementType::UInt8, {2})),
              "segments 0 to 0 = beyond 64 bits");
}

TEST(Split, RejectsImpossibleSegments) {
  const auto input = tensor(ElementType::UInt8, {3, 4});
  EXPECT_SAYS(refused({}, input), "WEIR-1004: tensor_split needs the segments");
  EXPECT_SAYS(refused({}, input), "fix: tensor_split tensorseg=3:4");
  EXPECT_SAYS(refused({{}, {}, {}, 2}, input), "split-parts needs split-dim");
  EXPECT_SAYS(refused({{}, {}, 0, 2}, input), "3 / 2 leaves 1");
  EXPECT_SAYS(refused({{Shape{1}}, {}, 0, 3}, input), "tensorseg and split-parts both");
  EXPECT_SAYS(refused(along(0, "1:4,2:5"), input), "segment 1 is 2:5");
  EXPECT_SAYS(refused({{Shape{1}}, {}, 16, 0}, input), "split-dim is not a dimension");
  auto picks = line("1:4,2:4");
  picks.picks = {1, 2};
  EXPECT_SAYS(refused(picks, input), "tensorpick names a segment that does not exist");
  EXPECT_SAYS(refused(picks, input), "there are 2 segments");
}

TEST(Split, ReportsUncoveredElements) {
  const auto plan = plan_split(line("2:4"), tensor(ElementType::UInt8, {3, 4}));
  ASSERT_TRUE(plan && plan->left_over);
  EXPECT_SAYS(plan->left_over->message(), "offered: uint8 3:4 = 12 bytes");
  EXPECT_SAYS(plan->left_over->message(), "the segments are 8 bytes");
  EXPECT_TRUE(plan_split(along(0, "1,1"), tensor(ElementType::UInt8, {3, 4}))->left_over);
}

TEST(SplitPicture, MapsToItsPartOfThePicture) {
  const auto input = tensor(ElementType::UInt8, {3, 8, 6});
  const SourceMap whole = picture_as_it_is(8, 6, false);
  const auto first_point = [&](const SplitRequest& request, size_t index) {
    const auto maps =
        make_source_maps(plan_split(request, input)->segments[index], input, {&whole, 1}, false);
    EXPECT_EQ(maps.size(), 1u);
    return maps.empty() ? SourceMap{} : maps[0];
  };
  const auto rows = first_point(line("3:8:2,3:8:4"), 1);
  EXPECT_EQ(rows.to_source({0, 0}).y, 2);
  EXPECT_EQ(rows.height, 4u);
  const auto columns = first_point(along(1, "5,3"), 1);
  EXPECT_EQ(columns.to_source({0, 0}).x, 5);
  EXPECT_EQ(columns.width, 3u);
  EXPECT_EQ(first_point(along(0, "1,1,1"), 2).to_source({4, 3}).x, 4);
}

TEST(SplitPicture, IsEmptyIfTheSegmentIsNotPartOfIt) {
  const auto input = tensor(ElementType::UInt8, {3, 8, 6});
  const SourceMap whole = picture_as_it_is(8, 6, false);
  const auto plan = plan_split(line("48,2:8:6"), input);
  for (const auto& segment : plan->segments)
    EXPECT_TRUE(make_source_maps(segment, input, {&whole, 1}, false).empty());
}

TEST(SplitPicture, OfABatchGoesWithItsRegions) {
  const auto input = tensor(ElementType::UInt8, {3, 8, 6, 3});
  std::vector<SourceMap> maps(3, picture_as_it_is(8, 6, false));
  for (size_t i = 0; i < 3; ++i) maps[i].x0 = static_cast<double>(10 * i);
  const auto regions = plan_split(along(3, "1,2"), input);
  const auto own = make_source_maps(regions->segments[1], input, maps, true);
  ASSERT_EQ(own.size(), 2u);
  EXPECT_EQ(own[0].x0, 10);
  const auto rows =
      make_source_maps(plan_split(along(2, "3,3"), input)->segments[1], input, maps, true);
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[2].to_source({0, 0}).y, 3);
  EXPECT_EQ(rows[2].to_source({0, 0}).x, 20);
  const std::span<const SourceMap> fewer(maps.data(), 2);
  EXPECT_EQ(make_source_maps(regions->segments[1], input, fewer, true).size(), 1u);
  EXPECT_TRUE(make_source_maps(regions->segments[1], input, fewer.first(1), true).empty());
}

}  // namespace segments_test
}  // namespace weir
