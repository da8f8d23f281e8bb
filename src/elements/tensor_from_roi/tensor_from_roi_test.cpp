// Tests of tensor_from_roi: regions as other elements write them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/video/video.h>

#include <cmath>
#include <cstring>
#include <fstream>

#include "core/tensor/tensor_header.hpp"
#include "elements/tests/element_test_support.hpp"
#include "gstcpp/buffer/analytics_meta.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir {
namespace tensor_from_roi_test {

using namespace weir::test;

struct Rows {
  Shape shape;
  std::vector<float> numbers;
};
Rows read_rows(GstBuffer* buffer) {
  Rows out;
  const Bytes bytes = content(buffer);
  const auto header = read_tensor_chunk(std::as_bytes(std::span(bytes)));
  EXPECT_TRUE(header);
  if (!header) return out;
  EXPECT_EQ(header->spec.type, ElementType::Float32);
  out.shape = header->spec.shape;
  out.numbers.resize((bytes.size() - kTensorHeaderBytes) / sizeof(float));
  std::memcpy(out.numbers.data(), bytes.data() + kTensorHeaderBytes,
              out.numbers.size() * sizeof(float));
  return out;
}
GstBuffer* picture() {
  return frame(Bytes(64 * 48), 7, 3);
}
Rows pushed(const Harness& h, GstBuffer* in) {
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 7u);
  EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 3u);
  return read_rows(out.get());
}
GstVideoRegionOfInterestMeta* region(GstBuffer* buffer, const char* label) {
  return gst_buffer_add_video_region_of_interest_meta(buffer, label, 8, 12, 24, 25);
}
using Floats = std::vector<float>;

TEST(TensorFromRoi, ReadsTheParametersOfDlStreamer) {
  const auto h = make_harness("tensor_from_roi", video("GRAY8", 64, 48));
  GstBuffer* in = picture();
  auto* meta = region(in, "dog");
  gst_video_region_of_interest_meta_add_param(
      meta, gst_structure_from_string(
                "detection, label_id=(int)16, confidence=(double)0.75, x_min=(double)0.125, "
                "y_min=(double)0.265625, x_max=(double)0.5, y_max=(double)0.765625;",
                nullptr));
  gst_video_region_of_interest_meta_add_param(
      meta, gst_structure_from_string("object_id, id=(int)7;", nullptr));
  const Rows rows = pushed(h, in);
  EXPECT_EQ(rows.shape, (Shape{9, 1}));
  EXPECT_EQ(rows.numbers, (Floats{8, 12.75f, 32, 36.75f, 0.75f, 16, 7, -1, 0}));
  EXPECT_SAYS(caps_text(h), "weir-columns=(string)");
  EXPECT_SAYS(caps_text(h), "x1\\,y1\\,x2\\,y2\\,score\\,class\\,track\\,parent\\,rotation");
  EXPECT_SAYS(caps_text(h), "weir-source=(string)roi");
  EXPECT_SAYS(caps_text(h), "framerate=(fraction)10/1");
}

TEST(TensorFromRoi, PositionsOfAnotherPictureDoNotCount) {
  const auto h = make_harness("tensor_from_roi", video("GRAY8", 64, 48));
  GstBuffer* in = picture();
  gst_video_region_of_interest_meta_add_param(
      region(in, "dog"),
      gst_structure_from_string("detection, x_min=(double)0.5, y_min=(double)0.5, "
                                "x_max=(double)0.9, y_max=(double)0.9;",
                                nullptr));
  EXPECT_EQ(pushed(h, in).numbers, (Floats{8, 12, 32, 37, 1, 0, 0, -1, 0}));
}

TEST(TensorFromRoi, LabelsGiveClassesWhereThereIsNoNumber) {
  const std::string labels = testing::TempDir() + "weir-from-roi-labels.txt";
  std::ofstream(labels) << "cat\ndog\n";
  const auto h = make_harness("tensor_from_roi labels=" + labels, video("GRAY8", 64, 48));
  GstBuffer* in = picture();
  region(in, "dog");
  region(in, "cow");
  const Rows rows = pushed(h, in);
  EXPECT_EQ(rows.shape, (Shape{9, 2}));
  EXPECT_EQ(rows.numbers[5], 1);
  EXPECT_EQ(rows.numbers[14], 0);
}

TEST(TensorFromRoi, ParentsAreRows) {
  const auto h = make_harness("tensor_from_roi threshold=0.5", video("GRAY8", 64, 48));
  GstBuffer* in = picture();
  auto* weak = region(in, "weak");
  weak->id = 5;
  gst_video_region_of_interest_meta_add_param(
      weak, gst_structure_from_string("detection, confidence=(double)0.25;", nullptr));
  auto* child = region(in, "child");
  child->id = 9, child->parent_id = 11;
  auto* parent = region(in, "parent");
  parent->id = 11, parent->parent_id = 5;
  const Rows rows = pushed(h, in);
  EXPECT_EQ(rows.shape, (Shape{9, 2}));
  EXPECT_EQ(rows.numbers[7], 1);    // the second row
  EXPECT_EQ(rows.numbers[16], -1);  // its parent is below the threshold
}

TEST(TensorFromRoi, APictureWithoutRegionsIsOneRowOfZeros) {
  const auto h = make_harness("tensor_from_roi keypoints=2", video("GRAY8", 64, 48));
  const Rows rows = pushed(h, picture());
  EXPECT_EQ(rows.shape, (Shape{15, 1}));
  EXPECT_EQ(rows.numbers, Floats(15));
}

TEST(TensorFromRoi, ParametersOfOtherTypesAreIgnored) {
  const auto h = make_harness("tensor_from_roi keypoints=1", video("GRAY8", 64, 48));
  GstBuffer* in = picture();
  auto* meta = region(in, "");
  for (const char* text :
       {"detection, confidence=(string)high, label_id=(double)4, x_min=(string)a;",
        "object_id, id=(string)seven;", "weir, box=<1.0, 2.0>, keypoints=<a, b, c>;"})
    gst_video_region_of_interest_meta_add_param(meta, gst_structure_from_string(text, nullptr));
  auto* negative = region(in, "x");
  gst_video_region_of_interest_meta_add_param(
      negative, gst_structure_from_string("object_id, id=(int)-3;", nullptr));
  gst_buffer_add_video_region_of_interest_meta(in, "empty", 3, 3, 0, 0);
  const Rows rows = pushed(h, in);
  EXPECT_EQ(rows.shape, (Shape{12, 2}));
  EXPECT_EQ(rows.numbers, (Floats{8, 12, 32, 37, 1, 0, 0, -1, 0, 0, 0, 0,  //
                                  8, 12, 32, 37, 1, 0, 0, -1, 0, 0, 0, 0}));
}

TEST(TensorFromRoi, TheSourceMapIsThatOfThePicture) {
  const auto h = make_harness("tensor_from_roi", video("GRAY8", 64, 48));
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), picture()));
  const auto maps = gst::source_maps(out.get());
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_EQ(maps[0].source_width, 64u);
  EXPECT_EQ(maps[0].source_height, 48u);
}

TEST(TensorFromRoi, RefusesMasksAndClassMapsThatGstreamerDoesNotHave) {
  if (gst::kHasSegmentation) GTEST_SKIP() << "this GStreamer has segmentation";
  for (const char* setting : {"masks=true", "class-map=true"})
    EXPECT_SAYS(start_error(std::string("tensor_from_roi ") + setting),
                std::string("WEIR-1004: ") + setting + " needs segmentation as metadata");
  EXPECT_EQ(start_error("tensor_from_roi masks=false class-map=false"), "");  // the fix
}

TEST(TensorFromRoi, RefusesLabelsThatDoNotExist) {
  EXPECT_SAYS(start_error("tensor_from_roi labels=/nonexistent.txt"), "WEIR-4001");
}

}  // namespace tensor_from_roi_test
}  // namespace weir
