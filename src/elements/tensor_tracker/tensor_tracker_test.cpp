// Tests of tensor_tracker: the column it fills, what it keeps, and streams that it refuses.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>
#include <limits>

#include "core/tensor/tensor_header.hpp"
#include "elements/tests/element_test_support.hpp"
#include "elements/tests/pipeline_test_support.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"
#include "gstcpp/element/result_events.hpp"

namespace weir {
namespace tensor_tracker_test {

using namespace weir::test;
using Floats = std::vector<float>;

const std::string kRows =
    tensors("float32", "8:1", "10/1") +
    ",weir-columns=(string)\"x1,y1,x2,y2,score,class,parent,own\",weir-source=(string)net";

GstBuffer* row(Floats numbers, GstClockTime time) {
  Bytes bytes(numbers.size() * sizeof(float));
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return frame(bytes, time);
}
Floats pushed(const Harness& h, GstBuffer* in) {
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  const Bytes bytes = content(out.get());
  Floats numbers((bytes.size() - kTensorHeaderBytes) / sizeof(float));
  std::memcpy(numbers.data(), bytes.data() + kTensorHeaderBytes, numbers.size() * sizeof(float));
  return numbers;
}

TEST(TensorTracker, AddsTheColumnAndKeepsTheOthers) {
  const auto h = make_harness("tensor_tracker min-hits=1", kRows);
  const Floats in{10, 10, 30, 40, 0.9f, 3, -1, 77};
  EXPECT_EQ(pushed(h, row(in, 0)), (Floats{10, 10, 30, 40, 0.9f, 3, -1, 77, 1}));
  EXPECT_EQ(pushed(h, row(in, GST_SECOND / 10)), (Floats{10, 10, 30, 40, 0.9f, 3, -1, 77, 1}));
  EXPECT_SAYS(caps_text(h), "own\\,track");
  EXPECT_SAYS(caps_text(h), "weir-source=(string)net");
}

TEST(TensorTracker, BackgroundAndChildrenHaveNoTrack) {
  const auto h = make_harness("tensor_tracker min-hits=1", kRows);
  EXPECT_EQ(pushed(h, row(Floats(8, 0), 0)), Floats(9, 0));
  const Floats child{10, 10, 30, 40, 0.9f, 3, 0, 77};
  EXPECT_EQ(pushed(h, row(child, GST_SECOND / 10)).back(), 0);
}

TEST(TensorTracker, FramesWithoutTimesAreFollowed) {
  const auto h = make_harness("tensor_tracker", kRows);
  const Floats in{10, 10, 30, 40, 0.9f, 3, -1, 77};
  EXPECT_EQ(pushed(h, row(in, GST_CLOCK_TIME_NONE)).back(), 0);  // min-hits is 2
  EXPECT_EQ(pushed(h, row(in, GST_CLOCK_TIME_NONE)).back(), 1);
}

TEST(TensorTracker, RefusesStreamsWithoutBoxes) {
  const auto error = error_of_pipeline(
      "videotestsrc num-buffers=1 ! video/x-raw,format=RGB,width=4,height=4 ! tensor_converter ! "
      "tensor_tracker ! fakesink");
  EXPECT_SAYS(error, "tensor_tracker needs rows of results with boxes");
  EXPECT_SAYS(error, "uint8 3:4:4");
  EXPECT_SAYS(error, "tensor_decoder mode=detection ! tensor_tracker");
}

TEST(TensorTracker, BoxesThatAreNotFiniteHaveNoTrack) {
  const auto h = make_harness("tensor_tracker min-hits=1", kRows);
  const float infinite = std::numeric_limits<float>::infinity();
  EXPECT_EQ(pushed(h, row({10, 10, infinite, 40, 0.9f, 3, -1, 77}, 0)).back(), 0);
}

TEST(TensorTracker, PlainFlexibleRowsAreRefusedWithBothWays) {
  const auto error = error_of_pipeline(
      "videotestsrc num-buffers=1 ! video/x-raw,format=GRAY8,width=4,height=1 ! tensor_converter ! "
      "tensor_transform mode=typecast option=float32 ! other/tensors,format=flexible ! "
      "tensor_tracker ! fakesink");
  EXPECT_SAYS(error, "plain rows only with format=static");
  EXPECT_SAYS(error, "other/tensors,format=static ! tensor_tracker");
  EXPECT_SAYS(error, "tensor_decoder mode=detection ! tensor_tracker");
}

TEST(TensorTracker, ALowScoreAboveTheHighOneStopsAStreamThatPlays) {
  const auto h = make_harness("tensor_tracker", kRows);
  const Floats in{10, 10, 30, 40, 0.9f, 3, -1, 77};
  pushed(h, row(in, 0));
  gst_harness_set(h.get(), "tensor_tracker", "low", 0.75, nullptr);
  EXPECT_EQ(gst_harness_push(h.get(), row(in, 1)), GST_FLOW_ERROR);
  EXPECT_EQ(stat(h, "tensor_tracker", "consumed"), 1u);
}

TEST(TensorTracker, EqualLowAndHighScoresAreAllowed) {
  const auto h = make_harness("tensor_tracker min-hits=1 low=0.5 high=0.5", kRows);
  EXPECT_EQ(pushed(h, row({10, 10, 30, 40, 0.9f, 3, -1, 77}, 0)).back(), 1);
}

// A frame of another machine may have any number of rows.
TEST(TensorTracker, RowsBeyondTheLimitHaveNoTrackAndOneWarning) {
  const auto h = make_harness("tensor_tracker min-hits=1", tensors("float32", "6:30000", "10/1"));
  Errors errors(find_element(h, "tensor_tracker").get());
  Floats rows;
  for (int i = 0; i < 30000; ++i) {
    const Floats one{0, 0, 100, 100, i % 3 == 0 ? 0.9f : 0.8f, 1};
    rows.insert(rows.end(), one.begin(), one.end());
  }
  const Floats out = pushed(h, row(rows, 0));
  int numbered = 0;
  for (size_t i = 0; i < 30000; ++i) numbered += out[7 * i + 6] != 0 && i % 3 == 0;
  EXPECT_EQ(numbered, 10000);
  pushed(h, row(rows, GST_SECOND / 10));
  const std::string warning = errors.next_warning();
  EXPECT_SAYS(warning, "WEIR-2006: a frame has more boxes than tensor_tracker follows");
  EXPECT_SAYS(warning, "30000 boxes");
  EXPECT_SAYS(warning, "at most 10000");
  EXPECT_EQ(errors.next_warning(), "");
}

TEST(TensorTracker, TimesThatRepeatAreNoMotionAndThoseThatGoBackForget) {
  const auto h = make_harness("tensor_tracker min-hits=1", kRows);
  const auto number_at = [&](GstClockTime time) {
    return pushed(h, row({10, 10, 30, 40, 0.9f, 3, -1, 77}, time)).back();
  };
  EXPECT_EQ(number_at(5 * GST_SECOND), 1);
  EXPECT_EQ(number_at(5 * GST_SECOND), 1);
  EXPECT_EQ(number_at(4 * GST_SECOND), 2);
  EXPECT_EQ(number_at(60 * GST_SECOND), 3);           // beyond max-age
  EXPECT_EQ(number_at(3600 * 1000 * GST_SECOND), 4);  // weeks later
  EXPECT_EQ(stat(h, "tensor_tracker", "tracks"), 1u);
  EXPECT_EQ(stat(h, "tensor_tracker", "numbers-given"), 4u);
}

TEST(TensorTracker, FramesWithoutResultsAreAGap) {
  const auto h = make_harness("tensor_tracker min-hits=1", kRows);
  const Floats in{10, 10, 30, 40, 0.9f, 3, -1, 77};
  EXPECT_EQ(pushed(h, row(in, 0)).back(), 1);
  for (int i = 1; i < 5; ++i)
    EXPECT_EQ(pushed(h, row(Floats(8, 0), static_cast<GstClockTime>(i) * GST_SECOND / 10)),
              Floats(9, 0));
  EXPECT_EQ(pushed(h, row(in, GST_SECOND / 2)).back(), 1);
}

TEST(TensorTracker, LabelsPass) {
  const auto h = make_harness("tensor_tracker", kRows);
  gst_harness_push_event(h.get(), gst::make_labels_event({"net", {"person"}}).release());
  std::vector<std::string> found;
  while (auto event = Ref<GstEvent>::adopt(gst_harness_try_pull_event(h.get())))
    if (const auto labels = gst::parse_labels_event(event.get()))
      found.push_back(labels->source + ": " + labels->labels.at(0));
  EXPECT_EQ(found, std::vector<std::string>{"net: person"});
}

GstMemory* chunk(ElementType type, const std::string& dimensions, const Bytes& bytes) {
  TensorHeader header;
  header.spec = {.type = type, .shape = Shape::parse(dimensions), .name = {}};
  header.format = Format::Flexible;
  auto* memory = gst_allocator_alloc(nullptr, kTensorHeaderBytes + bytes.size(), nullptr);
  const gst::MappedMemory map(memory, GST_MAP_WRITE);
  write_tensor_header(header, map.bytes().first<kTensorHeaderBytes>());
  std::memcpy(map.bytes().data() + kTensorHeaderBytes, bytes.data(), bytes.size());
  return memory;
}
GstMemory* chunk(const std::string& dimensions, const Floats& numbers) {
  Bytes bytes(numbers.size() * sizeof(float));
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return chunk(ElementType::Float32, dimensions, bytes);
}
float last_number(GstMemory* memory) {
  const gst::MappedMemory map(memory, GST_MAP_READ);
  float out = 0;
  std::memcpy(&out, map.bytes().data() + map.bytes().size() - sizeof(float), sizeof(float));
  return out;
}

// Two detectors, masks and texts: each keeps its place, its map and its memory.
TEST(TensorTracker, MasksTextsAndSeveralRowsKeepTheirPlaces) {
  const auto h = make_harness(
      "tensor_tracker min-hits=1",
      "other/tensors,format=flexible,framerate=10/1,weir-source=(string)\"a\\;a\\;a\\;b\","
      "weir-columns=(string)\"x1,y1,x2,y2,score;masks;text;x1,y1,x2,y2,score,track\"");
  GstBuffer* in = gst_buffer_new();
  gst_buffer_append_memory(in, chunk("5:1", {10, 10, 30, 40, 0.9f}));
  gst_buffer_append_memory(in, chunk(ElementType::UInt8, "4:4:1", Bytes(16)));
  gst_buffer_append_memory(in, chunk(ElementType::UInt8, "8:1", Bytes(8)));
  gst_buffer_append_memory(in, chunk("6:1", {10, 10, 30, 40, 0.8f, 99}));
  GST_BUFFER_PTS(in) = 0;
  std::vector<SourceMap> given(4);
  for (size_t i = 0; i < 4; ++i) given[i].x0 = static_cast<float>(i);
  gst::set_source_maps(in, given);
  const auto masks = Ref<GstMemory>::share(gst_buffer_peek_memory(in, 1));
  const auto texts = Ref<GstMemory>::share(gst_buffer_peek_memory(in, 2));
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  ASSERT_TRUE(out);
  ASSERT_EQ(gst_buffer_n_memory(out.get()), 4u);
  EXPECT_EQ(gst_buffer_peek_memory(out.get(), 1), masks.get());
  EXPECT_EQ(gst_buffer_peek_memory(out.get(), 2), texts.get());
  EXPECT_EQ(last_number(gst_buffer_peek_memory(out.get(), 0)), 1);
  EXPECT_EQ(last_number(gst_buffer_peek_memory(out.get(), 3)), 2);  // another object, not 99
  const auto maps = gst::source_maps(out.get());
  ASSERT_EQ(maps.size(), 4u);
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(maps[i].x0, static_cast<float>(i));
  EXPECT_SAYS(caps_text(h), "weir-source=(string)\"a\\;a\\;a\\;b\"");
  EXPECT_SAYS(caps_text(h), "x1\\,y1\\,x2\\,y2\\,score\\,track\\;masks\\;text\\;");
}

GstBuffer* rows_and_vectors(const std::string& dimensions, const Floats& vectors,
                            const Floats& rows, GstClockTime time) {
  GstBuffer* in = gst_buffer_new();
  gst_buffer_append_memory(in, chunk("5:2", rows));
  gst_buffer_append_memory(in, chunk(dimensions, vectors));
  GST_BUFFER_PTS(in) = time;
  return in;
}
const std::string kTwo =
    "other/tensors,format=flexible,framerate=10/1,"
    "weir-columns=(string)\"x1,y1,x2,y2,score;\"";
const Floats kPair{100, 0, 140, 80, 0.9f, 112, 0, 152, 80, 0.9f};
const Floats kMoved{102, 0, 142, 80, 0.9f, 110, 0, 150, 80, 0.9f};  // they changed places

TEST(TensorTracker, EmbeddingsSeparateObjects) {
  for (const bool has_embeddings : {true, false}) {
    const auto h = make_harness(
        has_embeddings ? "tensor_tracker min-hits=1 embeddings=1" : "tensor_tracker min-hits=1",
        kTwo);
    const auto last = [&](const Floats& vectors, const Floats& rows, GstClockTime time) {
      const auto out = Ref<GstBuffer>::adopt(
          gst_harness_push_and_pull(h.get(), rows_and_vectors("3:2", vectors, rows, time)));
      EXPECT_EQ(gst_buffer_n_memory(out.get()), 2u);
      return last_number(gst_buffer_peek_memory(out.get(), 0));
    };
    EXPECT_EQ(last({1, 0, 0, 0, 1, 0}, kPair, 0), 2);
    EXPECT_EQ(last({0, 1, 0, 1, 0, 0}, kMoved, GST_SECOND / 10), has_embeddings ? 1 : 2);
  }
}

TEST(TensorTracker, EmbeddingsThatAreNotAVectorForEachRowAreRefused) {
  struct Case {
    const char *element, *dimensions;
    size_t numbers;
    const char* offered;
  };
  for (const auto& [element, dimensions, numbers, offered] :
       {Case{"tensor_tracker embeddings=1", "3:3", 9, "offered: float32 3:3 for 2 rows"},
        Case{"tensor_tracker embeddings=1", "3:1", 3, "offered: float32 3:1 for 2 rows"},
        Case{"tensor_tracker embeddings=0", "3:2", 6, "tensor 0 is not a vector for each row"},
        Case{"tensor_tracker embeddings=2", "3:2", 6, "offered: 2 tensors"}}) {
    const auto h = make_harness(element, kTwo);
    const auto bus = Ref<GstBus>::adopt(gst_bus_new());
    const auto tracker = find_element(h, "tensor_tracker");
    gst_element_set_bus(tracker.get(), bus.get());
    EXPECT_EQ(gst_harness_push(h.get(), rows_and_vectors(dimensions, Floats(numbers, 1), kPair, 0)),
              GST_FLOW_ERROR);
    const auto message = Ref<GstMessage>::adopt(gst_bus_pop_filtered(bus.get(), GST_MESSAGE_ERROR));
    ASSERT_TRUE(message);
    GError* error = nullptr;
    gst_message_parse_error(message.get(), &error, nullptr);
    EXPECT_SAYS(std::string(error->message), offered);
    EXPECT_SAYS(std::string(error->message), "a vector of L numbers for each of the N rows");
    EXPECT_SAYS(std::string(error->message), "fix: embeddings=NUMBER");
    g_clear_error(&error);
    gst_element_set_bus(tracker.get(), nullptr);
  }
}

TEST(TensorTracker, RowsThatAreNotTheColumnsStopTheStream) {
  const auto h = make_harness("tensor_tracker",
                              "other/tensors,format=flexible,framerate=10/1,"
                              "weir-columns=(string)\"x1,y1,x2,y2,score\"");
  GstBuffer* in = gst_buffer_new();
  gst_buffer_append_memory(in, chunk("7:1", Floats(7, 1)));
  EXPECT_EQ(gst_harness_push(h.get(), in), GST_FLOW_ERROR);
}

}  // namespace tensor_tracker_test
}  // namespace weir
