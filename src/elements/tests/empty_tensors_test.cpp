// Tensors without elements, such as the rows of a network that has found nothing, in each element
// that takes flexible streams: no error, no value that was not there, and the next frame as before.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <fstream>

#include "elements/tests/flexible_frame_test_support.hpp"
#include "says.hpp"

namespace empty_tensors_test {

using namespace weir;
using namespace weir::test;

TensorSpec rows(uint32_t columns, uint32_t count, ElementType type = ElementType::Float32) {
  TensorSpec spec{type, Shape{columns, count}, ""};
  spec.shape.set_rank(2);
  return spec;
}
GstBuffer* rows_frame(uint32_t columns, uint32_t count, GstClockTime time) {
  std::vector<float> values(size_t{columns} * count);
  std::iota(values.begin(), values.end(), 1.f);
  GstBuffer* out = flexible_frame(rows(columns, count), values);
  GST_BUFFER_PTS(out) = time;
  GST_BUFFER_DURATION(out) = GST_SECOND / 10;
  return out;
}
std::string filter(const std::string& framework, const std::string& properties) {
  const std::string path = testing::TempDir() + "weir_empty_model.bin";
  std::ofstream(path) << "x";
  return "tensor_filter framework=" + framework + " model=" + path + " " + properties;
}
size_t count_gaps(const Harness& h) {
  const auto names = event_names(h);
  return static_cast<size_t>(std::count(names.begin(), names.end(), "gap"));
}
Ref<GstBuffer> pull(const Harness& h) {
  return Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
}

// Words 22 and 23 of docs/compatibility/types-and-caps.md 1.7.
TEST(EmptyTensors, ComeFromAModelThatDecidesItsSizes) {
  auto h = make_harness(filter("fake-async", "invoke-dynamic=true custom=dynamic:1"),
                        tensors("float32", "4:1"));
  ASSERT_EQ(gst_harness_push(h.get(), frame<float>({0, 7, 8, 9}, 5)), GST_FLOW_OK);
  const auto out = pull(h);
  ASSERT_TRUE(out);
  const auto words = values<uint32_t>(out.get());
  ASSERT_EQ(words.size(), 32u);
  EXPECT_EQ(words[3], 0u);
  EXPECT_EQ(words[4], 1u);
  EXPECT_EQ(words[5], 0u);
  EXPECT_EQ(words[19], 1u);
  EXPECT_EQ(words[22], 2u);
  EXPECT_EQ(words[23], 4u);
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 5u);
}

TEST(EmptyTensors, AreGapsWhereTheOutputIsStatic) {
  auto h = make_harness(filter("fake-async", "custom=empty:1,outputs:1 invoke-async=true"),
                        tensors("float32", "4:1"));
  Errors errors(h);
  ASSERT_EQ(gst_harness_push(h.get(), frame<float>({1, 7, 8, 9}, 5)), GST_FLOW_OK);
  gst_harness_push_event(h.get(), gst_event_new_eos());
  std::vector<std::string> names;
  while (names.empty() || names.back() != "eos") {
    const auto event = Ref<GstEvent>::adopt(gst_harness_pull_event(h.get()));
    ASSERT_TRUE(event);
    names.emplace_back(GST_EVENT_TYPE_NAME(event.get()));
  }
  EXPECT_EQ(std::count(names.begin(), names.end(), "gap"), 1);
  EXPECT_FALSE(pull(h));
  EXPECT_EQ(stat(h, "tensor_filter", "received"), 1u);
  EXPECT_EQ(stat(h, "tensor_filter", "pushed"), 0u);
}

// A dark picture must not end the stream.
TEST(EmptyTensors, AreEmptyListsOfResults) {
  auto h = make_harness("tensor_decoder mode=json",
                        std::string(kFlexibleCaps) + ",weir-columns=\"x1,y1,x2,y2,score\"");
  for (const uint32_t count : {1u, 0u, 2u})
    ASSERT_EQ(gst_harness_push(h.get(), rows_frame(5, count, 0)), GST_FLOW_OK);
  for (const char* detections :
       {"[{\"box\":[1,2,3,4],\"score\":5}]", "[]",
        "[{\"box\":[1,2,3,4],\"score\":5},{\"box\":[6,7,8,9],\"score\":10}]"}) {
    const auto out = pull(h);
    ASSERT_TRUE(out);
    const Bytes text = content(out.get());
    EXPECT_SAYS(std::string(text.begin(), text.end()), "\"detections\":" + std::string(detections));
  }
}

// A drawing of no results is a picture without a pixel that is seen, so that a mixer goes on.
TEST(EmptyTensors, AreTransparentPictures) {
  struct Drawing {
    const char* launch;
    Shape found, nothing;
    size_t rank;
  };
  for (const Drawing& drawing :
       {Drawing{"tensor_decoder mode=bounding_boxes option1=yolov10 option4=8:8 option5=8:8",
                {6, 1},
                {6, 0},
                2},
        Drawing{"tensor_decoder mode=pose_estimation option1=8:8 option2=2:2",
                {14, 2, 2},
                {14, 2, 0},
                3}}) {
    auto h = make_harness(drawing.launch, kFlexibleCaps);
    for (const Shape& shape : {drawing.found, drawing.nothing, drawing.found}) {
      TensorSpec spec{ElementType::Float32, shape, ""};
      spec.shape.set_rank(drawing.rank);
      const std::vector<float> values(spec.shape.count().value_or(0), 0.5f);
      ASSERT_EQ(gst_harness_push(h.get(), flexible_frame(spec, values)), GST_FLOW_OK);
    }
    const Bytes transparent(4 * 8 * 8);
    for (const bool is_drawn : {true, false, true}) {
      const auto out = pull(h);
      ASSERT_TRUE(out) << drawing.launch;
      EXPECT_EQ(content(out.get()) != transparent, is_drawn) << drawing.launch;
    }
  }
}

struct Lossy {
  const char* name;
  const char* launch;
};
class EmptyTensorsLost : public testing::TestWithParam<Lossy> {};

// Where the output cannot hold them, a GAP event says that their time has passed.
TEST_P(EmptyTensorsLost, AreGapsAndCounted) {
  auto h = make_harness(GetParam().launch, kFlexibleCaps);
  for (const uint32_t count : {2u, 0u, 2u})
    ASSERT_EQ(gst_harness_push(h.get(), rows_frame(4, count, 0)), GST_FLOW_OK);
  const auto first = pull(h), second = pull(h);
  ASSERT_TRUE(first && second);
  EXPECT_FALSE(pull(h));
  EXPECT_EQ(content(first.get()), content(second.get()));
  EXPECT_EQ(count_gaps(h), 1u);
  const std::string element(GetParam().launch, 0, std::string(GetParam().launch).find(' '));
  EXPECT_EQ(stat(h, element.c_str(), "dropped-policy"), 1u);
}
INSTANTIATE_TEST_SUITE_P(Elements, EmptyTensorsLost,
                         testing::Values(Lossy{"Converter", "tensor_converter"},
                                         Lossy{"Transform",
                                               "tensor_transform mode=arithmetic option=mul:2"},
                                         Lossy{"OctetStream", "tensor_decoder mode=octet_stream"},
                                         Lossy{"FlatBuf", "tensor_decoder mode=flatbuf"}),
                         [](const auto& info) { return std::string(info.param.name); });

// A network takes no input without elements, unless its engine declares that it does.
TEST(EmptyTensors, AreNotGivenToModels) {
  auto h = make_harness(filter("fake", ""), kFlexibleCaps);
  for (const uint32_t count : {1u, 0u, 1u})
    ASSERT_EQ(gst_harness_push(h.get(), rows_frame(4, count, 0)), GST_FLOW_OK);
  EXPECT_TRUE(pull(h) && pull(h));
  EXPECT_FALSE(pull(h));
  EXPECT_EQ(count_gaps(h), 1u);
  EXPECT_EQ(stat(h, "tensor_filter", "dropped-policy"), 1u);
}

TEST(EmptyTensors, PassElementsThatOnlyRouteThem) {
  for (const char* launch : {"tensor_rate", "tensor_debug"}) {
    auto h = make_harness(launch, kFlexibleCaps);
    ASSERT_EQ(gst_harness_push(h.get(), rows_frame(4, 0, 0)), GST_FLOW_OK) << launch;
    gst_harness_push_event(h.get(), gst_event_new_eos());  // tensor_rate waits for it
    const auto out = pull(h);
    ASSERT_TRUE(out) << launch;
    const Bytes bytes = content(out.get());
    const auto header = read_tensor_header(std::as_bytes(std::span(bytes)));
    ASSERT_TRUE(header) << launch;
    EXPECT_EQ(header->spec.shape.to_string(), "4:0") << launch;
  }
}

}  // namespace empty_tensors_test
