// tensor_split: the contents of segments, shared and copied memory, errors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <numeric>

#include "elements/tests/branches_test_support.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir::test {
namespace tensor_split_test {

Bytes ramp(size_t size) {
  Bytes out(size);
  std::iota(out.begin(), out.end(), uint8_t{0});
  return out;
}
std::string one(const std::string& dimensions, const std::string& type = "uint8") {
  return test::tensors(type, dimensions);
}
std::vector<std::string> names(std::initializer_list<const char*> list) {
  return {list.begin(), list.end()};
}

TEST(TensorSplit, SharesConsecutiveSegments) {
  Branches split("tensor_split tensorseg=2:3,4;1:2/6:1:1");
  split.caps(one("2:3:3"));
  GstBuffer* in = make_frame({ramp(18)});
  GST_BUFFER_PTS(in) = 7;
  GST_BUFFER_DURATION(in) = 3;
  GstMemory* memory = gst_buffer_peek_memory(in, 0);
  ASSERT_EQ(split.push(in), GST_FLOW_OK);
  EXPECT_EQ(split.added(), names({"src_0", "src_1", "src_2", "src_3"}));
  const char* dimensions[] = {"2:3", "4", "1:2", "6:1:1"};
  uint8_t next = 0;
  for (size_t i = 0; i < 4; ++i) {
    const std::string name = "src_" + std::to_string(i);
    const auto out = split.take(name);
    EXPECT_EQ(gst_buffer_peek_memory(out.get(), 0)->parent, memory);
    for (const uint8_t byte : content(out.get(), 0)) EXPECT_EQ(byte, next++);
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), 7u);
    EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 3u);
    EXPECT_SAYS(split.branch(name).caps(), std::string("dimensions=(string)") + dimensions[i]);
    EXPECT_SAYS(split.branch(name).caps(), "framerate=(fraction)30/1");
  }
  EXPECT_EQ(next, 18);
  EXPECT_EQ(split.stat("bytes-copied"), 0u);
  EXPECT_EQ(split.stat("pushed"), 4u);
  EXPECT_EQ(split.no_more_pads_count(), 1);
  split.expect_balance();
}

TEST(TensorSplit, PicksSegmentsInTheirOrderWithTheirOwnDimensions) {
  Branches split("tensor_split tensorseg=1:2,2:2,3:2 tensorpick=2.0");
  split.caps(one("6:2", "int16"));
  ASSERT_EQ(split.push(make_frame({ramp(24)})), GST_FLOW_OK);
  EXPECT_EQ(split.added(), names({"src_0", "src_1"}));
  const Bytes all = ramp(24);
  EXPECT_EQ(content(split.take("src_0").get(), 0), Bytes(all.begin(), all.begin() + 4));
  EXPECT_EQ(content(split.take("src_1").get(), 0), Bytes(all.begin() + 12, all.end()));
  EXPECT_SAYS(split.branch("src_0").caps(), "dimensions=(string)1:2");
  EXPECT_SAYS(split.branch("src_1").caps(), "dimensions=(string)3:2, types=(string)int16");
  EXPECT_EQ(split.stat("bytes-copied"), 0u);
}

TEST(TensorSplit, OfEveryTypeAndRank) {
  const char* types[] = {"int8",  "uint8",  "int16",   "uint16",  "int32",  "uint32",
                         "int64", "uint64", "float16", "float32", "float64"};
  const size_t sizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8};
  for (size_t t = 0; t < 11; ++t)
    for (size_t rank = 1; rank <= 16; rank += 5) {
      std::string dims, segments[2];
      for (size_t d = 0; d + 1 < rank; ++d) dims += "1:";
      for (const char* extent : {"2", "3"}) segments[extent[0] - '2'] = dims + extent;
      Branches split("tensor_split tensorseg=" + segments[0] + "," + segments[1]);
      split.caps(one(dims + "5", types[t]));
      const Bytes all = ramp(5 * sizes[t]);
      ASSERT_EQ(split.push(make_frame({all})), GST_FLOW_OK);
      const auto middle = all.begin() + static_cast<std::ptrdiff_t>(2 * sizes[t]);
      EXPECT_EQ(content(split.take("src_0").get(), 0), Bytes(all.begin(), middle));
      EXPECT_EQ(content(split.take("src_1").get(), 0), Bytes(middle, all.end()));
      EXPECT_SAYS(split.branch("src_1").caps(), "dimensions=(string)" + segments[1] + ", types");
      EXPECT_EQ(split.stat("bytes-copied"), 0u);
    }
}

TEST(TensorSplit, FollowsThePeer) {
  Branches split("tensor_split tensorseg=1,2",
                 {{"src_0", "other/tensor"}, {"src_1", "other/tensors,dimensions=2:1:1:1"}});
  split.caps("other/tensor,dimension=(string)3,type=(string)uint8,framerate=30/1");
  ASSERT_EQ(split.push(make_frame({{1, 2, 3}})), GST_FLOW_OK);
  EXPECT_SAYS(split.branch("src_0").caps(), "other/tensor, dimension=(string)1,");
  EXPECT_SAYS(split.branch("src_1").caps(), "dimensions=(string)2:1:1:1");
}

TEST(TensorSplitDimension, SeparatesInterleavedChannels) {
  Branches split("tensor_split split-dim=0 tensorseg=1,2");
  split.caps(one("3:4:2"));
  for (int round = 0; round < 3; ++round) {
    ASSERT_EQ(split.push(make_frame({ramp(24)})), GST_FLOW_OK);
    Bytes first, others;
    for (uint8_t i = 0; i < 24; ++i) (i % 3 == 0 ? first : others).push_back(i);
    EXPECT_EQ(content(split.take("src_0").get(), 0), first);
    EXPECT_EQ(content(split.take("src_1").get(), 0), others);
  }
  EXPECT_SAYS(split.branch("src_1").caps(), "dimensions=(string)2:4:2");
  EXPECT_EQ(split.stat("bytes-copied"), 3 * 24u);
}

TEST(TensorSplitDimension, SplitsAMiddleDimensionIntoEqualParts) {
  Branches split("tensor_split split-dim=1 split-parts=2 tensorpick=1");
  split.caps(one("2:4:3", "int16"));
  ASSERT_EQ(split.push(make_frame({ramp(48)})), GST_FLOW_OK);
  Bytes expected;
  for (uint8_t row = 0; row < 3; ++row)
    for (uint8_t b = 8; b < 16; ++b) expected.push_back(static_cast<uint8_t>(16 * row + b));
  EXPECT_EQ(content(split.take("src_0").get(), 0), expected);
  EXPECT_EQ(split.stat("bytes-copied"), 24u);
}

TEST(TensorSplitDimension, SharesAlongTheOutermost) {
  Branches split("tensor_split split-dim=2 tensorseg=1,2");
  split.caps(one("3:4:3:1"));
  ASSERT_EQ(split.push(make_frame({ramp(36)})), GST_FLOW_OK);
  EXPECT_EQ(content(split.take("src_0").get(), 0), ramp(12));
  EXPECT_SAYS(split.branch("src_1").caps(), "dimensions=(string)3:4:2:1");
  EXPECT_EQ(split.stat("bytes-copied"), 0u);
}

TEST(TensorSplitDimension, CopiesNothingForPadsThatAreNotLinked) {
  Branches split("tensor_split split-dim=0 split-parts=3", {}, {"src_0", "src_2"});
  split.caps(one("3:4"));
  ASSERT_EQ(split.push(make_frame({ramp(12)})), GST_FLOW_OK);
  EXPECT_EQ(content(split.take("src_1").get(), 0), (Bytes{1, 4, 7, 10}));
  EXPECT_EQ(split.stat("bytes-copied"), 4u);
  EXPECT_EQ(split.stat("pushed"), 1u);

  Branches none("tensor_split split-dim=0 split-parts=3", {}, {"src_0", "src_1", "src_2"});
  none.caps(one("3:4"));
  EXPECT_EQ(none.push(make_frame({ramp(12)})), GST_FLOW_NOT_LINKED);
  none.expect_balance();
}

TEST(TensorSplitDimension, CountsMergedBytes) {
  Branches split("tensor_split split-dim=0 split-parts=2 tensorpick=0");
  split.caps(one("2:2"));
  ASSERT_EQ(split.push(make_frame({{0, 1, 2}, {3}})), GST_FLOW_OK);
  EXPECT_EQ(content(split.take("src_0").get(), 0), (Bytes{0, 2}));
  EXPECT_EQ(split.stat("bytes-copied"), 2 + 4u);
}

TEST(TensorSplit, AdjustsTheSourceMapToThePart) {
  Branches split("tensor_split tensorseg=3:8:2,3:8:4");
  split.caps(one("3:8:6"));
  GstBuffer* in = make_frame({ramp(144)});
  gst::set_source_maps(in, {picture_as_it_is(8, 6, false)});
  ASSERT_EQ(split.push(in), GST_FLOW_OK);
  const auto upper = split.take("src_0"), lower = split.take("src_1");
  ASSERT_EQ(gst::source_maps(lower.get()).size(), 1u);
  EXPECT_EQ(gst::source_maps(lower.get())[0].to_source({0, 0}).y, 2);
  EXPECT_EQ(gst::source_maps(upper.get())[0].height, 2u);

  Branches flat("tensor_split tensorseg=144");
  flat.caps(one("3:8:6"));
  in = make_frame({ramp(144)});
  gst::set_source_maps(in, {picture_as_it_is(8, 6, false)});
  ASSERT_EQ(flat.push(in), GST_FLOW_OK);
  EXPECT_TRUE(gst::source_maps(flat.take("src_0").get()).empty()) << "it no longer has x and y";
}

TEST(TensorSplit, KeepsRegionsOfABatchWithTheirSegment) {
  for (const char* dimension : {"3", "2"}) {
    Branches split(std::string("tensor_split tensorseg=1,2 split-dim=") + dimension);
    split.caps(one("3:4:3:3"));
    GstBuffer* in = make_frame({ramp(108)});
    std::vector<SourceMap> maps(3, picture_as_it_is(4, 3, false));
    for (size_t i = 0; i < 3; ++i) maps[i].x0 = static_cast<double>(10 * i);
    gst::set_source_maps(in, maps, gst::MapsOf::Regions);
    ASSERT_EQ(split.push(in), GST_FLOW_OK);
    const auto second = split.take("src_1");
    EXPECT_EQ(gst::maps_of(second.get()), gst::MapsOf::Regions);
    const auto own = gst::source_maps(second.get());
    const bool by_region = dimension[0] == '3';
    ASSERT_EQ(own.size(), by_region ? 2u : 3u);
    EXPECT_EQ(own[0].x0, by_region ? 10 : 0);
    EXPECT_EQ(own[0].to_source({0, 0}).y, by_region ? 0 : 1);
  }
}

TEST(TensorSplit, FollowsChangedCaps) {
  Branches split("tensor_split split-dim=0 split-parts=2");
  split.caps(one("2:1"));
  ASSERT_EQ(split.push(make_frame({{1, 2}})), GST_FLOW_OK);
  split.caps(one("4:1"));
  ASSERT_EQ(split.push(make_frame({{1, 2, 3, 4}})), GST_FLOW_OK);
  EXPECT_EQ(content(split.branch("src_1").buffers.back().get(), 0), (Bytes{3, 4}));
  EXPECT_SAYS(split.branch("src_1").caps(), "dimensions=(string)2:1");
  split.expect_balance();
}

TEST(TensorSplitRejects, AStreamWithoutSegmentsAtItsFirstFrame) {
  Branches split("tensor_split");
  split.caps(one("3:4"));
  EXPECT_EQ(split.error(), "");
  EXPECT_EQ(split.push(make_frame({ramp(12)})), GST_FLOW_ERROR);
  const std::string error = split.error();
  EXPECT_SAYS(error, "WEIR-1004: tensor_split needs the segments");
  EXPECT_SAYS(error, "fix: tensor_split tensorseg=3:4");
  EXPECT_EQ(split.stat("dropped-error"), 1u);
  split.expect_balance();
}

std::string caps_refused(const std::string& properties, const std::string& caps) {
  Branches split("tensor_split " + properties);
  EXPECT_TRUE(split.started());
  split.caps(caps);
  EXPECT_EQ(split.error(), "") << "caps may be those of a placeholder";
  EXPECT_LE(split.push(make_frame({ramp(12)})), GST_FLOW_NOT_NEGOTIATED);
  return split.error();
}

TEST(TensorSplit, AcceptsUnsuitableCapsUntilTheFirstFrame) {
  Branches split("tensor_split tensorseg=3:2,3:2");
  split.caps(one("1"));
  EXPECT_EQ(split.error(), "");
  split.caps(one("3:4"));
  EXPECT_EQ(split.push(make_frame({ramp(12)})), GST_FLOW_OK);
  EXPECT_EQ(split.added().size(), 2u);
}

TEST(TensorSplitRejects, SegmentsBeyondTheTensor) {
  const std::string error = caps_refused("tensorseg=3:2,3:3", one("3:4"));
  EXPECT_SAYS(error, "WEIR-2001: the segments are larger than the tensor");
  EXPECT_SAYS(error, "offered: uint8 3:4 = 12 bytes");
  EXPECT_SAYS(error, "needed: segments 0 to 1 = 15 bytes");
  EXPECT_SAYS(error, "segment 1 (3:3) begins at byte 6 and has 9 bytes");
  EXPECT_SAYS(caps_refused("split-dim=1 tensorseg=2,3", one("3:4")),
              "segments 0 to 1 = 5 along dimension 1 of 4");
  EXPECT_SAYS(caps_refused("split-dim=1 split-parts=3", one("3:4")), "4 / 3 leaves 1");
  EXPECT_SAYS(caps_refused("tensorseg=3:4 tensorpick=1", one("3:4")),
              "tensorpick names a segment that does not exist");
}

TEST(TensorSplitRejects, TyposAtTheStart) {
  for (const auto& [properties, place] :
       {std::pair{"tensorseg=3:4,3;b", "    3:4,3;b\n          ^"},
        std::pair{"tensorseg=3 tensorpick=0,a", "    0,a\n      ^"}}) {
    Branches split(std::string("tensor_split ") + properties);
    EXPECT_FALSE(split.started());
    EXPECT_SAYS(split.error(), place);
  }
}

TEST(TensorSplitRejects, BuffersThatAreTooSmall) {
  Branches split("tensor_split tensorseg=3:1,3:3");
  split.caps(one("3:4"));
  EXPECT_EQ(split.push(make_frame({ramp(11)})), GST_FLOW_ERROR);
  EXPECT_SAYS(split.error(), "WEIR-2004");
  EXPECT_EQ(split.push(make_frame({ramp(5), ramp(6)})), GST_FLOW_ERROR);
  EXPECT_SAYS(split.error(), "11 bytes in 2 memories");
  EXPECT_EQ(split.stat("dropped-error"), 2u);
  split.expect_balance();
}

TEST(TensorSplit, WarnsAboutDataInNoSegment) {
  Branches split("tensor_split tensorseg=3:1");
  split.caps(one("3:4"));
  ASSERT_EQ(split.push(make_frame({ramp(12)})), GST_FLOW_OK);
  EXPECT_EQ(content(split.take("src_0").get(), 0), ramp(3));
  EXPECT_SAYS(split.warning(), "WEIR-1004: a part of the tensor is not covered by any segment");
}

TEST(TensorSplitRejects, AnEndWithoutAFrame) {
  Branches split("tensor_split tensorseg=3:4");
  split.caps(one("3:4"));
  split.send(gst_event_new_eos());
  EXPECT_SAYS(split.error(), "the stream ended without any output");
}

}  // namespace tensor_split_test
}  // namespace weir::test
