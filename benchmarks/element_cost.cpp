// Measures an element per 1 KB buffer above GStreamer's identity; that 10,000 warm frames allocate
// nothing; and what a second transform in a row adds.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <malloc.h>

#include <memory>

#include "element_stage.hpp"
#include "rounds.hpp"

namespace {

using weir::bench::ElementStage;

constexpr int kFrames = 20000, kRounds = 15, kAllocationFrames = 10000;
constexpr char kVideo[] =
    "video/x-raw,format=GRAY8,width=32,height=32,framerate=30/1,interlace-mode=progressive";
constexpr char kBytes[] = "other/tensor,dimension=(string)1024,type=uint8,framerate=30/1";
constexpr char kFloats[] = "other/tensor,dimension=(string)4:64,type=float32,framerate=30/1";

struct Line {
  const char *name, *launch, *caps;
  double max_us;
};

// The bytes of heap in use in all arenas.
double heap() {
  return static_cast<double>(mallinfo2().uordblks + mallinfo2().hblkhd);
}

void measure(const std::string& model) {
  const std::string filter = "tensor_filter framework=fake model=" + model;
  const Line lines[] = {
      {"tensor_converter, video", "tensor_converter", kVideo, 1.5},
      {"tensor_transform, in place", "tensor_transform mode=arithmetic option=add:1", kBytes, 1.5},
      {"tensor_transform, to float32", "tensor_transform mode=typecast option=float32", kBytes,
       1.5},
      {"tensor_preprocess, to float32",
       "tensor_preprocess width=32 height=32 channel-order=GRAY mean=127.5 scale=0.0078 "
       "type=float32",
       kVideo, 3},
      {"tensor_filter, an engine that adds 1", filter.c_str(), kFloats, 2.0},
  };
  for (const Line& line : lines) {
    ElementStage floor("identity", line.caps, 1024), stage(line.launch, line.caps, 1024);
    const auto costs =
        weir::bench::medians({[&] { floor.push(kFrames); }, [&] { stage.push(kFrames); }}, kRounds);
    weir::bench::report(std::string("cost of a 1 KB buffer: ") + line.name, "identity",
                        (costs[1].cpu - costs[0].cpu) / kFrames * 1e6, "us", line.max_us);
  }
  for (const Line& line : lines) {
    ElementStage stage(line.launch, line.caps, 1024);
    stage.push(100);
    const uint64_t pool = stage.stat("pool-allocated");
    const double before = heap();
    stage.push(kAllocationFrames);
    const double grown = heap() - before;
    const std::string name = std::string("10,000 frames: ") + line.name;
    weir::bench::report(name + ", buffers allocated", "none",
                        static_cast<double>(stage.stat("pool-allocated") - pool), "buffers", 0);
    weir::bench::report(name + ", heap growth", "none", grown, "bytes", 0);
  }
}

void measure_two_in_a_row() {
  constexpr char kPixels[] = "other/tensor,dimension=(string)3:640:480,type=uint8,framerate=30/1";
  constexpr int kPictures = 100;
  const std::string transform = "tensor_transform mode=", steps = "add:-127.5,div:127.5";
  ElementStage one(transform + "arithmetic option=typecast:float32," + steps, kPixels,
                   size_t{3} * 640 * 480);
  ElementStage two(
      transform + "typecast option=float32 ! " + transform + "arithmetic option=" + steps, kPixels,
      size_t{3} * 640 * 480);
  const auto costs =
      weir::bench::medians({[&] { one.push(kPictures); }, [&] { two.push(kPictures); }}, kRounds);
  weir::bench::report("640x480: typecast ! arithmetic as two elements: time",
                      "one element with both steps", costs[1].cpu / costs[0].cpu, "x", 1.15);
}

void measure_second_of_two() {
  const std::string add = "tensor_transform mode=arithmetic option=add:1",
                    limit = "tensor_transform mode=clamp option=9:99";
  ElementStage one(add, kBytes, 1024), two(add + " ! " + limit, kBytes, 1024);
  const auto costs =
      weir::bench::medians({[&] { one.push(kFrames); }, [&] { two.push(kFrames); }}, kRounds);
  weir::bench::report("cost of a 1 KB buffer: a second tensor_transform, in place",
                      "one tensor_transform", (costs[1].cpu - costs[0].cpu) / kFrames * 1e6, "us",
                      1.5);
}

}  // namespace

int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  if (argc != 2) return 2;
  measure(argv[1]);
  measure_two_in_a_row();
  measure_second_of_two();
}
