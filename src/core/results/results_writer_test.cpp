// Tests of the tensors that results are written as.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/results/results_writer.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <list>

#include "core/tensor/tensor_header.hpp"
#include "weir/module.hpp"
#include "weir/results.hpp"

namespace weir::results {
namespace results_writer_test {

struct Written {
  TensorHeader header;
  std::vector<std::byte> payload;

  std::vector<float> floats() const {
    std::vector<float> out(payload.size() / sizeof(float));
    std::memcpy(out.data(), payload.data(), payload.size());
    return out;
  }
};

std::vector<Written> written(const FrameResults& results, const Features& features) {
  std::list<std::vector<std::byte>> memories;
  write(results, features, [&](size_t bytes) {
    memories.emplace_back(bytes, std::byte{0xAA});
    return std::span(memories.back());
  });
  std::vector<Written> out;
  for (const auto& memory : memories) {
    auto header = read_tensor_chunk(memory);
    EXPECT_TRUE(header);
    if (!header) continue;
    EXPECT_EQ(memory.size(), kTensorHeaderBytes + header->payload_bytes().value_or(0));
    out.push_back({*header, {memory.begin() + kTensorHeaderBytes, memory.end()}});
  }
  return out;
}

TEST(ResultsWriter, WritesARowForEachObject) {
  FrameResults results;
  results.objects = {{.box = {1, 2, 3, 4}, .score = 0.5f, .class_index = 6, .track = 7},
                     {.box = {5, 6, 7, 8}, .score = 0.25f, .parent = 0, .rotation = 1}};
  results.points_per_object = 1;
  results.points = {{10, 11, 0.5f}, {12, 13, 0.75f}};
  const Features features{.points_per_object = 1};
  const auto tensors = written(results, features);
  ASSERT_EQ(tensors.size(), 1u);
  EXPECT_EQ(tensors[0].header.spec.to_string(), "float32 12:2");
  EXPECT_EQ(tensors[0].floats(),
            (std::vector<float>{1, 2, 3, 4, 0.5f,  6, 7, -1, 0, 10, 11, 0.5f,  //
                                5, 6, 7, 8, 0.25f, 0, 0, 0,  1, 12, 13, 0.75f}));
}

TEST(ResultsWriter, ColumnsDescribeTheRows) {
  for (const bool boxes : {false, true})
    for (const size_t points : {0, 1, 17}) {
      const Features features{.has_boxes = boxes, .points_per_object = points};
      const auto columns = result_columns(make_columns(features), 0);
      ASSERT_TRUE(columns);
      FrameResults results;
      results.objects = {{.box = {1, 2, 3, 4}, .score = 0.5f, .class_index = 9, .parent = 3}};
      results.points.assign(points, {20, 30, 0.125f});
      const auto numbers = written(results, features)[0].floats();
      ASSERT_EQ(numbers.size(), columns->length);
      const ResultRow row(*columns, numbers.data());
      EXPECT_EQ(row.has_box(), boxes);
      EXPECT_EQ(row.class_index(), 9);
      EXPECT_EQ(row.parent(), 3);
      ASSERT_EQ(row.n_points(), points);
      for (uint32_t i = 0; i < points; ++i) {
        EXPECT_EQ(row.x(i), 20);
        EXPECT_EQ(row.point_score(i), 0.125f);
      }
    }
}

TEST(ResultsWriter, AFrameWithoutObjectsHasOneRowOfZeros) {
  const Features features{
      .points_per_object = 2, .has_masks = true, .has_class_scores = true, .has_texts = true};
  const auto tensors = written({}, features);
  ASSERT_EQ(tensors.size(), 4u);
  EXPECT_EQ(tensors[0].floats(), std::vector<float>(9 + 6, 0.0f));
  EXPECT_EQ(tensors[1].header.spec.to_string(), "uint8 1:1:1");
  EXPECT_EQ(tensors[1].payload, std::vector<std::byte>(1));
  EXPECT_EQ(tensors[2].floats(), std::vector<float>(1));
  EXPECT_EQ(tensors[3].payload, std::vector<std::byte>(1));
}

TEST(ResultsWriter, WritesTheTablesInTheOrderOfTheColumns) {
  const Features features{.has_boxes = false,
                          .has_masks = true,
                          .has_class_scores = true,
                          .has_texts = true,
                          .has_class_map = true,
                          .has_depth = true};
  EXPECT_EQ(make_columns(features), "score,class,track,parent;masks;scores;text;class-map;depth");
  FrameResults results;
  results.objects = {{.score = 1}, {.score = 0.5f}};
  results.mask_width = 2, results.mask_height = 1;
  results.masks = {1, 2, 3, 4};
  results.n_classes = 3;
  results.class_scores = {1, 2, 3, 4, 5, 6};
  results.texts = {
      "\xC3\xBC"
      "ber",
      "ab"};
  results.map_width = 2, results.map_height = 1;
  results.class_map = {300, 2};
  results.depth = {0.5f, 1.5f};
  const auto tensors = written(results, features);
  ASSERT_EQ(tensors.size(), tensor_count(features));
  EXPECT_EQ(tensors[1].header.spec.to_string(), "uint8 2:1:2");
  EXPECT_EQ(tensors[2].header.spec.to_string(), "float32 3:2");
  EXPECT_EQ(tensors[3].header.spec.to_string(), "uint8 5:2");
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(tensors[3].payload.data()), 10),
            std::string("\xC3\xBC"
                        "berab\0\0\0",
                        10));
  EXPECT_EQ(tensors[4].header.spec.to_string(), "uint16 2:1");
  EXPECT_EQ(tensors[5].floats(), results.depth);
}

TEST(ResultsWriter, CapsNameColumnsAndSource) {
  EXPECT_EQ(make_caps({.has_masks = true}, "yolo;\"x\""),
            "other/tensors,format=(string)flexible,weir-columns=(string)"
            "\"x1,y1,x2,y2,score,class,track,parent,rotation;masks\","
            "weir-source=(string)\"yolo__x_;yolo__x_\"");
}

TEST(Append, JoinsTablesAndResamplesMasks) {
  const Features features{.has_masks = true, .has_texts = true};
  FrameResults all, first, second;
  first.objects = {{.score = 1}};
  first.texts = {"a"};
  first.mask_width = first.mask_height = 1;
  first.masks = {9};
  second.objects = {{.score = 0.5f}};
  second.texts = {"b"};
  second.mask_width = second.mask_height = 2;
  second.masks = {1, 2, 3, 4};
  append(&first, features, &all);
  append(&second, features, &all);
  EXPECT_EQ(all.objects.size(), 2u);
  EXPECT_EQ(all.texts, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(all.mask_width, 2u);
  EXPECT_EQ(all.masks, (std::vector<uint8_t>{9, 9, 9, 9, 1, 2, 3, 4}));
}

TEST(Append, RejectsASecondMap) {
  const Features features{.has_class_map = true};
  FrameResults all, part;
  part.map_width = part.map_height = 1;
  part.class_map = {1};
  FrameResults again = part;
  append(&part, features, &all);
  EXPECT_THROW(append(&again, features, &all), Failure);
}

}  // namespace results_writer_test
}  // namespace weir::results
