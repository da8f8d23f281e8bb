// tensor_if: which branch frames take and what is sent there.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>

#include "elements/tests/branches_test_support.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir::test {
namespace tensor_if_test {

std::string one(const std::string& dimensions, const std::string& type = "uint8") {
  return test::tensors(type, dimensions);
}
std::vector<std::string> names(std::initializer_list<const char*> list) {
  return {list.begin(), list.end()};
}

// "0" for THEN, "1" for ELSE, for each value as the only element of a uint8 tensor.
std::string ways(const std::string& properties, const Bytes& values) {
  Branches element("tensor_if compared-value-option=0,0 " + properties);
  element.caps(one("1"));
  std::string out;
  for (const uint8_t value : values) {
    EXPECT_EQ(element.push(make_frame({{value}})), GST_FLOW_OK);
    for (const char way : {'0', '1'}) {
      const std::string name = std::string("src_") + way;
      if (!element.has(name) || element.branch(name).buffers.empty()) continue;
      out += way;
      EXPECT_EQ(content(element.take(name).get(), 0), Bytes{value});
    }
  }
  element.expect_balance();
  return out;
}

TEST(TensorIf, KnowsEveryOperatorByNameNickAndNumber) {
  struct Line {
    const char *name, *nick, *number, *supplied, *expected;
  };
  const Line lines[] = {
      {"EQ", "eqaual", "0", "20", "11011"},
      {"NE", "not_eqaual", "1", "20", "00100"},
      {"GT", "greater_than", "2", "20", "11100"},
      {"GE", "greater_or_equal", "3", "20", "11000"},
      {"LT", "less_than", "4", "20", "00111"},
      {"LE", "less_or_equal", "5", "20", "00011"},
      {"RANGE_INCLUSIVE", "range inclusive", "6", "10,30", "10001"},
      {"RANGE_EXCLUSIVE", "range exclusive", "7", "10,30", "11011"},
      {"NOT_IN_RANGE_INCLUSIVE", "not in range inclusive", "8", "10,30", "01110"},
      {"NOT_IN_RANGE_EXCLUSIVE", "not in range exclusive", "9", "10,30", "00100"},
  };
  const Bytes values{1, 10, 20, 30, 40};
  for (const Line& line : lines)
    for (const char* spelled : {line.name, line.nick, line.number})
      EXPECT_EQ(
          ways("operator=\"" + std::string(spelled) + "\" supplied-value=" + line.supplied, values),
          line.expected)
          << spelled;
}

TEST(TensorIf, ComparesWithinTheTensorsType) {
  EXPECT_EQ(ways("operator=EQ supplied-value=300", {44, 43}), "01") << "300 is 44 as a uint8";
  EXPECT_EQ(ways("operator=EQ supplied-value=-1", {255, 1}), "01");
  EXPECT_EQ(ways("operator=GE supplied-value=2.9", {1, 2, 3}), "100") << "2.9 is 2 as a uint8";
}

TEST(TensorIf, AddsAPadWithTheFirstFrameOfItsBranch) {
  Branches element("tensor_if compared-value-option=0,0 operator=GT supplied-value=5");
  element.caps(one("1"));
  ASSERT_EQ(element.push(make_frame({{1}})), GST_FLOW_OK);
  EXPECT_EQ(element.added(), names({"src_1"}));
  EXPECT_EQ(element.no_more_pads_count(), 0);
  ASSERT_EQ(element.push(make_frame({{9}})), GST_FLOW_OK);
  EXPECT_EQ(element.added(), names({"src_1", "src_0"}));
  EXPECT_EQ(element.no_more_pads_count(), 1);
  EXPECT_EQ(element.branch("src_0").events, names({"stream-start", "caps", "segment"}));
  EXPECT_EQ(element.branch("src_0").stream_id(), "test/src_0");
  EXPECT_EQ(element.stat("pushed-src_0"), 1u);
  EXPECT_EQ(element.stat("pushed-src_1"), 1u);
}

TEST(TensorIf, PassesTheSameBuffer) {
  Branches element("tensor_if compared-value-option=0,1 operator=EQ supplied-value=3");
  element.caps(test::tensors("uint8,uint8", "2,2"));
  GstBuffer* in = make_frame({{1, 2}, {3, 4}});
  ASSERT_EQ(element.push(in), GST_FLOW_OK);
  EXPECT_EQ(element.take("src_0").get(), in);
  EXPECT_EQ(element.stat("bytes-copied"), 0u);
}

TEST(TensorIf, SkipsByPolicy) {
  Branches element(
      "tensor_if compared-value-option=0,0 operator=GT supplied-value=5 then=SKIP "
      "else=passthrough");
  element.caps(one("1"));
  for (const uint8_t value : {9, 1, 8}) ASSERT_EQ(element.push(make_frame({{value}})), GST_FLOW_OK);
  EXPECT_EQ(element.added(), names({"src_1"}));
  EXPECT_EQ(element.no_more_pads_count(), 1) << "there will be no other pad";
  EXPECT_EQ(element.stat("dropped-policy"), 2u);
  EXPECT_EQ(element.stat("consumed"), 1u);
  element.expect_balance();
}

TEST(TensorIf, PicksTensorsInTheGivenOrder) {
  Branches element(
      "tensor_if compared-value-option=0,0 supplied-value=1 then=TENSORPICK then-option=2,0 "
      "else=7 else-option=1");
  element.caps(test::tensors("uint8,uint8,int16", "1:2:3,8:6,2"));
  for (const uint8_t first : {1, 0}) {
    GstBuffer* in = make_frame({{first, 1, 2, 3, 4, 5}, Bytes(48, 7), {1, 2, 3, 4}});
    gst::set_source_maps(in, {picture_as_it_is(2, 3, false), picture_as_it_is(8, 6, true),
                              picture_as_it_is(9, 9, false)});
    GST_BUFFER_PTS(in) = 77;
    ASSERT_EQ(element.push(in), GST_FLOW_OK);
  }
  const auto then = element.take("src_0"), other = element.take("src_1");
  ASSERT_EQ(gst_buffer_n_memory(then.get()), 2u);
  EXPECT_EQ(content(then.get(), 0), (Bytes{1, 2, 3, 4}));
  EXPECT_EQ(content(then.get(), 1), (Bytes{1, 1, 2, 3, 4, 5}));
  EXPECT_EQ(GST_BUFFER_PTS(then.get()), 77u);
  EXPECT_SAYS(
      element.branch("src_0").caps(),
      "num_tensors=(int)2, dimensions=(string)\"2\\,1:2:3\", types=(string)\"int16\\,uint8\"");
  EXPECT_EQ(content(other.get(), 0), Bytes(48, 7));
  ASSERT_EQ(gst::source_maps(other.get()).size(), 1u);
  EXPECT_EQ(gst::source_maps(other.get())[0].width, 8u);
  EXPECT_EQ(element.stat("bytes-copied"), 0u);
}

TEST(TensorIf, FindsItsElementInOneMemoryOfMany) {
  Branches element("tensor_if compared-value-option=1:2,1 operator=EQ supplied-value=-7");
  element.caps(test::tensors("uint8,int16", "3,2:3"));
  std::vector<int16_t> second{0, 1, 2, 3, 4, -7};
  Bytes bytes(12);
  std::memcpy(bytes.data(), second.data(), 12);
  ASSERT_EQ(element.push(make_frame({{1, 2, 3}, bytes})), GST_FLOW_OK);
  Bytes all{1, 2, 3};
  all.insert(all.end(), bytes.begin(), bytes.end());
  ASSERT_EQ(element.push(make_frame({all})), GST_FLOW_OK) << "one memory for all";
  const auto part = [&](int from, int to) { return Bytes(all.begin() + from, all.begin() + to); };
  ASSERT_EQ(element.push(make_frame({part(0, 5), part(5, 14), part(14, 15)})), GST_FLOW_OK)
      << "the element spans two of three memories";
  EXPECT_EQ(element.branch("src_0").buffers.size(), 3u);
  EXPECT_EQ(element.stat("bytes-copied"), 0u);
}

TEST(TensorIf, ComparesAveragesOfEveryTensor) {
  for (int tensors = 1; tensors <= 20; tensors += 3) {
    std::string dimensions = "4", types = "uint8";
    for (int i = 1; i < tensors; ++i) {
      dimensions += ",";
      for (int d = 0; d < i % 16; ++d) dimensions += "1:";
      dimensions += "4", types += ",uint8";
    }
    const int last = tensors - 1;
    Branches element("tensor_if compared-value=TENSOR_AVERAGE_VALUE compared-value-option=" +
                     std::to_string(last) + " operator=EQ supplied-value=" + std::to_string(last));
    element.caps(test::tensors(types, dimensions));
    // As one memory, split by the sizes of the caps, as with more than 16 tensors.
    Bytes all;
    for (int i = 0; i < tensors; ++i)
      for (const int step : {0, 1, 2, 0}) all.push_back(static_cast<uint8_t>(i + step));
    ASSERT_EQ(element.push(make_frame({all})), GST_FLOW_OK);
    EXPECT_TRUE(element.has("src_0")) << "the mean is 0.75 above, truncated to the type";
    EXPECT_FALSE(element.has("src_1"));
    EXPECT_EQ(element.stat("bytes-copied"), 0u);
  }
}

TEST(TensorIf, FollowsThePeerOfEachBranch) {
  Branches element("tensor_if compared-value-option=0,0 operator=GT supplied-value=5",
                   {{"src_0", "other/tensor"}});
  element.caps(one("3:1"));
  ASSERT_EQ(element.push(make_frame({{9, 0, 0}})), GST_FLOW_OK);
  ASSERT_EQ(element.push(make_frame({{1, 0, 0}})), GST_FLOW_OK);
  EXPECT_SAYS(element.branch("src_0").caps(), "other/tensor, dimension=(string)3:1");
  EXPECT_SAYS(element.branch("src_1").caps(), "other/tensors, format=(string)static");
}

TEST(TensorIfFlow, ToleratesAnUnlinkedBranch) {
  Branches element("tensor_if compared-value-option=0,0 operator=GT supplied-value=5", {},
                   {"src_0"});
  element.caps(one("1"));
  EXPECT_EQ(element.push(make_frame({{9}})), GST_FLOW_OK) << "the other branch may be linked";
  EXPECT_EQ(element.push(make_frame({{1}})), GST_FLOW_OK);
  EXPECT_EQ(element.push(make_frame({{9}})), GST_FLOW_OK);

  Branches alone("tensor_if compared-value-option=0,0 operator=GT supplied-value=5 else=SKIP", {},
                 {"src_0"});
  alone.caps(one("1"));
  EXPECT_EQ(alone.push(make_frame({{9}})), GST_FLOW_NOT_LINKED);
}

TEST(TensorIfFlow, BothBranchesEnd) {
  Branches element("tensor_if compared-value-option=0,0 operator=GT supplied-value=5");
  element.caps(one("1"));
  ASSERT_EQ(element.push(make_frame({{9}})), GST_FLOW_OK);
  EXPECT_TRUE(element.send(gst_event_new_eos()));
  EXPECT_EQ(element.branch("src_0").events.back(), "eos");
  EXPECT_EQ(element.branch("src_1").events, names({"stream-start", "caps", "segment", "eos"}));
  EXPECT_EQ(element.error(), "");
}

TEST(TensorIfProperties, CanChangeBetweenFrames) {
  Branches element("tensor_if compared-value-option=0,0 operator=GT supplied-value=5 else=SKIP");
  element.caps(one("1"));
  const auto passes = [&](uint8_t value) {
    const uint64_t before = element.stat("pushed");
    EXPECT_EQ(element.push(make_frame({{value}})), GST_FLOW_OK);
    return element.stat("pushed") > before;
  };
  EXPECT_TRUE(passes(6));
  g_object_set(element.element(), "supplied-value", "50", nullptr);
  EXPECT_FALSE(passes(6));
  EXPECT_TRUE(passes(51));
  gst_util_set_object_arg(G_OBJECT(element.element()), "operator", "RANGE_INCLUSIVE");
  EXPECT_TRUE(passes(51)) << "one number is not a range: the old settings are kept";
  EXPECT_SAYS(element.warning(), "WEIR-1004: tensor_if needs to know what to compare with");
  g_object_set(element.element(), "supplied-value", "10,20", nullptr);
  EXPECT_TRUE(passes(15));
  EXPECT_FALSE(passes(51));
  g_object_set(element.element(), "supplied-value", "ten", nullptr);
  EXPECT_TRUE(passes(15));
  EXPECT_SAYS(element.warning(), "    ten\n    ^");
  EXPECT_EQ(element.error(), "");
}

TEST(TensorIfProperties, AreRejectedIfDownstreamRejectsTheResult) {
  Branches element(
      "tensor_if compared-value-option=0,0 operator=GT supplied-value=5 then=TENSORPICK "
      "then-option=0 else=SKIP",
      {{"src_0", "other/tensors,format=static,num_tensors=1"}});
  element.caps(test::tensors("uint8,uint8", "1,1"));
  ASSERT_EQ(element.push(make_frame({{9}, {7}})), GST_FLOW_OK);
  EXPECT_EQ(content(element.take("src_0").get(), 0), Bytes{9});
  g_object_set(element.element(), "then-option", "1,0", nullptr);
  ASSERT_EQ(element.push(make_frame({{9}, {7}})), GST_FLOW_OK);
  EXPECT_SAYS(element.warning(),
              "WEIR-2001: the element downstream of src_0 does not accept its output");
  EXPECT_EQ(content(element.take("src_0").get(), 0), Bytes{9});
  gchar* raw = nullptr;
  g_object_get(element.element(), "then-option", &raw, nullptr);
  EXPECT_STREQ(UniqueText{raw}.get(), "0");
  g_object_set(element.element(), "then-option", "1", nullptr);
  ASSERT_EQ(element.push(make_frame({{9}, {7}})), GST_FLOW_OK);
  EXPECT_EQ(content(element.take("src_0").get(), 0), Bytes{7});
  EXPECT_EQ(element.error(), "");
}

}  // namespace tensor_if_test
}  // namespace weir::test
