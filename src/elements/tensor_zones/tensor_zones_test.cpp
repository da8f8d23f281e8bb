// Tests of tensor_zones: caps, results, events, messages, files that change, times.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "core/tensor/tensor_header.hpp"
#include "elements/tests/element_test_support.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"
#include "gstcpp/element/result_events.hpp"

namespace weir {
namespace tensor_zones_test {

using namespace weir::test;

constexpr char kYard[] =
    R"({"version":1,"zones":[{"name":"yard","polygon":[[0,0],[100,0],[100,100],[0,100]]}]})";
constexpr char kGate[] = R"({"version":1,"zones":[{"name":"gate","line":[[0,50],[100,50]]}],)"
                         R"("ground":{"metres_per_pixel":0.1}})";

std::string results(const std::string& columns, const std::string& dimensions) {
  return tensors("float32", dimensions, "10/1") + ",weir-columns=(string)\"" + columns +
         "\",weir-source=(string)yolo";
}
const std::string kCaps = results("x1,y1,x2,y2,score,class,track", "7:1");

// A row whose bottom centre is at x, y.
std::vector<float> object(float x, float y, float track, float class_index = 0) {
  return {x - 5, y - 20, x + 5, y, 1, class_index, track};
}

class TensorZones : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              ("weir-tensor-zones-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    path_ = folder_ / "zones.json";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void write(const std::string& text) const {
    const auto other = folder_ / "new.json";
    std::ofstream(other) << text;
    std::filesystem::rename(other, path_);
  }
  std::string launch(const std::string& more = "") const {
    return "tensor_zones zones=" + path_.string() + " " + more;
  }
  std::string json_launch(const std::string& more = "") const {
    return launch(more) + " ! tensor_decoder mode=json";
  }
  static std::string line(const Harness& h, const std::vector<float>& rows,
                          GstClockTime time = GST_CLOCK_TIME_NONE) {
    auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(rows, time)));
    if (!out) return "(nothing)";
    const Bytes bytes = content(out.get());
    return {bytes.begin(), bytes.end()};
  }

  std::filesystem::path folder_, path_;
};

// The element messages on the bus, one text each.
std::vector<std::string> messages(GstBus* bus) {
  std::vector<std::string> out;
  while (auto* message = gst_bus_pop_filtered(bus, GST_MESSAGE_ELEMENT)) {
    const auto text =
        Unique<char, g_free>(gst_structure_to_string(gst_message_get_structure(message)));
    out.emplace_back(text.get());
    gst_message_unref(message);
  }
  return out;
}

TEST_F(TensorZones, JoinsTheRowsAndTheJson) {
  write(kYard);
  const auto h = make_harness(json_launch(), kCaps);
  EXPECT_EQ(
      line(h, object(50, 150, 7), 0),
      R"({"version":1,"time":0,"source":"yolo","detections":[{"box":[45,130,55,150],"score":1,)"
      R"("index":0,"label":"0","track":7}],"zones":[{"name":"yard","inside":0,"entered":0,)"
      R"("left":0,"classes":[]}],"events":[]})"
      "\n");
  EXPECT_EQ(
      line(h, object(50, 50, 7), GST_SECOND / 2),
      R"({"version":1,"time":0.5,"source":"yolo","detections":[{"box":[45,30,55,50],"score":1,)"
      R"("index":0,"label":"0","track":7,"speed":200,"zones":[{"name":"yard","dwell":0}]}],)"
      R"("zones":[{"name":"yard","inside":1,"entered":1,"left":0,"speed":200,"classes":[)"
      R"({"index":0,"label":"0","inside":1,"entered":1,"left":0,"speed":200}]}],)"
      R"("events":[{"event":"enter","zone":"yard","track":7,"index":0,"label":"0","speed":200}]})"
      "\n");
}

TEST_F(TensorZones, TheStreamIsFlexibleWithTheColumnsOfZones) {
  write(kYard);
  const auto h = make_harness(launch("zones-per-object=2 source=mine"), kCaps);
  const auto out =
      Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), frame(object(50, 50, 7), 3, 9)));
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 3u);
  EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 9u);
  EXPECT_EQ(gst_buffer_n_memory(out.get()), 3u);
  const std::string caps = caps_text(h);
  EXPECT_SAYS(caps, "format=(string)flexible");
  EXPECT_SAYS(caps, "framerate=(fraction)10/1");
  EXPECT_SAYS(caps, "zone:2\\,dwell:2");
  EXPECT_SAYS(caps, "yolo\\;mine\\;mine");
  EXPECT_LACKS(caps, "dimensions");
}

TEST_F(TensorZones, MasksAndOtherTensorsPassByReference) {
  write(kYard);
  const auto h = make_harness(launch(),
                              "other/tensors,format=flexible,framerate=10/1,"
                              "weir-columns=(string)\"x1,y1,x2,y2,track;class-map\"");
  const auto chunk = [](ElementType type, const std::string& dimensions, size_t bytes) {
    TensorHeader header;
    header.spec = {.type = type, .shape = Shape::parse(dimensions), .name = {}};
    header.format = Format::Flexible;
    auto* memory = gst_allocator_alloc(nullptr, kTensorHeaderBytes + bytes, nullptr);
    const gst::MappedMemory map(memory, GST_MAP_WRITE);
    write_tensor_header(header, map.bytes().first<kTensorHeaderBytes>());
    std::fill(map.bytes().begin() + kTensorHeaderBytes, map.bytes().end(), std::byte{});
    return memory;
  };
  GstBuffer* in = gst_buffer_new();
  gst_buffer_append_memory(in, chunk(ElementType::Float32, "5:1", 20));
  gst_buffer_append_memory(in, chunk(ElementType::UInt8, "8:4", 32));
  GST_BUFFER_PTS(in) = 0;
  SourceMap first, second;
  first.x0 = 1, second.x0 = 2;
  gst::set_source_maps(in, {first, second});
  const auto held = Ref<GstMemory>::share(gst_buffer_peek_memory(in, 1));
  const auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  ASSERT_TRUE(out);
  ASSERT_EQ(gst_buffer_n_memory(out.get()), 4u);
  EXPECT_EQ(gst_buffer_peek_memory(out.get(), 1), held.get());
  const auto maps = gst::source_maps(out.get());
  ASSERT_EQ(maps.size(), 4u);
  EXPECT_EQ(maps[0].x0, 1);
  EXPECT_EQ(maps[1].x0, 2);
  EXPECT_EQ(stat(h, "tensor_zones", "bytes-copied"), 0u);
}

TEST_F(TensorZones, EventsAreMessages) {
  write(kGate);
  const auto h = make_harness(launch(), kCaps);
  gst_harness_push_event(h.get(), gst::make_labels_event({"yolo", {"person", "car"}}).release());
  const auto bus = Ref<GstBus>::adopt(gst_bus_new());
  const auto element = find_element(h, "tensor_zones");
  gst_element_set_bus(element.get(), bus.get());
  for (int i = 0; i < 3; ++i)
    line(h, object(50, 40 + 10.0f * static_cast<float>(i), 7, 1),
         static_cast<GstClockTime>(i) * GST_SECOND / 10);
  const auto all = messages(bus.get());
  gst_element_set_bus(element.get(), nullptr);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0],
            "weir-zone-event, event=(string)forward, zone=(string)gate, track=(uint)7, "
            "running-time=(guint64)100000000, class=(int)1, label=(string)car, speed=(double)100, "
            "ground-speed=(double)10;");
  EXPECT_EQ(stat(h, "tensor_zones", "events"), 1u);
}

TEST_F(TensorZones, MessagesCanBeSwitchedOff) {
  write(kYard);
  const auto h = make_harness(launch("post-messages=false"), kCaps);
  const auto bus = Ref<GstBus>::adopt(gst_bus_new());
  const auto element = find_element(h, "tensor_zones");
  gst_element_set_bus(element.get(), bus.get());
  line(h, object(50, 50, 7), 0);
  EXPECT_TRUE(messages(bus.get()).empty());
  gst_element_set_bus(element.get(), nullptr);
  EXPECT_EQ(stat(h, "tensor_zones", "events"), 1u);
}

TEST_F(TensorZones, SendsNamesAndZonesDownstream) {
  write(kYard);
  const auto h = make_harness(launch(), kCaps);
  line(h, object(50, 50, 7), 0);
  std::vector<std::string> found;
  while (auto event = Ref<GstEvent>::adopt(gst_harness_try_pull_event(h.get()))) {
    if (const auto labels = gst::parse_labels_event(event.get()))
      found.push_back(labels->source + ": " + labels->labels.at(0));
    if (const auto zones = gst::parse_zones_event(event.get()))
      found.push_back(zones->source + ": " + zones->zones);
  }
  EXPECT_EQ(found, (std::vector<std::string>{"zones: yard", std::string("zones: ") + kYard}));
}

TEST_F(TensorZones, AFileThatChangesIsReadBetweenFrames) {
  write(kYard);
  const auto h = make_harness(json_launch(), kCaps);
  EXPECT_SAYS(line(h, object(50, 40, 7), 0), R"("zones":[{"name":"yard","inside":1)");
  write(kGate);
  const std::string text = line(h, object(50, 60, 7), GST_SECOND / 10);
  EXPECT_SAYS(text, R"("zones":[{"name":"gate","forward":1,"backward":0)");
  EXPECT_SAYS(text, R"("ground_speed":20)");
  EXPECT_LACKS(text, "yard");
  EXPECT_EQ(stat(h, "tensor_zones", "zones-files-read"), 2u);
}

TEST_F(TensorZones, ADamagedFileKeepsTheZonesAndWarnsOnce) {
  write(kYard);
  const auto h = make_harness(json_launch(), kCaps);
  const auto element = find_element(h, "tensor_zones");
  Errors errors(element.get());
  line(h, object(50, 40, 7), 0);
  write(R"({"version":1,"zones":[{"name":"yard","polygon":[[0,0],[1,)");
  EXPECT_SAYS(line(h, object(50, 40, 7), 1), R"("zones":[{"name":"yard","inside":1)");
  const auto text = errors.next_warning();
  EXPECT_SAYS(text, "WEIR-1004: the zones file cannot be used; the zones stay as they were");
  EXPECT_SAYS(text, path_.string());
  line(h, object(50, 40, 7), 2);
  EXPECT_EQ(errors.next_warning(), "");
  std::filesystem::remove(path_);
  EXPECT_SAYS(line(h, object(50, 40, 7), 3), R"("inside":1)");
  EXPECT_SAYS(errors.next_warning(), "WEIR-4001: the zones file cannot be read");
  write(kGate);
  EXPECT_SAYS(line(h, object(50, 40, 7), 4), "gate");
  EXPECT_EQ(errors.next_warning(), "");
  EXPECT_EQ(stat(h, "tensor_zones", "zones-files-refused"), 2u);
}

TEST_F(TensorZones, ThePropertyMayNameAnotherFileWhilePlaying) {
  write(kYard);
  const std::string gate = folder_ / "gate.json";
  std::ofstream(gate) << kGate;
  const auto h = make_harness(json_launch(), kCaps);
  const auto element = find_element(h, "tensor_zones");
  Errors errors(element.get());
  line(h, object(50, 40, 7), 0);
  g_object_set(element.get(), "zones", (folder_ / "none.json").c_str(), nullptr);
  EXPECT_SAYS(errors.next_warning(), "none.json: No such file or directory");
  EXPECT_SAYS(line(h, object(50, 40, 7), 1), "yard");
  g_object_set(element.get(), "zones", gate.c_str(), nullptr);
  EXPECT_SAYS(line(h, object(50, 60, 7), 2), R"("name":"gate","forward":1)");
  EXPECT_EQ(errors.next_warning(), "");
}

TEST_F(TensorZones, RefusesToStartWithoutZones) {
  EXPECT_SAYS(start_error("tensor_zones"), "WEIR-1004: tensor_zones has no zones");
  EXPECT_SAYS(start_error("tensor_zones zones=/nonexistent.json"), "WEIR-4001");
  EXPECT_SAYS(start_error("tensor_zones zones=" + folder_.string()), "it is a folder");
  write(R"({"version":1,"zones":[{"name":"a","polygon":[[0,0],[1,1]]}]})");
  EXPECT_SAYS(start_error(launch()), "zones[0].polygon is [[0,0],[1,1]], needs 3 to 1000 points");
}

TEST_F(TensorZones, RefusesResultsWithoutTracks) {
  write(kYard);
  const auto text = start_error(launch(), results("x1,y1,x2,y2,score,class", "6:1"));
  EXPECT_SAYS(text, "WEIR-2001: the results have no tracks");
  EXPECT_SAYS(text, "fix: tensor_decoder mode=detection ! tensor_tracker ! tensor_zones");
}

TEST_F(TensorZones, RefusesFramesThatDoNotFitTheColumns) {
  write(kYard);
  const auto h = make_harness(launch(), results("x1,y1,x2,y2,track", "7:1"));
  Errors errors(h);
  EXPECT_EQ(gst_harness_push(h.get(), frame(object(50, 50, 7), 0)), GST_FLOW_ERROR);
  EXPECT_SAYS(errors.next(), "needed: float32 5:N, rows of the columns");
  EXPECT_EQ(stat(h, "tensor_zones", "dropped"), 1u);
}

TEST_F(TensorZones, WarnsOnceOfObjectsWithoutATrack) {
  write(kYard);
  const auto h = make_harness(json_launch(), kCaps);
  const auto element = find_element(h, "tensor_zones");
  Errors errors(element.get());
  const auto push = [&](int frames, float track) {
    for (int i = 0; i < frames; ++i) line(h, object(50, 50, track), 0);
  };
  push(29, 0);
  EXPECT_EQ(errors.next_warning(), "");
  push(1, 0);
  const auto text = errors.next_warning();
  EXPECT_SAYS(text, "WEIR-2001: no object has a track number");
  EXPECT_SAYS(text, "fix: tensor_tracker ! tensor_zones");
  push(60, 0);
  EXPECT_EQ(errors.next_warning(), "");
}

TEST_F(TensorZones, DoesNotWarnWhereSomeObjectsAreFollowed) {
  write(kYard);
  const auto h = make_harness(json_launch(), kCaps);
  const auto element = find_element(h, "tensor_zones");
  Errors errors(element.get());
  line(h, object(50, 50, 7), 0);
  for (int i = 0; i < 60; ++i) line(h, object(50, 50, 0), 0);
  for (int i = 0; i < 60; ++i) line(h, std::vector<float>(7), 0);
  EXPECT_EQ(errors.next_warning(), "");
}

TEST_F(TensorZones, ATimeThatGoesBackEndsTracksWithAWarning) {
  write(kYard);
  const auto h = make_harness(json_launch(), kCaps);
  const auto element = find_element(h, "tensor_zones");
  Errors errors(element.get());
  line(h, object(50, 50, 7), 5 * GST_SECOND);
  const auto text = line(h, object(50, 50, 7), 2 * GST_SECOND);
  EXPECT_SAYS(text, R"("inside":1,"entered":2,"left":1)");
  EXPECT_SAYS(text, R"("events":[{"event":"leave")");
  EXPECT_SAYS(errors.next_warning(), "WEIR-2008: the time of a frame is before that of the last");
  line(h, object(50, 50, 7), GST_SECOND);
  EXPECT_EQ(errors.next_warning(), "");
  EXPECT_EQ(stat(h, "tensor_zones", "times-backward"), 2u);
}

TEST_F(TensorZones, ATimeThatJumpsAheadEndsTracksWithoutAWarning) {
  write(kYard);
  const auto h = make_harness(json_launch(), kCaps);
  const auto element = find_element(h, "tensor_zones");
  Errors errors(element.get());
  line(h, object(50, 50, 7), 0);
  line(h, object(50, 50, 7), GST_SECOND / 2);
  const auto text = line(h, object(50, 50, 7), 3600 * GST_SECOND);
  EXPECT_SAYS(text, R"("inside":1,"entered":2,"left":1)");
  EXPECT_SAYS(text,
              R"({"event":"leave","zone":"yard","track":7,"index":0,"label":"0","dwell":0.5})");
  EXPECT_EQ(errors.next_warning(), "");
  EXPECT_EQ(stat(h, "tensor_zones", "tracks"), 1u);
}

TEST_F(TensorZones, ARepeatedTimeCountsCrossingsWithoutSpeedsOrAWarning) {
  write(kGate);
  const auto h = make_harness(json_launch(), kCaps);
  const auto element = find_element(h, "tensor_zones");
  Errors errors(element.get());
  line(h, object(50, 40, 7), GST_SECOND);
  const auto text = line(h, object(50, 60, 7), GST_SECOND);
  EXPECT_SAYS(text, R"("forward":1)");
  EXPECT_LACKS(text, "speed");
  EXPECT_EQ(errors.next_warning(), "");
  EXPECT_EQ(stat(h, "tensor_zones", "times-backward"), 0u);
}

TEST_F(TensorZones, WhoTremblesOnALineIsCountedOnce) {
  write(kGate);
  const auto h = make_harness(json_launch(), kCaps);
  std::string text;
  for (int i = 0; i < 20; ++i)
    text = line(h, object(50, i == 0 ? 40.0f : 49.0f + static_cast<float>(i % 2) * 2, 7),
                static_cast<GstClockTime>(i) * GST_SECOND / 10);
  EXPECT_SAYS(text, R"("forward":1,"backward":0)");
  EXPECT_EQ(stat(h, "tensor_zones", "events"), 1u);
}

TEST_F(TensorZones, RefusesResultsThatHaveZonesAlready) {
  write(kYard);
  const auto text =
      start_error(launch(), results("x1,y1,x2,y2,track,speed,ground-speed,zone:4,dwell:4", "15:1"));
  EXPECT_SAYS(text, "WEIR-2001: the results already have zones");
  EXPECT_SAYS(text, "needed: one tensor_zones for a stream");
  EXPECT_SAYS(text, "fix: tensor_zones zones=all.json, a file with the zones of both");
}

TEST_F(TensorZones, FramesWithoutTimesAreCountedWithAWarning) {
  write(kGate);
  const auto h = make_harness(json_launch(), kCaps);
  const auto element = find_element(h, "tensor_zones");
  Errors errors(element.get());
  line(h, object(50, 40, 7));
  EXPECT_SAYS(line(h, object(50, 60, 7)), R"("forward":1)");
  EXPECT_SAYS(errors.next_warning(), "WEIR-2008: a frame has no timestamp");
  EXPECT_EQ(errors.next_warning(), "");
}

TEST_F(TensorZones, AFlushEndsTracksAndKeepsCounts) {
  write(kYard);
  const auto h = make_harness(json_launch(), kCaps);
  line(h, object(50, 50, 7), 5 * GST_SECOND);
  gst_harness_push_event(h.get(), gst_event_new_flush_start());
  gst_harness_push_event(h.get(), gst_event_new_flush_stop(TRUE));
  gst_harness_push_event(h.get(), time_segment());
  const auto text = line(h, object(50, 50, 7), 0);
  EXPECT_SAYS(text, R"("inside":1,"entered":2,"left":1)");
  EXPECT_SAYS(text, R"("events":[{"event":"enter")");
}

TEST_F(TensorZones, FramesWithoutResultsAreCountedToo) {
  write(kYard);
  const auto h = make_harness(json_launch(), kCaps);
  EXPECT_SAYS(line(h, std::vector<float>(7), 0), R"("detections":[],"zones":[{"name":"yard")");
  EXPECT_SAYS(line(h, object(50, 50, 7), 0), R"("inside":1)");
  EXPECT_SAYS(line(h, std::vector<float>(7), 2 * GST_SECOND), R"("events":[{"event":"leave")");
}

TEST_F(TensorZones, TenThousandZonesWork) {
  std::string zones;
  for (int i = 0; i < 10000; ++i)
    zones += (i ? "," : "") + std::string(R"({"name":")") + std::to_string(i) +
             R"(","polygon":[[0,0],[100,0],[100,100],[0,100]]})";
  write("{\"version\":1,\"zones\":[" + zones + "]}");
  const auto h = make_harness(json_launch(), kCaps);
  EXPECT_SAYS(line(h, object(50, 50, 7), 0), R"("zones":[{"name":"0","inside":1)");
  EXPECT_EQ(stat(h, "tensor_zones", "zones"), 10000u);
  EXPECT_EQ(stat(h, "tensor_zones", "beyond-limit"), 9900u);
  EXPECT_EQ(stat(h, "tensor_zones", "zones-not-named"), 96u);
}

}  // namespace tensor_zones_test
}  // namespace weir
