// Tests of results as GstAnalyticsRelationMeta: what tensor_to_roi writes, what tensor_from_roi
// reads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"  // a flexible array
#include <gst/analytics/analytics.h>
#pragma GCC diagnostic pop
#include <gst/video/video.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <tuple>

#include "elements/tests/element_test_support.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir {
namespace analytics_test {

using namespace weir::test;
using Floats = std::vector<float>;

constexpr char kColumns[] = "x1,y1,x2,y2,score,class,track,parent,rotation";
// A dog with a track, and a cat that is part of it and rotated.
const Floats kTwo{8,  12.5f, 32, 36.5f, 0.75f, 1, 7, -1, 0,  //
                  10, 14,    20, 22,    0.5f,  0, 0, 0,  0.25f};

std::string results(const std::string& columns, const std::string& dimensions,
                    const std::string& types = "float32") {
  std::string sources = "a";
  for (const char c : columns)
    if (c == ';') sources += ";a";
  return tensors(types, dimensions, "10/1") + ",weir-columns=(string)\"" + columns +
         "\",weir-source=(string)\"" + sources + "\"";
}
std::string write_labels(const char* lines = "cat\ndog\n") {
  const std::string path = testing::TempDir() + "weir-analytics-labels.txt";
  std::ofstream(path) << lines;
  return path;
}

// tensor_to_roi with results of one frame.
struct ToRoi {
  Ref<GstElement> element;
  Harness results_in, pictures;

  ToRoi(const std::string& properties, const std::string& result_caps, GstBuffer* found)
      : element(lone_element("tensor_to_roi " + properties)) {
    results_in = Harness{gst_harness_new_with_element(element.get(), "results", nullptr)};
    pictures = Harness{gst_harness_new_with_element(element.get(), "sink", "src")};
    gst_harness_set_src_caps_str(results_in.get(), result_caps.c_str());
    gst_harness_set_src_caps_str(pictures.get(), video("GRAY8", 64, 48).c_str());
    EXPECT_EQ(gst_harness_push(results_in.get(), found), GST_FLOW_OK);
  }
  Ref<GstBuffer> picture(GstBuffer* buffer = frame(Bytes(64 * 48))) const {
    GST_BUFFER_PTS(buffer) = 0;
    EXPECT_EQ(gst_harness_push(pictures.get(), buffer), GST_FLOW_OK);
    return Ref<GstBuffer>::adopt(gst_harness_try_pull(pictures.get()));
  }
};

std::vector<GstAnalyticsMtd> entries(GstAnalyticsRelationMeta* meta, GstAnalyticsMtdType type) {
  std::vector<GstAnalyticsMtd> out;
  gpointer state = nullptr;
  GstAnalyticsMtd entry{};
  while (gst_analytics_relation_meta_iterate(meta, &state, type, &entry)) out.push_back(entry);
  return out;
}
std::vector<GstAnalyticsMtd> objects(GstBuffer* buffer) {
  return entries(gst_buffer_get_analytics_relation_meta(buffer),
                 gst_analytics_od_mtd_get_mtd_type());
}
std::vector<GstAnalyticsMtd> related(const GstAnalyticsMtd& from, GstAnalyticsRelTypes types,
                                     GstAnalyticsMtdType type) {
  std::vector<GstAnalyticsMtd> out;
  gpointer state = nullptr;
  GstAnalyticsMtd entry{};
  while (gst_analytics_relation_meta_get_direct_related(from.meta, from.id, types, type, &state,
                                                        &entry))
    out.push_back(entry);
  return out;
}
struct Object {
  std::string label;
  int x = 0, y = 0, width = 0, height = 0;
  float rotation = 0, score = 0;
  bool operator==(const Object&) const = default;
};
Object read(const GstAnalyticsMtd& entry) {
  Object out;
  out.label = g_quark_to_string(gst_analytics_od_mtd_get_obj_type(&entry));
  gst_analytics_od_mtd_get_oriented_location(&entry, &out.x, &out.y, &out.width, &out.height,
                                             &out.rotation, &out.score);
  return out;
}

TEST(AnalyticsWritten, ObjectsHaveTheirLabelBoxScoreAndRotation) {
  const ToRoi to("labels=" + write_labels(), results(kColumns, "9:2"), frame(kTwo, 0));
  const auto out = to.picture();
  const auto found = objects(out.get());
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(read(found[0]), (Object{"dog", 8, 12, 24, 25, 0, 0.75f}));
  EXPECT_EQ(read(found[1]), (Object{"cat", 10, 14, 10, 8, 0.25f, 0.5f}));
  int id = -1;
  auto* region = gst_buffer_get_video_region_of_interest_meta_id(out.get(), 1);
  gst_structure_get_int(gst_video_region_of_interest_meta_get_param(region, "weir"), "analytics-id",
                        &id);
  EXPECT_EQ(static_cast<guint>(id), found[0].id);
  const auto parents =
      related(found[1], GST_ANALYTICS_REL_TYPE_IS_PART_OF, gst_analytics_od_mtd_get_mtd_type());
  ASSERT_EQ(parents.size(), 1u);
  EXPECT_EQ(parents[0].id, found[0].id);
  EXPECT_EQ(
      related(found[0], GST_ANALYTICS_REL_TYPE_CONTAIN, gst_analytics_od_mtd_get_mtd_type()).size(),
      1u);
}

TEST(AnalyticsWritten, TracksKnowWhenTheyWereSeen) {
  const ToRoi to("sync=newest", results(kColumns, "9:2"), frame(kTwo, 0));
  for (const GstClockTime time : {100, 300}) {
    GstBuffer* in = frame(Bytes(64 * 48), time);
    ASSERT_EQ(gst_harness_push(to.pictures.get(), in), GST_FLOW_OK);
    const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(to.pictures.get()));
    const auto tracks = related(objects(out.get())[0], GST_ANALYTICS_REL_TYPE_RELATE_TO,
                                gst_analytics_tracking_mtd_get_mtd_type());
    ASSERT_EQ(tracks.size(), 1u);
    guint64 id = 0;
    GstClockTime first = 0, last = 0;
    gboolean is_lost = TRUE;
    ASSERT_TRUE(gst_analytics_tracking_mtd_get_info(&tracks[0], &id, &first, &last, &is_lost));
    EXPECT_EQ(id, 7u);
    EXPECT_EQ(first, 100u);
    EXPECT_EQ(last, time);
    EXPECT_FALSE(is_lost);
  }
}

TEST(AnalyticsWritten, AfterASeekTracksAreSeenForTheFirstTime) {
  const ToRoi to("sync=newest max-age=0", results(kColumns, "9:2"), frame(kTwo, 500));
  const auto first_seen = [&](GstClockTime time) {
    EXPECT_EQ(gst_harness_push(to.pictures.get(), frame(Bytes(64 * 48), time)), GST_FLOW_OK);
    const auto out = Ref<GstBuffer>::adopt(gst_harness_pull(to.pictures.get()));
    const auto tracks = entries(gst_buffer_get_analytics_relation_meta(out.get()),
                                gst_analytics_tracking_mtd_get_mtd_type());
    guint64 id = 0;
    GstClockTime first = GST_CLOCK_TIME_NONE, last = 0;
    gboolean is_lost = TRUE;
    if (!tracks.empty())
      gst_analytics_tracking_mtd_get_info(&tracks[0], &id, &first, &last, &is_lost);
    return first;
  };
  EXPECT_EQ(first_seen(500), 500u);
  EXPECT_EQ(first_seen(600), 500u);
  gst_harness_push_event(to.pictures.get(), gst_event_new_flush_start());
  gst_harness_push_event(to.pictures.get(), gst_event_new_flush_stop(TRUE));
  gst_harness_push_event(to.pictures.get(), time_segment());
  ASSERT_EQ(gst_harness_push(to.results_in.get(), frame(kTwo, 700)), GST_FLOW_OK);
  EXPECT_EQ(first_seen(700), 700u);
}

TEST(AnalyticsWritten, LabelsBelongToTheirObjectOrToThePicture) {
  const ToRoi to("labels=" + write_labels(),
                 results("x1,y1,x2,y2,score;score,class,parent", "5:1,3:2", "float32,float32"),
                 frame(Floats{0, 0, 8, 8, 1, 0.5f, 1, 0, 0.25f, 0, -1}, 0));
  const auto out = to.picture();
  auto* meta = gst_buffer_get_analytics_relation_meta(out.get());
  const auto labels = entries(meta, gst_analytics_cls_mtd_get_mtd_type());
  ASSERT_EQ(labels.size(), 2u);
  EXPECT_STREQ(g_quark_to_string(gst_analytics_cls_mtd_get_quark(&labels[0], 0)), "dog");
  EXPECT_EQ(gst_analytics_cls_mtd_get_level(&labels[0], 0), 0.5f);
  EXPECT_STREQ(g_quark_to_string(gst_analytics_cls_mtd_get_quark(&labels[1], 0)), "cat");
  const auto of_object = related(objects(out.get())[0], GST_ANALYTICS_REL_TYPE_RELATE_TO,
                                 gst_analytics_cls_mtd_get_mtd_type());
  ASSERT_EQ(of_object.size(), 1u);
  EXPECT_EQ(of_object[0].id, labels[0].id);
  EXPECT_EQ(stat(to.element.get(), "rows-without-region"), 1u);
}

struct Mask {
  Bytes cells;  // in rows
  int x = 0, y = 0;
  guint width = 0, height = 0;
  bool operator==(const Mask&) const = default;
};
Mask read_mask(const GstAnalyticsMtd& segmentation) {
  Mask out;
  const auto mask = Ref<GstBuffer>::adopt(gst_analytics_segmentation_mtd_get_mask(
      &segmentation, &out.x, &out.y, &out.width, &out.height));
  out.cells = content(mask.get());
  return out;
}

// An object with a mask of two rows: 0 and 1.
ToRoi one_mask() {
  GstBuffer* found = frame(Floats{8, 12, 32, 36, 1}, 0);
  gst_buffer_append_memory(found, make_memory({0, 127, 128, 255}));
  return {"", results("x1,y1,x2,y2,score;masks", "5:1,2:2:1", "float32,uint8"), found};
}

TEST(AnalyticsWritten, MasksAreSegmentationOfTheirObject) {
  const ToRoi to = one_mask();
  const auto out = to.picture();
  const auto masks = related(objects(out.get())[0], GST_ANALYTICS_REL_TYPE_RELATE_TO,
                             gst_analytics_segmentation_mtd_get_mtd_type());
  ASSERT_EQ(masks.size(), 1u);
  EXPECT_EQ(read_mask(masks[0]), (Mask{{0, 0, 1, 1}, 8, 12, 24, 24}));
  EXPECT_EQ(gst_analytics_segmentation_mtd_get_region_count(&masks[0]), 2u);
  EXPECT_EQ(related(masks[0], GST_ANALYTICS_REL_TYPE_RELATE_TO, gst_analytics_od_mtd_get_mtd_type())
                .size(),
            1u);
}

TEST(AnalyticsWritten, AClassMapIsSegmentationWithItsLabels) {
  GstBuffer* found = frame(Bytes{0, 1, 1, 5}, 0);
  const ToRoi to("labels=" + write_labels(), results("class-map", "2:2", "uint8"), found);
  const auto out = to.picture();
  auto* meta = gst_buffer_get_analytics_relation_meta(out.get());
  const auto maps = entries(meta, gst_analytics_segmentation_mtd_get_mtd_type());
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_EQ(read_mask(maps[0]), (Mask{{0, 1, 1, 5}, 0, 0, 64, 48}));
  ASSERT_EQ(gst_analytics_segmentation_mtd_get_region_count(&maps[0]), 3u);
  EXPECT_EQ(gst_analytics_segmentation_mtd_get_region_id(&maps[0], 2), 5u);
  for (const auto type : {GST_ANALYTICS_REL_TYPE_RELATE_TO, GST_ANALYTICS_REL_TYPE_N_TO_N}) {
    const auto names = related(maps[0], type, gst_analytics_cls_mtd_get_mtd_type());
    ASSERT_EQ(names.size(), 1u);
    ASSERT_EQ(gst_analytics_cls_mtd_get_length(&names[0]), 3u);
    EXPECT_STREQ(g_quark_to_string(gst_analytics_cls_mtd_get_quark(&names[0], 1)), "dog");
    EXPECT_STREQ(g_quark_to_string(gst_analytics_cls_mtd_get_quark(&names[0], 2)), "5");
  }
}

// The cells outside of the picture are those of a letterbox: half of the upper and lower row.
TEST(AnalyticsWritten, AClassMapEndsWhereThePictureEnds) {
  GstBuffer* found = frame(Bytes{9, 9, 1, 1, 2, 2, 9, 9}, 0);
  SourceMap map{.source_width = 64, .source_height = 48, .width = 2, .height = 4};
  map.xx = 32, map.yy = 24, map.y0 = -24;
  gst::set_source_maps(found, {map});
  const ToRoi to("", results("class-map", "2:4", "uint8"), found);
  const auto out = to.picture();
  const auto maps = entries(gst_buffer_get_analytics_relation_meta(out.get()),
                            gst_analytics_segmentation_mtd_get_mtd_type());
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_EQ(read_mask(maps[0]), (Mask{{1, 1, 2, 2}, 0, 0, 64, 48}));
}

// What draws it keeps what it drew before until a picture has metadata.
TEST(AnalyticsWritten, APictureInWhichNothingIsFoundHasEmptyMetadata) {
  const ToRoi to("", results(kColumns, "9:1"), frame(Floats(9), 0));
  const auto out = to.picture();
  auto* meta = gst_buffer_get_analytics_relation_meta(out.get());
  ASSERT_TRUE(meta);
  EXPECT_EQ(gst_analytics_relation_get_length(meta), 0u);
}

TEST(AnalyticsWritten, OthersEntriesStay) {
  const ToRoi to("", results(kColumns, "9:2"), frame(kTwo, 0));
  GstBuffer* in = frame(Bytes(64 * 48));
  GstAnalyticsMtd other{};
  gst_analytics_relation_meta_add_od_mtd(gst_buffer_add_analytics_relation_meta(in),
                                         g_quark_from_string("bird"), 1, 2, 3, 4, 1, &other);
  const auto out = to.picture(in);
  const auto found = objects(out.get());
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(read(found[0]).label, "bird");
}

TEST(AnalyticsWritten, EntriesForWhichThereIsNoRoomAreCounted) {
  Floats rows;
  for (int i = 0; i < 2001; ++i) rows.insert(rows.end(), {0, 0, 8, 8, 1, 0, 1, -1, 0});
  const ToRoi to("", results(kColumns, "9:2001"), frame(rows, 0));
  const auto out = to.picture();
  EXPECT_EQ(gst_analytics_relation_get_length(gst_buffer_get_analytics_relation_meta(out.get())),
            2000u);
  EXPECT_EQ(stat(to.element.get(), "regions-attached"), 2001u);
  EXPECT_EQ(stat(to.element.get(), "analytics-left-out"), 2002u);  // objects and tracks
}

// ---- Read --------------------------------------------------------------------------------------

struct Frame {
  std::vector<Floats> rows;
  Bytes table;  // the last tensor, without its header
  std::vector<SourceMap> maps;
};
Frame read_frame(GstBuffer* buffer, size_t columns = 9) {
  Frame out;
  const auto maps = gst::source_maps(buffer);
  out.maps.assign(maps.begin(), maps.end());
  const Bytes first = content(gst_buffer_peek_memory(buffer, 0));
  Floats numbers((first.size() - 128) / sizeof(float));
  std::memcpy(numbers.data(), first.data() + 128, numbers.size() * sizeof(float));
  for (size_t i = 0; i < numbers.size(); i += columns)
    out.rows.emplace_back(numbers.begin() + static_cast<ptrdiff_t>(i),
                          numbers.begin() + static_cast<ptrdiff_t>(i + columns));
  const guint last = gst_buffer_n_memory(buffer) - 1;
  const Bytes table = content(gst_buffer_peek_memory(buffer, last));
  out.table.assign(table.begin() + 128, table.end());
  return out;
}
Frame from_roi(const std::string& properties, GstBuffer* picture) {
  const auto h = make_harness("tensor_from_roi " + properties, video("GRAY8", 64, 48));
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), picture));
  return out ? read_frame(out.get()) : Frame{};
}
// A picture, and its metadata.
struct Picture {
  GstBuffer* buffer = frame(Bytes(64 * 48), 0);
  GstAnalyticsRelationMeta* meta = gst_buffer_add_analytics_relation_meta(buffer);

  GstAnalyticsMtd object(const char* label, int x, int y, int width, int height, float score,
                         float rotation = 0) const {
    GstAnalyticsMtd out{};
    gst_analytics_relation_meta_add_oriented_od_mtd(meta, label ? g_quark_from_string(label) : 0, x,
                                                    y, width, height, rotation, score, &out);
    return out;
  }
  void relate(GstAnalyticsRelTypes type, const GstAnalyticsMtd& from,
              const GstAnalyticsMtd& to) const {
    gst_analytics_relation_meta_set_relation(meta, type, from.id, to.id);
  }
  GstAnalyticsMtd segmentation(const Bytes& mask, guint width, guint height, std::vector<guint> ids,
                               int x, int y, guint w, guint h) const {
    GstBuffer* b = frame(mask);
    gst_buffer_add_video_meta(b, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_GRAY8, width, height);
    GstAnalyticsMtd out{};
    gst_analytics_relation_meta_add_segmentation_mtd(meta, b, GST_SEGMENTATION_TYPE_INSTANCE,
                                                     ids.size(), ids.data(), x, y, w, h, &out);
    return out;
  }
};

TEST(AnalyticsRead, ObjectsBecomeRows) {
  const Picture in;
  const auto dog = in.object("dog", 8, 12, 24, 25, 0.75f);
  const auto cat = in.object("cat", -4, 14, 10, 8, 0.5f, 0.25f);
  in.relate(GST_ANALYTICS_REL_TYPE_IS_PART_OF, cat, dog);
  GstAnalyticsMtd track{};
  gst_analytics_relation_meta_add_tracking_mtd(in.meta, 7, 0, &track);
  in.relate(GST_ANALYTICS_REL_TYPE_RELATE_TO, dog, track);
  const auto out = from_roi("labels=" + write_labels(), in.buffer);
  ASSERT_EQ(out.rows.size(), 2u);
  EXPECT_EQ(out.rows[0], (Floats{8, 12, 32, 37, 0.75f, 1, 7, -1, 0}));
  EXPECT_EQ(out.rows[1], (Floats{-4, 14, 6, 22, 0.5f, 0, 0, 0, 0.25f}));
}

TEST(AnalyticsRead, AnObjectWithoutALabelHasThatOfItsClassification) {
  const Picture in;
  const auto object = in.object(nullptr, 8, 12, 24, 25, 0.75f);
  GstAnalyticsMtd classes{};
  gfloat levels[] = {0.25f, 0.5f};
  GQuark names[] = {g_quark_from_string("cat"), g_quark_from_string("dog")};
  gst_analytics_relation_meta_add_cls_mtd(in.meta, 2, levels, names, &classes);
  in.relate(GST_ANALYTICS_REL_TYPE_RELATE_TO, object, classes);
  const auto out = from_roi("labels=" + write_labels(), in.buffer);
  ASSERT_EQ(out.rows.size(), 1u);
  EXPECT_EQ(out.rows[0][5], 1);
}

TEST(AnalyticsRead, LabelsWithoutAnObjectAreCounted) {
  const Picture in;
  GstAnalyticsMtd label{};
  gst_analytics_relation_meta_add_one_cls_mtd(in.meta, 0.5f, g_quark_from_string("cat"), &label);
  const auto h = make_harness("tensor_from_roi", video("GRAY8", 64, 48));
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in.buffer));
  EXPECT_EQ(read_frame(out.get()).rows, (std::vector<Floats>{Floats(9)}));
  EXPECT_EQ(stat(h, "tensor_from_roi", "labels-left-out"), 1u);
}

TEST(AnalyticsRead, NumbersOfTracksFitTheColumn) {
  const auto read = [](guint64 id) {
    const Picture in;
    const auto object = in.object("dog", 0, 0, 8, 8, 1);
    GstAnalyticsMtd track{};
    gst_analytics_relation_meta_add_tracking_mtd(in.meta, id, 0, &track);
    in.relate(GST_ANALYTICS_REL_TYPE_RELATE_TO, object, track);
    return from_roi("", in.buffer).rows.at(0)[6];
  };
  EXPECT_EQ(read(0), 16777215);  // the column has 0 for none
  EXPECT_EQ(read(16777215), 16777215);
  EXPECT_EQ(read(16777216), 1);
  EXPECT_EQ(read(G_MAXUINT64), 65535);  // (2^64 - 2) mod (2^24 - 1) + 1
}

TEST(AnalyticsRead, MasksCoverTheBoxesOfTheirObjects) {
  const Picture in;
  const auto object = in.object("dog", 0, 0, 32, 24, 1);
  in.object("cat", 0, 0, 8, 8, 1);
  // Of the whole picture; the object is its upper left quarter.
  Bytes mask(8 * 4);
  mask[1] = 9;
  const auto segmentation = in.segmentation(mask, 8, 4, {0, 9}, 0, 0, 64, 48);
  in.relate(GST_ANALYTICS_REL_TYPE_RELATE_TO, segmentation, object);
  const auto out = from_roi("masks=true", in.buffer);
  ASSERT_EQ(out.table.size(), 8u * 4 * 2);
  // Two columns and two rows of this one are one cell of that one.
  EXPECT_EQ(
      Bytes(out.table.begin(), out.table.begin() + 24),
      (Bytes{0, 0, 255, 255, 0, 0, 0, 0, 0, 0, 255, 255, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(Bytes(out.table.begin() + 32, out.table.end()), Bytes(32));
}

// The numbers of regions are the segmentation's own; those of classes are lines of the labels.
GstAnalyticsMtd add_class_map(const Picture& in) {
  const auto segmentation =
      in.segmentation({0, 12, 31, 7, 0, 0, 0, 0}, 4, 2, {0, 12, 31}, 32, 24, 32, 24);
  GstAnalyticsMtd classes{};
  gfloat levels[] = {-1, -1, -1};
  GQuark names[] = {g_quark_from_string("background"), g_quark_from_string("dog"),
                    g_quark_from_string("cat")};
  gst_analytics_relation_meta_add_cls_mtd(in.meta, 3, levels, names, &classes);
  in.relate(GST_ANALYTICS_REL_TYPE_N_TO_N, segmentation, classes);
  return segmentation;
}
std::vector<uint16_t> classes(const Frame& frame) {
  std::vector<uint16_t> out(frame.table.size() / 2);
  std::memcpy(out.data(), frame.table.data(), frame.table.size());
  return out;
}

TEST(AnalyticsRead, SegmentationOfThePictureIsTheClassMap) {
  const Picture in;
  add_class_map(in);
  const auto out = from_roi("class-map=true labels=" + write_labels("road\ncat\ndog\n"), in.buffer);
  EXPECT_EQ(classes(out), (std::vector<uint16_t>{0, 2, 1, 7, 0, 0, 0, 0}));
  ASSERT_EQ(out.maps.size(), 2u);
  EXPECT_EQ(out.maps[1].to_source({0, 0}).x, 32);
  EXPECT_EQ(out.maps[1].to_source({4, 2}).y, 48);
}

TEST(AnalyticsRead, WithoutLabelsTheClassMapHasTheNumbersOfTheRegions) {
  const Picture in;
  add_class_map(in);
  EXPECT_EQ(classes(from_roi("class-map=true", in.buffer)),
            (std::vector<uint16_t>{0, 12, 31, 7, 0, 0, 0, 0}));
}

TEST(AnalyticsRead, APictureWithoutSegmentationHasAClassMapOfOneCell) {
  const auto h = make_harness("tensor_from_roi class-map=true", video("GRAY8", 64, 48));
  const Picture first;
  add_class_map(first);
  const auto with = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), first.buffer));
  EXPECT_EQ(classes(read_frame(with.get())).size(), 8u);
  const auto without =
      Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(Bytes(64 * 48), 1)));
  EXPECT_EQ(classes(read_frame(without.get())), (std::vector<uint16_t>{0}));
}

// One that several objects share, a second class map, and a mask smaller than its metadata.
TEST(AnalyticsRead, SegmentationsThatCannotBeUsedAreCounted) {
  const Picture in;
  const auto shared = in.segmentation({1, 2}, 2, 1, {1, 2}, 0, 0, 64, 48);
  for (const char* label : {"dog", "cat"})
    in.relate(GST_ANALYTICS_REL_TYPE_RELATE_TO, shared, in.object(label, 0, 0, 8, 8, 1));
  in.segmentation(Bytes(3), 640, 480, {0}, 0, 0, 64, 48);
  add_class_map(in);
  add_class_map(in);
  const auto h = make_harness("tensor_from_roi class-map=true masks=true", video("GRAY8", 64, 48));
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in.buffer));
  EXPECT_EQ(classes(read_frame(out.get())), (std::vector<uint16_t>{0, 12, 31, 7, 0, 0, 0, 0}));
  EXPECT_EQ(stat(h, "tensor_from_roi", "segmentations-left-out"), 3u);
  EXPECT_EQ(stat(h, "tensor_from_roi", "labels-left-out"), 1u);  // of the second class map
}

TEST(AnalyticsRead, SegmentationsThatAreNotAskedForAreCountedWithTheirLabels) {
  const Picture in;
  const auto picture = Ref<GstBuffer>::adopt(in.buffer);
  const auto mask = in.segmentation({1}, 1, 1, {1}, 0, 0, 8, 8);
  in.relate(GST_ANALYTICS_REL_TYPE_RELATE_TO, mask, in.object("dog", 0, 0, 8, 8, 1));
  add_class_map(in);
  for (const auto& [settings, segmentations, labels] :
       {std::tuple{"", 2u, 1u}, {"masks=true", 1u, 1u}, {"class-map=true", 1u, 0u}}) {
    const auto h = make_harness(std::string("tensor_from_roi ") + settings, video("GRAY8", 64, 48));
    const auto out =
        Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), gst_buffer_ref(picture.get())));
    EXPECT_EQ(stat(h, "tensor_from_roi", "segmentations-left-out"), segmentations) << settings;
    EXPECT_EQ(stat(h, "tensor_from_roi", "labels-left-out"), labels) << settings;
  }
}

TEST(AnalyticsRead, ObjectsWithoutAreaOrScoreAreCounted) {
  const Picture in;
  in.object("dog", 8, 12, 0, 25, 1);
  in.object("dog", 8, 12, 24, -25, 1);
  in.object("dog", 8, 12, 24, 25, std::nanf(""));
  in.object("cat", 8, 12, 24, 25, 1, std::nanf(""));
  const auto h = make_harness("tensor_from_roi", video("GRAY8", 64, 48));
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in.buffer));
  EXPECT_EQ(read_frame(out.get()).rows, (std::vector<Floats>{{8, 12, 32, 37, 1, 0, 0, -1, 0}}));
  EXPECT_EQ(stat(h, "tensor_from_roi", "objects-left-out"), 3u);
}

// What an element relates to what differs from element to element.
TEST(AnalyticsRead, RelationsCountInBothDirections) {
  const Picture in;
  const auto dog = in.object("dog", 8, 12, 24, 25, 1), cat = in.object(nullptr, 0, 0, 8, 8, 1);
  GstAnalyticsMtd label{}, track{};
  gst_analytics_relation_meta_add_one_cls_mtd(in.meta, 0.5f, g_quark_from_string("dog"), &label);
  gst_analytics_relation_meta_add_tracking_mtd(in.meta, 9, 0, &track);
  in.relate(GST_ANALYTICS_REL_TYPE_IS_PART_OF, label, cat);
  in.relate(GST_ANALYTICS_REL_TYPE_RELATE_TO, track, cat);
  in.relate(GST_ANALYTICS_REL_TYPE_CONTAIN, dog, cat);
  const auto out = from_roi("labels=" + write_labels(), in.buffer);
  ASSERT_EQ(out.rows.size(), 2u);
  EXPECT_EQ(out.rows[1], (Floats{0, 0, 8, 8, 1, 1, 9, 0, 0}));
}

TEST(AnalyticsRead, PartsOfEachOtherAreRows) {
  const Picture in;
  const auto one = in.object("dog", 8, 12, 24, 25, 1), other = in.object("dog", 0, 0, 8, 8, 1);
  in.relate(GST_ANALYTICS_REL_TYPE_IS_PART_OF, one, other);
  in.relate(GST_ANALYTICS_REL_TYPE_IS_PART_OF, other, one);
  in.relate(GST_ANALYTICS_REL_TYPE_IS_PART_OF, one, one);
  const auto out = from_roi("", in.buffer);
  ASSERT_EQ(out.rows.size(), 2u);
  EXPECT_EQ(out.rows[0][7], 1);
  EXPECT_EQ(out.rows[1][7], 0);
}

// ---- Both --------------------------------------------------------------------------------------

TEST(Analytics, WhatToRoiWritesTwiceIsReadOnce) {
  const ToRoi to("labels=" + write_labels(), results(kColumns, "9:2"), frame(kTwo, 0));
  const auto out = from_roi("", to.picture().release());
  ASSERT_EQ(out.rows.size(), 2u);
  for (size_t i = 0; i < 18; ++i) EXPECT_NEAR(out.rows[i / 9][i % 9], kTwo[i], 1e-4) << i;
}

gboolean remove_region(GstBuffer*, GstMeta** meta, gpointer) {
  if ((*meta)->info->api == GST_VIDEO_REGION_OF_INTEREST_META_API_TYPE) *meta = nullptr;
  return TRUE;
}

TEST(Analytics, WithoutRegionsTheObjectsAreRead) {
  const ToRoi to("labels=" + write_labels(), results(kColumns, "9:2"), frame(kTwo, 0));
  const auto picture = Ref<GstBuffer>::adopt(gst_buffer_make_writable(to.picture().release()));
  gst_buffer_foreach_meta(picture.get(), remove_region, nullptr);
  const auto out = from_roi("labels=" + write_labels(), gst_buffer_ref(picture.get()));
  EXPECT_EQ(out.rows, (std::vector<Floats>{{8, 12, 32, 37, 0.75f, 1, 7, -1, 0},
                                           {10, 14, 20, 22, 0.5f, 0, 0, 0, 0.25f}}));
}

TEST(Analytics, MasksOfOurObjectsAreRead) {
  const ToRoi to = one_mask();
  EXPECT_EQ(from_roi("masks=true", to.picture().release()).table, (Bytes{0, 0, 255, 255}));
}

TEST(Analytics, ARegionHasTheTrackThatAnotherElementFound) {
  Floats row(kTwo.begin(), kTwo.begin() + 9);
  row[6] = 0;
  const ToRoi to("", results(kColumns, "9:1"), frame(row, 0));
  const auto picture = Ref<GstBuffer>::adopt(gst_buffer_make_writable(to.picture().release()));
  GstAnalyticsMtd track{};
  auto* meta = gst_buffer_get_analytics_relation_meta(picture.get());
  gst_analytics_relation_meta_add_tracking_mtd(meta, 5, 0, &track);
  gst_analytics_relation_meta_set_relation(meta, GST_ANALYTICS_REL_TYPE_RELATE_TO,
                                           objects(picture.get())[0].id, track.id);
  const auto out = from_roi("", gst_buffer_ref(picture.get()));
  ASSERT_EQ(out.rows.size(), 1u);
  EXPECT_EQ(out.rows[0][6], 5);
}

TEST(Analytics, ARegionWithoutParametersHasThoseOfItsObject) {
  const Picture in;
  gst_buffer_add_video_region_of_interest_meta(in.buffer, "dog", 8, 12, 24, 25);
  gst_buffer_add_video_region_of_interest_meta(in.buffer, "cat", 8, 12, 24, 25);
  const auto object = in.object("cat", 8, 13, 24, 24, 0.5f, 0.25f);
  GstAnalyticsMtd track{};
  gst_analytics_relation_meta_add_tracking_mtd(in.meta, 5, 0, &track);
  in.relate(GST_ANALYTICS_REL_TYPE_RELATE_TO, object, track);
  EXPECT_EQ(from_roi("", in.buffer).rows,
            (std::vector<Floats>{{8, 12, 32, 37, 1, 0, 0, -1, 0},
                                 {8, 12, 32, 37, 0.5f, 0, 5, -1, 0.25f}}));
}

TEST(Analytics, ObjectsOfOthersBesideOursAreRead) {
  const ToRoi to("", results(kColumns, "9:2"), frame(kTwo, 0));
  const Picture in;
  in.object("bird", 8, 12, 24, 25, 0.25f);
  const auto out = from_roi("", to.picture(in.buffer).release());
  ASSERT_EQ(out.rows.size(), 3u);
  EXPECT_EQ(out.rows[2], (Floats{8, 12, 32, 37, 0.25f, 0, 0, -1, 0}));
}

}  // namespace analytics_test
}  // namespace weir
