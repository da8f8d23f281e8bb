// Tests of tensor_to_roi: regions, their parameters, pairing, and regions that tensor_from_roi
// reads again.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/video/video.h>

#include <cmath>
#include <cstring>
#include <fstream>

#include "elements/tests/element_test_support.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"
#include "gstcpp/element/result_events.hpp"

namespace weir {
namespace tensor_to_roi_test {

using namespace weir::test;

std::string results(const std::string& columns, const std::string& dimensions,
                    const std::string& types = "float32", const std::string& source = "yolo") {
  return tensors(types, dimensions, "10/1") + ",weir-columns=(string)\"" + columns +
         "\",weir-source=(string)\"" + source + "\"";
}
constexpr char kColumns[] = "x1,y1,x2,y2,score,class,track,parent,rotation,xys:1";

// Both inputs; results are linked first because the first harness starts the element.
struct Both {
  Ref<GstElement> element;
  Harness results_in, pictures;

  explicit Both(const std::string& properties, const std::string& result_caps,
                const std::string& picture_caps = video("GRAY8", 64, 48))
      : element(lone_element("tensor_to_roi " + properties)) {
    results_in = Harness{gst_harness_new_with_element(element.get(), "results", nullptr)};
    pictures = Harness{gst_harness_new_with_element(element.get(), "sink", "src")};
    if (!result_caps.empty()) gst_harness_set_src_caps_str(results_in.get(), result_caps.c_str());
    gst_harness_set_src_caps_str(pictures.get(), picture_caps.c_str());
  }
  GstFlowReturn push_results(const std::vector<float>& numbers, GstClockTime time) const {
    return gst_harness_push(results_in.get(), frame(numbers, time));
  }
  Ref<GstBuffer> picture(GstClockTime time, GstBuffer* buffer = frame(Bytes(64 * 48))) const {
    GST_BUFFER_PTS(buffer) = time;
    EXPECT_EQ(gst_harness_push(pictures.get(), buffer), GST_FLOW_OK);
    return Ref<GstBuffer>::adopt(gst_harness_try_pull(pictures.get()));
  }
};

std::vector<GstVideoRegionOfInterestMeta*> get_metas(GstBuffer* buffer) {
  std::vector<GstVideoRegionOfInterestMeta*> out;
  gpointer state = nullptr;
  while (GstMeta* meta = gst_buffer_iterate_meta_filtered(
             buffer, &state, GST_VIDEO_REGION_OF_INTEREST_META_API_TYPE))
    out.push_back(reinterpret_cast<GstVideoRegionOfInterestMeta*>(meta));
  return out;
}
double number(const GstVideoRegionOfInterestMeta* meta, const char* structure, const char* field) {
  double out = NAN;
  const auto* params = gst_video_region_of_interest_meta_get_param(
      const_cast<GstVideoRegionOfInterestMeta*>(meta), structure);
  int integer = 0;
  if (!params) return NAN;
  if (gst_structure_get_int(params, field, &integer)) return integer;
  gst_structure_get_double(params, field, &out);
  return out;
}

const std::vector<float> kTwo{8,  12.5f, 32, 36.5f, 0.75f, 1, 7, -1, 0,     16, 24, 0.5f,  //
                              10, 14,    20, 22,    0.5f,  0, 0, 0,  0.25f, 11, 15, 1};

TEST(TensorToRoi, AttachesARegionForEachObject) {
  const std::string labels = testing::TempDir() + "weir-roi-labels.txt";
  std::ofstream(labels) << "cat\ndog\n";
  const Both both("labels=" + labels, results(kColumns, "12:2"));
  ASSERT_EQ(both.push_results(kTwo, 0), GST_FLOW_OK);
  const auto out = both.picture(0);
  const auto metas = get_metas(out.get());
  ASSERT_EQ(metas.size(), 2u);
  const auto* dog = metas[0];
  EXPECT_STREQ(g_quark_to_string(dog->roi_type), "dog");
  EXPECT_EQ(dog->x, 8u);
  EXPECT_EQ(dog->y, 12u);
  EXPECT_EQ(dog->w, 24u);
  EXPECT_EQ(dog->h, 25u);
  EXPECT_EQ(dog->parent_id, 0);
  EXPECT_EQ(number(dog, "detection", "confidence"), 0.75);
  EXPECT_EQ(number(dog, "detection", "score"), 0.75);
  EXPECT_EQ(number(dog, "detection", "label_id"), 1);
  EXPECT_DOUBLE_EQ(number(dog, "detection", "x_min"), 8 / 64.0);
  EXPECT_DOUBLE_EQ(number(dog, "detection", "y_max"), 36.5 / 48.0);
  EXPECT_EQ(number(dog, "object_id", "id"), 7);
  EXPECT_STREQ(g_quark_to_string(metas[1]->roi_type), "cat");
  EXPECT_EQ(metas[1]->parent_id, dog->id);
  EXPECT_NE(metas[1]->id, dog->id);
  EXPECT_EQ(number(metas[1], "weir", "rotation"), 0.25);
  EXPECT_TRUE(std::isnan(number(metas[1], "object_id", "id")));
  EXPECT_EQ(stat(both.element.get(), "regions-attached"), 2u);
}

TEST(TensorToRoi, IdsAreAboveThoseOfRegionsThatAreThere) {
  const Both both("", results(kColumns, "12:2"));
  ASSERT_EQ(both.push_results(kTwo, 0), GST_FLOW_OK);
  GstBuffer* buffer = frame(Bytes(64 * 48));
  gst_buffer_add_video_region_of_interest_meta(buffer, "other", 0, 0, 4, 4)->id = 41;
  const auto out = both.picture(0, buffer);
  const auto metas = get_metas(out.get());
  ASSERT_EQ(metas.size(), 3u);
  EXPECT_EQ(metas[1]->id, 42);
  EXPECT_EQ(metas[2]->parent_id, 42);
  EXPECT_STREQ(g_quark_to_string(metas[1]->roi_type), "1");  // no labels: the number
}

TEST(TensorToRoi, NamesRegionsByTheLabelsOfTheStream) {
  const Both both("", results(kColumns, "12:2"));
  const auto send = [&](const gst::LabelsOfSource& labels) {
    gst_harness_push_event(both.results_in.get(), gst::make_labels_event(labels).release());
  };
  send({"other", {"red", "blue"}});
  send({"yolo", {"cat", "dog"}});
  ASSERT_EQ(both.push_results(kTwo, 0), GST_FLOW_OK);
  const auto out = both.picture(0);
  const auto metas = get_metas(out.get());
  ASSERT_EQ(metas.size(), 2u);
  EXPECT_STREQ(g_quark_to_string(metas[0]->roi_type), "dog");
  EXPECT_STREQ(g_quark_to_string(metas[1]->roi_type), "cat");
}

TEST(TensorToRoi, LabelsAndTextsBecomeParametersOfTheirRegion) {
  const Both both("", results("x1,y1,x2,y2,score;score,class,parent;score,parent;text",
                              "5:1,3:2,2:1,4:1", "float32,float32,float32,uint8", "a;b;c;c"));
  GstBuffer* buffer = frame(std::vector<float>{0, 0, 8, 8, 1,            //
                                               0.5f, 3, 0, 0.5f, 3, -1,  //
                                               0.25f, 0},
                            0);
  gst_buffer_append_memory(buffer, make_memory({'a', 'b', 0xFF, 0}));
  ASSERT_EQ(gst_harness_push(both.results_in.get(), buffer), GST_FLOW_OK);
  const auto out = both.picture(0);
  const auto metas = get_metas(out.get());
  ASSERT_EQ(metas.size(), 1u);
  EXPECT_EQ(number(metas[0], "classification", "label_id"), 3);
  EXPECT_EQ(number(metas[0], "text", "confidence"), 0.25);
  EXPECT_STREQ(gst_structure_get_string(
                   gst_video_region_of_interest_meta_get_param(metas[0], "text"), "label"),
               "ab\xEF\xBF\xBD");
  EXPECT_EQ(stat(both.element.get(), "rows-without-region"), 1u);
}

TEST(TensorToRoi, RegionsLieInsideThePicture) {
  const Both both("", results("x1,y1,x2,y2,score", "5:4"));
  ASSERT_EQ(both.push_results({-9, -9, 3,  3, 1, 60, 40, 3e38f, 3e38f, 1,  //
                               64, 0,  99, 9, 1, 5,  5,  5,     5,     1},
                              0),
            GST_FLOW_OK);
  const auto out = both.picture(0);
  const auto metas = get_metas(out.get());
  ASSERT_EQ(metas.size(), 2u);
  EXPECT_EQ(metas[0]->x + metas[0]->w, 3u);
  EXPECT_EQ(metas[1]->w, 4u);
  EXPECT_EQ(metas[1]->h, 8u);
  EXPECT_EQ(stat(both.element.get(), "regions-outside"), 2u);
}

TEST(TensorToRoi, ResultsOfAPictureOfAnotherSizeAreScaled) {
  const Both both("sync=newest", results(kColumns, "12:2"));
  GstBuffer* found = frame(kTwo, 0);
  gst::set_source_maps(found, {picture_as_it_is(128, 96, false)});
  ASSERT_EQ(gst_harness_push(both.results_in.get(), found), GST_FLOW_OK);
  for (const GstClockTime time : {0, 1}) {
    const auto out = both.picture(time);
    const auto metas = get_metas(out.get());
    ASSERT_EQ(metas.size(), 2u);
    EXPECT_EQ(metas[0]->x, 4u);
    EXPECT_EQ(metas[0]->y, 6u);
    EXPECT_EQ(metas[0]->w, 12u);
    EXPECT_EQ(metas[0]->h, 13u);
    EXPECT_EQ(number(metas[0], "detection", "y_max"), 36.5 / 96);
    EXPECT_EQ(metas[1]->parent_id, metas[0]->id);
  }
}

TEST(TensorToRoi, SharedBuffersAreNotChanged) {
  const Both both("", results(kColumns, "12:2"));
  ASSERT_EQ(both.push_results(kTwo, 0), GST_FLOW_OK);
  const auto kept = Ref<GstBuffer>::adopt(frame(Bytes(64 * 48), 0));
  const auto out = both.picture(0, gst_buffer_ref(kept.get()));
  EXPECT_TRUE(get_metas(kept.get()).empty());
  EXPECT_EQ(get_metas(out.get()).size(), 2u);
  EXPECT_EQ(gst_buffer_peek_memory(out.get(), 0), gst_buffer_peek_memory(kept.get(), 0));
}

TEST(TensorToRoi, PicturesWithoutResultsOfTheirTimePassAsTheyAre) {
  const Both both("max-wait=0", results(kColumns, "12:2"));
  ASSERT_EQ(both.push_results(kTwo, 5), GST_FLOW_OK);
  EXPECT_TRUE(get_metas(both.picture(0).get()).empty());
  EXPECT_EQ(get_metas(both.picture(5).get()).size(), 2u);
  EXPECT_TRUE(get_metas(both.picture(6).get()).empty());
  EXPECT_EQ(stat(both.element.get(), "results-used"), 1u);
  EXPECT_EQ(stat(both.element.get(), "received"), 3u);
  EXPECT_EQ(stat(both.element.get(), "consumed"), 3u);
}

TEST(TensorToRoi, RefusesStreamsAndFramesThatAreNotResults) {
  const Both both("", "");
  Errors errors(both.element.get());
  gst_harness_set_src_caps_str(both.results_in.get(), results("x1,y1", "2:1").c_str());
  EXPECT_SAYS(errors.next(), "WEIR-1001");
  gst_harness_set_src_caps_str(both.results_in.get(), results(kColumns, "5:1").c_str());
  EXPECT_SAYS(errors.next(), "WEIR-2001: a tensor of results does not match weir-columns");
  EXPECT_SAYS(start_error("tensor_to_roi labels=/nonexistent.txt"), "WEIR-4001");
}

TEST(TensorToRoi, FromRoiReadsBackTheSameRows) {
  const Both both("", results(kColumns, "12:2"));
  ASSERT_EQ(both.push_results(kTwo, 0), GST_FLOW_OK);
  const auto with_regions = both.picture(0);
  const auto h = make_harness("tensor_from_roi keypoints=1", video("GRAY8", 64, 48));
  auto out =
      Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), gst_buffer_ref(with_regions.get())));
  ASSERT_TRUE(out);
  const auto bytes = content(out.get());
  std::vector<float> numbers((bytes.size() - 128) / sizeof(float));
  std::memcpy(numbers.data(), bytes.data() + 128, numbers.size() * sizeof(float));
  ASSERT_EQ(numbers.size(), kTwo.size());
  for (size_t i = 0; i < kTwo.size(); ++i) EXPECT_NEAR(numbers[i], kTwo[i], 1e-4) << i;
}

}  // namespace tensor_to_roi_test
}  // namespace weir
