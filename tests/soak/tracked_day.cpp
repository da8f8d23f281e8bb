// tracked_day [FRAMES]: pushes a day of objects that come and go through tensor_tracker and
// tensor_zones as fast as they take them, and reports the growth of memory after the first hour.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/app/gstappsrc.h>
#include <gst/gst.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <random>
#include <string_view>

#include "gstcpp/element/ref.hpp"

namespace {

using weir::gst::Ref;

constexpr int kRate = 25, kHour = kRate * 3600, kDay = 24 * kHour;
constexpr int kObjects = 5, kColumns = 6;
// A heap whose blocks are freed and reused in another order differs by less.
constexpr double kMaxKilobytes = 64;

struct Memory {
  double live = 0, resident = 0;  // kilobytes
};

Memory memory() {
  const auto info = mallinfo2();
  std::ifstream file("/proc/self/statm");
  double total = 0, resident = 0;
  file >> total >> resident;
  return {static_cast<double>(info.uordblks + info.hblkhd) / 1024,
          resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1024};
}

// Objects that walk down through a line and an area and begin again as others, 14 seconds each; a
// tenth of them is missed in each frame.
Ref<GstBuffer> make_frame(int number, std::mt19937* random) {
  std::array<float, size_t{kObjects} * kColumns> rows{};
  for (int i = 0; i < kObjects; ++i) {
    const int age = number + 70 * i;
    const auto x = static_cast<float>(300 * i + age / 350 % 7 * 20);
    const auto y = static_cast<float>(age % 350 * 3);
    const float score = (*random)() % 10 == 0 ? 0.0f : 0.9f;
    const std::array<float, kColumns> row{x, y, x + 40, y + 80, score, 0};
    std::copy(row.begin(), row.end(), rows.begin() + std::ptrdiff_t{i} * kColumns);
  }
  auto buffer = Ref<GstBuffer>::adopt(gst_buffer_new_allocate(nullptr, sizeof rows, nullptr));
  gst_buffer_fill(buffer.get(), 0, rows.data(), sizeof rows);
  GST_BUFFER_PTS(buffer.get()) = gst_util_uint64_scale(number, GST_SECOND, kRate);
  GST_BUFFER_DURATION(buffer.get()) = GST_SECOND / kRate;
  return buffer;
}

struct Events {
  uint64_t zones = 0;
  bool has_failed = false;
};

// Empties the bus; its messages would count as memory.
void read_bus(GstBus* bus, Events* events) {
  while (const auto message = Ref<GstMessage>::adopt(gst_bus_pop(bus))) {
    events->zones += gst_message_has_name(message.get(), "weir-zone-event") ? 1 : 0;
    if (GST_MESSAGE_TYPE(message.get()) != GST_MESSAGE_ERROR) continue;
    events->has_failed = true;
    GError* error = nullptr;
    gst_message_parse_error(message.get(), &error, nullptr);
    std::fprintf(stderr, "%s\n", error->message);
    g_error_free(error);
  }
}

constexpr const char* kLine =
    "appsrc name=rows format=time block=true max-bytes=1920 "
    "caps=\"other/tensors,format=static,num_tensors=1,types=(string)float32,dimensions=(string)6:5,"
    "framerate=25/1,weir-columns=(string)\\\"x1,y1,x2,y2,score,class\\\","
    "weir-source=(string)street\" ! tensor_tracker ! tensor_zones name=zones ! "
    "fakesink sync=false";
constexpr const char* kZones =
    R"({"version": 1, "zones": [{"name": "gate", "line": [[0, 500], [2000, 500]]},)"
    R"( {"name": "yard", "dwell": 1, "polygon": [[0, 300], [2000, 300], [2000, 800], [0, 800]]}]})";

void report(int frames, double seconds, const Events& events, const Memory& now) {
  std::printf("%10d %8.0f %12lu %12.0f %12.0f\n", frames, seconds, events.zones, now.live,
              now.resident);
  std::fflush(stdout);
}

// False if an element fails.
bool push_all(GstElement* pipeline, int frames, Memory* first, Memory* last, Events* events) {
  const auto source = Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline), "rows"));
  const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(pipeline));
  const auto start = std::chrono::steady_clock::now();
  const auto now = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  std::mt19937 random(1);
  const int hour = std::max(frames / 24, 1);
  std::printf("%10s %8s %12s %12s %12s\n", "frames", "seconds", "events", "live KB", "RSS KB");
  for (int i = 0; i < frames && !events->has_failed; ++i) {
    if (gst_app_src_push_buffer(GST_APP_SRC(source.get()), make_frame(i, &random).release()) !=
        GST_FLOW_OK)
      break;
    if (i % kRate == 0) read_bus(bus.get(), events);
    if ((i + 1) % hour != 0) continue;
    *last = memory();
    if (i + 1 == hour) *first = *last;
    report(i + 1, now(), *events, *last);
  }
  gst_app_src_end_of_stream(GST_APP_SRC(source.get()));
  while (!events->has_failed) {
    const auto end = Ref<GstMessage>::adopt(gst_bus_timed_pop(bus.get(), 60 * GST_SECOND));
    if (!end) return false;
    if (GST_MESSAGE_TYPE(end.get()) == GST_MESSAGE_EOS) return true;
    if (GST_MESSAGE_TYPE(end.get()) == GST_MESSAGE_ERROR) events->has_failed = true;
  }
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  int frames = kDay;
  const std::string_view given = argc > 1 ? argv[1] : "";
  const auto read = std::from_chars(given.data(), given.data() + given.size(), frames);
  const bool is_number = read.ec == std::errc() && read.ptr == given.data() + given.size();
  if (argc > 2 || (argc == 2 && (!is_number || frames < 24)))
    return std::fprintf(stderr, "usage: tracked_day [FRAMES, at least 24]\n"), 2;
  char folder[] = "/tmp/weir-tracked-day-XXXXXX";
  if (!mkdtemp(folder)) return std::perror("tracked_day"), 2;
  const std::string zones = std::string(folder) + "/zones.json";
  std::ofstream(zones) << kZones;
  GError* error = nullptr;
  const auto pipeline = Ref<GstElement>::adopt(gst_parse_launch(kLine, &error));
  if (!pipeline || error) return std::fprintf(stderr, "%s\n", error->message), 2;
  const auto element =
      Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline.get()), "zones"));
  g_object_set(element.get(), "zones", zones.c_str(), nullptr);
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  Memory first, last;
  Events events;
  const bool has_ended = push_all(pipeline.get(), frames, &first, &last, &events);
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  std::remove(zones.c_str());
  rmdir(folder);
  const double growth = last.live - first.live;
  std::printf(
      "a day of %d tracked frames: %+.1f KB are not freed after the first hour (at most "
      "%.0f)\n",
      frames, growth, kMaxKilobytes);
  if (!has_ended || events.zones == 0)
    return std::fprintf(stderr, "the pipeline failed, or no event came\n"), 1;
  return growth > kMaxKilobytes ? 1 : 0;
}
