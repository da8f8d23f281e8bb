// Tests of reading frames of results, valid and not.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/result_frame.hpp"

#include <cmath>

#include "core/records/records_test_support.hpp"
#include "says.hpp"

namespace weir::records {
namespace result_frame_test {

ResultFrame read(const ResultReader& reader, const TestFrame& frame) {
  ResultFrame out;
  const Status status = reader.read(frame.tensors, &out);
  EXPECT_TRUE(status) << (status ? "" : status.error().message());
  return out;
}
std::string error_of(const std::string& columns, const TestFrame& frame) {
  ResultFrame out;
  const auto reader = ResultReader::make(columns, "");
  if (!reader) return reader.error().message();
  const Status status = reader->read(frame.tensors, &out);
  return status ? "" : status.error().message();
}

TEST(ResultFrame, HasTheRowsThatAreNotBackground) {
  const auto frame =
      read(reader_of("class,score,x1,y1,x2,y2,extra:2,track,xys:2"),
           TestFrame().floats("15:2", {3, 0.5f, 1, 2, 3, 4, 9, 9, 7, 1, 2, 0.25f, 3, 4, 0.75f,  //
                                       3, 0,    1, 2, 3, 4, 9, 9, 7, 1, 2, 0.25f, 3, 4, 0.75f}));
  ASSERT_EQ(frame.objects.size(), 1u);
  const ResultObject& object = frame.objects[0];
  EXPECT_TRUE(object.has_box);
  EXPECT_EQ(object.box, (Box{1, 2, 3, 4}));
  EXPECT_EQ(object.score, 0.5f);
  EXPECT_EQ(object.class_index, 3);
  EXPECT_EQ(object.track, 7u);
  EXPECT_EQ(object.parent, -1);
  ASSERT_EQ(object.n_points, 2u);
  EXPECT_EQ(frame.points[1], (results::KeyPoint{3, 4, 0.75f}));
}

TEST(ResultFrame, ParentsAreObjectsAndNotRows) {
  // Rows 0 (background) and 1; then rows 2 to 5 of the second tensor.
  const auto frame = read(reader_of(std::string(kBoxes) + ";score,class,parent", "a;b"),
                          TestFrame()
                              .floats("6:2", {0, 0, 0, 0, 0, 0, 1, 1, 5, 5, 1, 2})
                              .floats("3:4", {1, 8, 1, 1, 8, 0, 1, 8, 99, 1, 8, 5}));
  ASSERT_EQ(frame.objects.size(), 5u);
  EXPECT_EQ(frame.objects[1].parent, 0);   // row 1
  EXPECT_EQ(frame.objects[2].parent, -1);  // background
  EXPECT_EQ(frame.objects[3].parent, -1);  // there is no row 99
  EXPECT_EQ(frame.objects[4].parent, -1);  // itself
}

TEST(ResultFrame, TablesBelongToTheRowsBeforeThem) {
  const auto reader = reader_of(std::string(kBoxes) + ";masks;score;text", "yolo;yolo;ocr;ocr");
  EXPECT_EQ(reader.sources(), (std::vector<std::string>{"yolo", "ocr"}));
  ASSERT_EQ(reader.groups().size(), 2u);
  EXPECT_EQ(reader.groups()[0].kind(), RowKind::Detection);
  EXPECT_EQ(reader.groups()[1].kind(), RowKind::Text);
  EXPECT_EQ(reader.groups()[1].source, 1u);
  const TestFrame tensors = TestFrame()
                                .floats("6:2", {0, 0, 9, 9, 0, 0, 1, 1, 5, 5, 1, 2})
                                .bytes("2:1:2", {1, 2, 3, 4})
                                .floats("1:2", {0.5f, 0.75f})
                                .texts(4, {"ab", "wxyz"});
  const auto frame = read(reader, tensors);
  ASSERT_EQ(frame.objects.size(), 3u);
  EXPECT_EQ(frame.objects[0].mask.width, 2u);
  EXPECT_EQ(frame.objects[0].mask.values[0], std::byte{3});
  EXPECT_EQ(frame.objects[1].text, "ab");
  EXPECT_EQ(frame.objects[2].text, "wxyz");
}

TEST(ResultFrame, RowsWithoutColumnsAreThoseOfDetectionHpp) {
  const auto reader = reader_of("");
  EXPECT_EQ(read(reader, TestFrame().floats("4:1", {1, 2, 3, 4})).objects[0].score, 1);
  const auto frame = read(reader, TestFrame().floats("8:1", {1, 2, 3, 4, 0.5f, 6, 7, 8}));
  ASSERT_EQ(frame.objects.size(), 1u);
  EXPECT_EQ(frame.objects[0].class_index, 6);
  EXPECT_EQ(frame.points[0], (results::KeyPoint{7, 8, 1}));
  expect_says(error_of("", TestFrame().floats("3:1", {1, 2, 3})), {"WEIR-2001", "float32 3:1"});
  expect_says(error_of("", TestFrame().floats("4:1", {1, 2, 3, 4}).floats("1", {1})),
              {"a stream of several tensors does not define which of them are results",
               "weir-columns", "fix: tensor_decoder mode=detection"});
}

TEST(ResultFrame, LeavesOutRowsThatAreNotFinite) {
  const float nan = NAN, inf = INFINITY;
  const auto frame = read(reader_of(std::string(kBoxes) + ",rotation"),
                          TestFrame().floats("7:6", {0,      0, 1,     1, nan,  0,   0,    //
                                                     nan,    0, 1,     1, 0.5f, 0,   0,    //
                                                     0,      0, 1,     1, inf,  0,   0,    //
                                                     -3e38f, 0, 3e38f, 1, 0.5f, 0,   0,    //
                                                     0,      0, 1,     1, 0.5f, nan, inf,  //
                                                     0,      0, 1,     1, -1,   0,   0}));
  ASSERT_EQ(frame.objects.size(), 1u);
  EXPECT_EQ(frame.objects[0].class_index, 0);
  EXPECT_EQ(frame.objects[0].rotation, 0);
  EXPECT_EQ(frame.rows_not_finite, 3u);  // NaN as a score is background
}

TEST(ResultFrame, RefusesColumnsThatCannotBeRead) {
  expect_says(error_of("x1,x2,y1,y2", {}),
              {"WEIR-1001", "the columns of a stream of results cannot be read",
               "offered: weir-columns=\"x1,x2,y1,y2\"", "the entry of tensor 0"});
  expect_says(error_of("masks;score", {}), {"a table of results has no rows before it"});
  expect_says(error_of(std::string(300, ';'), {}),
              {"weir-columns names more tensors than a frame has"});
}

TEST(ResultFrame, RefusesTensorsThatAreNotWhatTheColumnsSay) {
  const std::vector<float> twelve(12);
  expect_says(error_of(kBoxes, TestFrame().floats("5:2", std::vector<float>(10))),
              {"WEIR-2001", "a tensor of results does not match weir-columns",
               "offered: float32 5:2", "needed: float32 6:N"});
  expect_says(error_of(kBoxes, TestFrame().floats("6:1:2", twelve)), {"offered: float32 6:1:2"});
  expect_says(error_of(kBoxes, TestFrame().add(ElementType::Int32, "6:2", twelve)),
              {"offered: int32 6:2"});
  expect_says(error_of(std::string(kBoxes) + ";text", TestFrame().floats("6:2", twelve)),
              {"a frame has fewer tensors than weir-columns names", "offered: 1 tensors"});
  expect_says(
      error_of(std::string(kBoxes) + ";text", TestFrame().floats("6:2", twelve).texts(4, {"one"})),
      {"an entry for each of 2 rows of tensor 0", "tensor 1"});
  expect_says(error_of(std::string(kBoxes) + ";masks",
                       TestFrame().floats("6:2", twelve).bytes("2:2:3", std::vector<uint8_t>(12))),
              {"an entry for each of 2 rows"});
  expect_says(error_of(std::string(kBoxes) + ";scores",
                       TestFrame().floats("6:2", twelve).bytes("2:2", std::vector<uint8_t>(4))),
              {"float32 C:N, scores for each row"});
  expect_says(error_of("class-map", TestFrame().floats("2:2", {1, 2, 3, 4})), {"uint8 or uint16"});
  expect_says(error_of("depth", TestFrame().bytes("2:2", std::vector<uint8_t>(4))),
              {"the depth of each pixel"});
}

TEST(ResultFrame, RefusesTensorsThatAreShorterThanTheirShape) {
  expect_says(error_of(kBoxes, TestFrame().floats("6:3", std::vector<float>(12))),
              {"WEIR-2004", "a tensor of results is shorter than its shape requires",
               "offered: 48 bytes", "needed: 72 bytes for float32 6:3"});
  // 2^32 - 1 rows of 4 bytes are not there.
  expect_says(error_of("score", TestFrame().floats("1:4294967295", {1})), {"offered: 4 bytes"});
}

TEST(ResultFrame, ReadsAHundredThousandRowsAndNoTensorTwice) {
  std::vector<float> rows(600000);
  for (size_t i = 0; i < 100000; ++i) rows[i * 6 + 2] = rows[i * 6 + 3] = rows[i * 6 + 4] = 1;
  EXPECT_EQ(read(reader_of(kBoxes), TestFrame().floats("6:100000", rows)).objects.size(), 100000u);
}

}  // namespace result_frame_test
}  // namespace weir::records
