// tensor_crop: regions from results, in the picture's pixels; rows of numbers without columns.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_crop/crop_test_support.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir::test {
namespace crop_results_test {

Bytes make_rows(const std::vector<std::vector<float>>& rows, uint32_t columns) {
  Bytes out = make_header(ElementType::Float32, Shape{columns, static_cast<uint32_t>(rows.size())},
                          Format::Flexible);
  for (const auto& row : rows) {
    const auto* bytes = reinterpret_cast<const uint8_t*>(row.data());
    out.insert(out.end(), bytes, bytes + row.size() * sizeof(float));
  }
  return out;
}

// The element whose info pad receives results with these columns.
struct ResultCrop : ManyInputs {
  explicit ResultCrop(const std::string& columns, const char* raw = kRaw)
      : ManyInputs("tensor_crop") {
    add(raw, "raw");
    add((std::string(kInfo) + (columns.empty() ? "" : ",weir-columns=(string)\"" + columns + "\""))
            .c_str(),
        "info");
    play();
  }
  void push_both(Ref<GstBuffer> raw, Ref<GstBuffer> info) {
    auto first = push_later(0, std::move(raw));
    push(1, std::move(info));
    first.get();
  }
  void push_both(const std::vector<std::vector<float>>& rows, uint32_t columns) {
    push_both(make_buffer({picture()}, 0), make_buffer({make_rows(rows, columns)}, 0));
  }
};

constexpr char kDetections[] = "score,class,x1,y1,x2,y2";

TEST(CropResults, CutsTheBoxOfEachRow) {
  ResultCrop crop(kDetections);
  crop.push_both({{0.9f, 7, 1, 0, 3, 1}, {0, 0, 0, 0, 5, 4}, {0.8f, 7, 3, 1, 5, 3}}, 6);
  ASSERT_EQ(crop.buffers().size(), 1u) << crop.error();
  EXPECT_EQ(read_memories(crop.buffers()[0].get()),
            (std::vector<Bytes>{region({2, 2, 1}, {2, 3, 4, 5}),
                                region({2, 2, 2}, {16, 17, 18, 19, 26, 27, 28, 29})}))
      << "the second row is background";
  EXPECT_EQ(crop.stat("regions"), 2u);
  EXPECT_EQ(crop.stat("regions-empty"), 0u);
}

TEST(CropResults, NumberTheSourceMapsByRow) {
  ResultCrop crop(kDetections);
  auto raw = make_buffer({picture()}, 0);
  gst::set_source_maps(raw.get(), {picture_as_it_is(5, 4, false)});
  crop.push_both(raw, make_buffer({make_rows({{0, 0, 0, 0, 0, 0}, {1, 0, 1, 2, 4, 3}}, 6)}, 0));
  const auto maps = gst::source_maps(crop.buffers().at(0).get());
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_EQ(maps[0].row, 2u);
  EXPECT_DOUBLE_EQ(maps[0].to_source({0, 0}).x, 1);
  EXPECT_DOUBLE_EQ(maps[0].to_source({0, 0}).y, 2);
}

TEST(CropResults, MoveFromThePictureToTheTensor) {
  // The tensor 2:5:4 shows the picture of 50 x 80 from (10, 20) on: its pixels are 8 x 15 there.
  ResultCrop crop(kDetections);
  auto raw = make_buffer({picture()}, 0);
  gst::set_source_maps(raw.get(), {picture_as_it_is(50, 80, false).of_part(8, 10, 15, 20, 5, 4)});
  crop.push_both(raw, make_buffer({make_rows({{1, 0, 18, 20, 34, 35}}, 6)}, 0));
  EXPECT_EQ(read_memories(crop.buffers().at(0).get()),
            (std::vector<Bytes>{region({2, 2, 1}, {2, 3, 4, 5})}));
}

TEST(CropResults, MoveFromAPictureOfAnotherSize) {
  ResultCrop crop(kDetections);
  auto raw = make_buffer({picture()}, 0);
  gst::set_source_maps(raw.get(), {picture_as_it_is(5, 4, false)});
  auto info = make_buffer({make_rows({{1, 0, 100, 0, 300, 100}}, 6)}, 0);
  gst::set_source_maps(info.get(), {picture_as_it_is(500, 400, true)});
  crop.push_both(raw, info);
  EXPECT_EQ(read_memories(crop.buffers().at(0).get()),
            (std::vector<Bytes>{region({2, 2, 1}, {2, 3, 4, 5})}));
}

// The lower half of the picture has been cut off.
TEST(CropResults, StayWhereTheTensorMayBeAPart) {
  ResultCrop crop(kDetections);
  for (int i = 0; i < 2; ++i) {
    auto raw = make_buffer({picture()}, i);
    gst::set_source_maps(raw.get(), {picture_as_it_is(5, 4, false)});
    auto info = make_buffer({make_rows({{1, 0, 1, 0, 3, 1}}, 6)}, i);
    gst::set_source_maps(info.get(), {picture_as_it_is(5, 8, true)});
    crop.push_both(raw, info);
    EXPECT_EQ(read_memories(crop.buffers().at(i).get()),
              (std::vector<Bytes>{region({2, 2, 1}, {2, 3, 4, 5})}));
  }
  EXPECT_SAYS(crop.warning(), "results of a picture of 5 x 8");
  EXPECT_EQ(crop.warning(), "") << "once per stream";
}

TEST(CropResults, AreRoundedInTheTensorOnly) {
  ResultCrop crop(kDetections);
  auto raw = make_buffer({picture()}, 0);
  gst::set_source_maps(raw.get(), {picture_as_it_is(5, 4, false)});
  auto info = make_buffer({make_rows({{1, 0, 0.2f, 0.25f, 0.6f, 0.5f}}, 6)}, 0);
  gst::set_source_maps(info.get(), {picture_as_it_is(1, 1, true)});
  crop.push_both(raw, info);
  EXPECT_EQ(read_memories(crop.buffers().at(0).get()),
            (std::vector<Bytes>{region({2, 2, 1}, {12, 13, 14, 15})}));
}

TEST(CropResults, WithoutObjectsAreAGap) {
  ResultCrop crop(kDetections);
  crop.push_both({{0, 0, 0, 0, 0, 0}}, 6);
  EXPECT_TRUE(crop.buffers().empty());
  EXPECT_EQ(crop.error(), "");
  EXPECT_EQ(crop.events(GST_EVENT_GAP).size(), 1u);
}

TEST(CropResults, WithoutBoxesAreRefused) {
  ResultCrop labels("score,class");
  labels.push_both({{1, 0}}, 2);
  const auto without_boxes = labels.error();
  EXPECT_SAYS(without_boxes, "results without boxes");
  EXPECT_SAYS(without_boxes, "tensor_decoder mode=detection");
  ResultCrop other(kDetections);
  other.push_both({{1, 0, 3, 3}}, 4);
  const auto of_other_rows = other.error();
  EXPECT_SAYS(of_other_rows, "float32 4");
  EXPECT_SAYS(of_other_rows, "float32 6:N");
}

TEST(CropResults, OfPlanesAreRefused) {
  ResultCrop crop(kDetections);
  auto raw = make_buffer({picture()}, 0);
  gst::set_source_maps(raw.get(), {picture_as_it_is(2, 5, true)});
  crop.push_both(raw, make_buffer({make_rows({{1, 0, 0, 0, 1, 1}}, 6)}, 0));
  const auto error = crop.error();
  EXPECT_SAYS(error, "x is dimension 0");
  EXPECT_SAYS(error, "tensor_transform mode=transpose option=2:0:1:3");
}

TEST(CropResults, RowsWithoutColumnsAreNumbersWithAWarning) {
  ResultCrop crop("");
  for (int i = 0; i < 2; ++i) crop.push_both({{1, 0, 2, 1, 9, 0}, {3, 0, 2, 1, 9, 0}}, 6);
  ASSERT_EQ(crop.buffers().size(), 2u);
  EXPECT_EQ(read_memories(crop.buffers()[0].get())[0], region({2, 2, 1}, {2, 3, 4, 5}));
  EXPECT_SAYS(crop.warning(), "rows of 6 numbers are read as groups of 4");
  EXPECT_EQ(crop.warning(), "") << "once per stream";
}

}  // namespace crop_results_test
}  // namespace weir::test
