// Converts a Full HD frame to a network's input: tensor_preprocess against the elements that it
// replaces, pyramids against their first layer, and regions.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>
#include <gst/video/video.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "element_stage.hpp"
#include "rounds.hpp"

namespace {

using weir::bench::ElementStage;

constexpr int kFrames = 5;
constexpr size_t kBytes = size_t{1920} * 1080 * 3 / 2;
constexpr char kVideo[] =
    "video/x-raw,format=NV12,width=1920,height=1080,framerate=30/1,interlace-mode=progressive,"
    "pixel-aspect-ratio=1/1,colorimetry=bt709,chroma-site=mpeg2";
constexpr char kTensor[] =
    " ! video/x-raw,format=RGB,width=640,height=640,pixel-aspect-ratio=1/1 ! tensor_converter ! "
    "tensor_transform mode=arithmetic option=typecast:float32,mul:0.00392156863 ! "
    "tensor_transform mode=transpose option=1:2:0:3 ! capsfilter caps=other/tensors,format=static";

// Untouched pages share one physical page, which would stay in the nearest cache.
void write_frames(ElementStage& stage) {
  stage.push(8, [](GstBuffer* buffer) {
    GstMapInfo map;
    if (!gst_buffer_map(buffer, &map, GST_MAP_WRITE)) std::abort();
    for (gsize i = 0; i < map.size; ++i) map.data[i] = static_cast<guint8>(i * 31 + i / 1920);
    gst_buffer_unmap(buffer, &map);
  });
}

void classic_chains(int rounds) {
  constexpr const char* kInput =
      "tensor_preprocess width=640 height=640 fit=letterbox scale=0.00392156863 layout=NCHW "
      "method=";
  const std::vector<std::string> classic{"videoconvert ! videoscale", "videoscale ! videoconvert",
                                         "videoconvertscale"};
  // The chains are bilinear and read four of nine pixels; `area` reads all. The limit of a half is
  // a guard, not a target of the field.
  const std::vector<std::pair<std::string, double>> methods{{"bilinear", 1.0 / 3}, {"area", 0.5}};
  std::deque<ElementStage> stages;
  for (const auto& chain : classic) stages.emplace_back(chain + kTensor, kVideo, kBytes);
  for (const auto& method : methods) stages.emplace_back(kInput + method.first, kVideo, kBytes);
  std::vector<std::function<void()>> pushes;
  for (ElementStage& stage : stages) {
    write_frames(stage);
    pushes.push_back([&stage] { stage.push(kFrames); });
  }
  const auto costs = weir::bench::medians(pushes, rounds);
  for (size_t m = 0; m < methods.size(); ++m)
    for (size_t i = 0; i < classic.size(); ++i) {
      const auto us = static_cast<int>(costs[i].cpu / kFrames * 1e6);
      weir::bench::report("Full HD NV12 to 640x640 float NCHW, " + methods[m].first + ": CPU time",
                          classic[i] + " ..., " + std::to_string(us) + " us",
                          costs[classic.size() + m].cpu / costs[i].cpu, "x", methods[m].second);
    }
}

struct Pyramid {
  const char* name;
  double factor;  // between layers
  int width, height;
  // What all layers may cost: with half of the pixels of the layer before, they have twice the
  // pixels of the first one.
  double max;
};

// The cost of ten layers above writing their bytes, relative to the first layer alone.
void pyramid(const Pyramid& p, int rounds) {
  constexpr const char* kNumbers = " scale=0.00392156863 layout=NCHW method=bilinear";
  const auto size = [](double width, double height) {
    return std::to_string(std::max(1, static_cast<int>(width + 0.5))) + "x" +
           std::to_string(std::max(1, static_cast<int>(height + 0.5)));
  };
  std::string sizes;
  double part = 1, pixels = 0;
  for (int layer = 0; layer < 10; ++layer, part *= p.factor) {
    sizes += (layer ? "," : "") + size(p.width * part, p.height * part);
    pixels += p.width * part * p.height * part;
  }
  ElementStage first("tensor_preprocess sizes=" + size(p.width, p.height) + kNumbers, kVideo,
                     kBytes);
  ElementStage all("tensor_preprocess sizes=" + sizes + kNumbers, kVideo, kBytes);
  write_frames(first);
  write_frames(all);
  std::vector<std::byte> memory(static_cast<size_t>(pixels) * 3 * sizeof(float));
  const auto costs = weir::bench::medians({[&] { first.push(kFrames); }, [&] { all.push(kFrames); },
                                           [&] {
                                             for (int i = 0; i < kFrames; ++i) {
                                               std::memset(memory.data(), i, memory.size());
                                               asm volatile("" ::"r"(memory.data()) : "memory");
                                             }
                                           }},
                                          rounds);
  const auto us = [&](size_t i) {
    return std::to_string(static_cast<int>(costs[i].cpu / kFrames * 1e6)) + " us";
  };
  weir::bench::report("pyramid of 10 layers, " + std::string(p.name) + ": CPU above its bytes",
                      "its first layer alone, " + us(0) + "; all " + us(1) + ", bytes " + us(2),
                      (costs[1].cpu - costs[2].cpu) / costs[0].cpu, "x", p.max);
}

// 64 boxes of many sizes across the picture.
void add_regions(GstBuffer* buffer) {
  for (guint i = 0; i < 64; ++i)
    gst_buffer_add_video_region_of_interest_meta(buffer, "box", i * 23, i * 13, 96 + 4 * i,
                                                 96 + 2 * i);
}

void regions(const char* format, size_t bytes, int rounds) {
  const std::string caps = "video/x-raw,format=" + std::string(format) +
                           ",width=1920,height=1080,framerate=30/1,interlace-mode=progressive";
  const std::string launch =
      "tensor_preprocess width=48 height=48 max-regions=64 scale=0.00392156863 layout=NCHW "
      "regions=";
  ElementStage none("identity", caps.c_str(), bytes);
  ElementStage cut(launch + "meta", caps.c_str(), bytes);
  write_frames(cut);
  const auto costs = weir::bench::medians(
      {[&] { none.push(kFrames, add_regions); }, [&] { cut.push(kFrames, add_regions); }}, rounds);
  weir::bench::report("64 regions of Full HD " + std::string(format) + " to 48x48: CPU time",
                      "identity", (costs[1].cpu - costs[0].cpu) / kFrames * 1e6, "us", 1000);
}

}  // namespace

int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 15;
  classic_chains(rounds);
  pyramid({"halves from 960x540, bilinear", 0.5, 960, 540, 1.5}, rounds);
  pyramid({"0.709 from 1152x648, bilinear", 0.709, 1152, 648, 2}, rounds);
  // as in examples/mtcnn: faces of 40 pixels and more
  pyramid({"0.709 from 576x324, bilinear", 0.709, 576, 324, 2}, rounds);
  regions("NV12", kBytes, rounds);
  regions("I420", kBytes, rounds);
  regions("RGB", size_t{1920} * 1080 * 3, rounds);
}
