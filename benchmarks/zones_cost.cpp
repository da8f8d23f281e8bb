// tensor_zones on 100 tracked objects: the CPU time of a frame above identity.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "element_stage.hpp"
#include "rounds.hpp"

namespace {

using weir::bench::ElementStage;

constexpr int kFrames = 200, kObjects = 100, kColumns = 7;
// Half of 2 % of the 40 ms of a frame at 25 frames/s: the other half is the tracker's.
constexpr double kTarget = 400;  // microseconds

// Five areas and five lines across a Full HD picture.
void write_zones(const std::string& path) {
  std::ofstream file(path);
  file << R"({"version":1,"zones":[)";
  for (int i = 0; i < 5; ++i) {
    const int x = 350 * i;
    file << R"({"name":"area )" << i << R"(","dwell":1,"polygon":[[)" << x << ",200],[" << x + 340
         << ",220],[" << x + 300 << ",900],[" << x << R"(,880]]},{"name":"line )" << i
         << R"(","line":[[)" << 100 * i << ",300],[" << 1900 - 100 * i << ",600]]},";
  }
  file << R"({"name":"all","polygon":[[0,0],[1920,0],[1920,1080],[0,1080]]}],)"
       << R"("ground":{"metres_per_pixel":0.02}})";
}

// Objects that move downwards and begin again at the top.
void fill(GstBuffer* buffer, int frame) {
  GstMapInfo map;
  gst_buffer_map(buffer, &map, GST_MAP_WRITE);
  auto* row = reinterpret_cast<float*>(map.data);
  for (int i = 0; i < kObjects; ++i, row += kColumns) {
    const auto x = static_cast<float>(19 * i), y = static_cast<float>((8 * frame + 11 * i) % 1000);
    const float values[kColumns] = {
        x, y, x + 40, y + 80, 0.9f, static_cast<float>(i % 8), static_cast<float>(i + 1)};
    std::copy(values, values + kColumns, row);
  }
  gst_buffer_unmap(buffer, &map);
}

}  // namespace

int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 15;
  const std::string path = "/tmp/weir-zones-cost-" + std::to_string(getpid()) + ".json";
  write_zones(path);
  const std::string caps =
      "other/tensors,format=static,num_tensors=1,types=(string)float32,dimensions=(string)7:" +
      std::to_string(kObjects) +
      ",framerate=25/1,weir-columns=(string)\"x1,y1,x2,y2,score,class,track\","
      "weir-source=(string)street";
  const size_t bytes = sizeof(float) * kColumns * kObjects;
  ElementStage none("identity", caps.c_str(), bytes);
  ElementStage zones("tensor_zones zones=" + path, caps.c_str(), bytes);
  int frame = 0;
  const auto prepare = [&frame](GstBuffer* buffer) { fill(buffer, ++frame); };
  const auto costs = weir::bench::min(
      {[&] { none.push(kFrames, prepare); }, [&] { zones.push(kFrames, prepare); }}, rounds);
  weir::bench::report("tensor_zones, 100 objects, 11 zones: CPU time of a frame",
                      "identity; 1 % of a frame at 25 frames/s",
                      (costs[1].cpu - costs[0].cpu) / kFrames * 1e6, "us", kTarget);
  std::remove(path.c_str());
}
