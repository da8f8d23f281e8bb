// tensor_tracker on 100 objects: the CPU time of a frame above identity, and the memory of a day.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include <malloc.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "core/track/tracker.hpp"
#include "element_stage.hpp"
#include "rounds.hpp"

namespace {

using weir::bench::ElementStage;

constexpr int kFrames = 200, kObjects = 100, kColumns = 6;
// Half of 2 % of the 40 ms of a frame at 25 frames/s: the other half is that of tensor_zones.
constexpr double kTarget = 400;  // microseconds

// Objects in a crowd, ten beside each other and overlapping, that move downwards and begin again at
// the top; the camera shakes. A tenth is missed in each frame.
void fill(GstBuffer* buffer, int frame, std::mt19937* random) {
  GstMapInfo map;
  gst_buffer_map(buffer, &map, GST_MAP_WRITE);
  auto* row = reinterpret_cast<float*>(map.data);
  std::normal_distribution<float> noise(0, 1);
  const float shake = 6 * noise(*random);
  for (int i = 0; i < kObjects; ++i, row += kColumns) {
    const float x = 180.0f * static_cast<float>(i % 10) + 9 * static_cast<float>(i / 10) + shake;
    const auto y = static_cast<float>((4 * frame + 97 * i) % 1000);
    const bool is_missed = (*random)() % 10 == 0;
    const float values[kColumns] = {
        x + noise(*random), y + noise(*random), x + 40, y + 80, is_missed ? 0.0f : 0.9f, 0};
    std::copy(values, values + kColumns, row);
  }
  gst_buffer_unmap(buffer, &map);
}

// Bytes that a tracker holds more after a day at 25 frames/s than after its first hour. People come
// and go.
double growth_of_a_day() {
  constexpr int kHour = 25 * 3600, kDay = 24 * kHour;
  weir::track::Tracker tracker;
  std::vector<weir::track::Observation> boxes;
  std::mt19937 random(1);
  size_t after_an_hour = 0;
  for (int frame = 0; frame < kDay; ++frame) {
    if (frame == kHour) after_an_hour = mallinfo2().uordblks;
    boxes.clear();
    for (int i = 0; i < 5; ++i) {
      const int age = frame + 70 * i;
      if (random() % 10 == 0) continue;
      const auto x = static_cast<float>(300 * i + age / 350 % 7 * 20);
      const auto y = static_cast<float>(age % 350 * 3);
      boxes.push_back({{x, y, x + 40, y + 80}, 0.9f, i});
    }
    tracker.follow(boxes, frame / 25.0, {});
  }
  return static_cast<double>(mallinfo2().uordblks) - static_cast<double>(after_an_hour);
}

}  // namespace

int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 15;
  const std::string caps =
      "other/tensors,format=static,num_tensors=1,types=(string)float32,dimensions=(string)6:" +
      std::to_string(kObjects) +
      ",framerate=25/1,weir-columns=(string)\"x1,y1,x2,y2,score,class\","
      "weir-source=(string)street";
  const size_t bytes = sizeof(float) * kColumns * kObjects;
  ElementStage none("identity", caps.c_str(), bytes);
  ElementStage tracker("tensor_tracker", caps.c_str(), bytes);
  int frame = 0;
  std::mt19937 random(1);
  const auto prepare = [&](GstBuffer* buffer) { fill(buffer, ++frame, &random); };
  const auto costs = weir::bench::min(
      {[&] { none.push(kFrames, prepare); }, [&] { tracker.push(kFrames, prepare); }}, rounds);
  weir::bench::report("tensor_tracker, 100 objects: CPU time of a frame",
                      "identity; 1 % of a frame at 25 frames/s",
                      (costs[1].cpu - costs[0].cpu) / kFrames * 1e6, "us", kTarget);
  weir::bench::report("tensor_tracker, a day of 2.16 million frames: memory held",
                      "after the first hour", growth_of_a_day(), "bytes", 65536);
}
