// Draws twenty boxes with labels and key points on a Full HD frame: tensor_overlay against a plain
// loop over the same pixels; ten masks against a pass over theirs; and the copy of a frame with
// another reference.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>
#include <gst/video/video.h>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "element_stage.hpp"
#include "rounds.hpp"

namespace {

using weir::bench::ElementStage;
using weir::gst::Ref;

constexpr int kFrames = 20, kBoxes = 20, kNumbers = 16, kPoints = 5;
constexpr int kWidth = 1920, kHeight = 1080;

struct Box {
  int x, y, width, height;
};
// Boxes from 60x80 to 212x308 pixels, spread over the picture.
Box box(int i) {
  return {37 + 83 * i, 40 + (i * 397) % 700, 60 + 8 * i, 80 + 12 * i};
}
std::string video(const char* format) {
  return "video/x-raw,format=" + std::string(format) +
         ",width=1920,height=1080,framerate=30/1,interlace-mode=progressive";
}
size_t count_bytes(const char* format) {
  GstVideoInfo info;
  gst_video_info_set_format(&info, gst_video_format_from_string(format), kWidth, kHeight);
  return info.size;
}

std::vector<float> rows() {
  std::vector<float> out;
  for (int i = 0; i < kBoxes; ++i) {
    const Box b = box(i);
    for (const int n : {b.x, b.y, b.x + b.width, b.y + b.height})
      out.push_back(static_cast<float>(n));
    out.insert(out.end(), {static_cast<float>(i) / 20 + 0.04f, static_cast<float>(i % 7)});
    for (int p = 0; p < kPoints; ++p) {
      out.push_back(static_cast<float>(b.x + (p + 1) * b.width / 6));
      out.push_back(static_cast<float>(b.y + (p + 1) * b.height / 6));
    }
  }
  return out;
}

void bring_results(const ElementStage& stage, const char* caps_text, GstBuffer* buffer) {
  const auto pad = stage.pad("results");
  const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(caps_text));
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  gst_pad_send_event(pad.get(), gst_event_new_stream_start("results"));
  gst_pad_send_event(pad.get(), gst_event_new_caps(caps.get()));
  gst_pad_send_event(pad.get(), gst_event_new_segment(&segment));
  if (gst_pad_chain(pad.get(), buffer) != GST_FLOW_OK) std::exit(1);
}
template <class T>
GstMemory* make_memory(const std::vector<T>& values) {
  const size_t bytes = values.size() * sizeof(T);
  return gst_memory_new_wrapped(GstMemoryFlags{}, g_memdup2(values.data(), bytes), bytes, 0, bytes,
                                nullptr, g_free);
}
void bring_boxes(const ElementStage& stage) {
  GstBuffer* buffer = gst_buffer_new();
  gst_buffer_append_memory(buffer, make_memory(rows()));
  bring_results(stage,
                "other/tensors,format=static,num_tensors=1,dimensions=(string)16:20,"
                "types=(string)float32,framerate=30/1",
                buffer);
}

// Sets single pixels like a program without a library.
struct PlainPicture {
  std::vector<uint8_t> memory;
  int step;  // bytes per pixel; 1: NV12 or I420

  template <class Put>
  void each_sample(int x, int y, Put&& put) {
    uint8_t* pixel = &memory[static_cast<size_t>(y * kWidth + x) * static_cast<size_t>(step)];
    put(pixel[0], 40);
    if (step > 1) {
      put(pixel[1], 250);
      put(pixel[2], 60);
      return;
    }
    uint8_t* chroma = &memory[static_cast<size_t>(kWidth * kHeight + y / 2 * kWidth + x / 2 * 2)];
    put(chroma[0], 90);
    put(chroma[1], 200);
  }
  void set(int x, int y) {
    each_sample(x, y, [](uint8_t& to, int color) { to = static_cast<uint8_t>(color); });
  }
  void mix(int x, int y, int alpha) {
    each_sample(x, y, [alpha](uint8_t& to, int color) {
      to = static_cast<uint8_t>((to * (255 - alpha) + color * alpha) / 255);
    });
  }
  void area(int left, int top, int width, int height) {
    for (int y = top; y < top + height; ++y)
      for (int x = left; x < left + width; ++x) set(x, y);
  }
};

// The lines, discs and labels (about the width of "person 87 %") of the same boxes.
void draw_plainly(PlainPicture* picture, const std::vector<uint8_t>& glyphs) {
  constexpr int kLabelWidth = 140, kLabelHeight = 24;
  for (int i = 0; i < kBoxes; ++i) {
    const Box b = box(i);
    picture->area(b.x, b.y, b.width, 2);
    picture->area(b.x, b.y + b.height - 2, b.width, 2);
    picture->area(b.x, b.y + 2, 2, b.height - 4);
    picture->area(b.x + b.width - 2, b.y + 2, 2, b.height - 4);
    for (int p = 1; p <= kPoints; ++p)
      picture->area(b.x + p * b.width / 6 - 2, b.y + p * b.height / 6 - 2, 5, 5);
    picture->area(b.x, b.y - kLabelHeight, kLabelWidth, kLabelHeight);
    for (int y = 0; y < kLabelHeight; ++y)
      for (int x = 0; x < kLabelWidth; ++x)
        picture->mix(b.x + x, b.y - kLabelHeight + y,
                     glyphs[static_cast<size_t>(y * kLabelWidth + x)]);
  }
}

void boxes(const char* format, int step, const std::string& overlay, int rounds) {
  const std::string caps = video(format);
  const size_t bytes = count_bytes(format);
  ElementStage none("identity", caps.c_str(), bytes);
  ElementStage drawn(overlay, caps.c_str(), bytes);
  bring_boxes(drawn);
  PlainPicture plain{std::vector<uint8_t>(size_t{kWidth} * kHeight * 4), step};
  std::vector<uint8_t> glyphs(140 * 24);
  for (size_t i = 0; i < glyphs.size(); ++i) glyphs[i] = static_cast<uint8_t>(i % 5 ? 0 : i * 37);
  const auto costs = weir::bench::min({[&] { none.push(kFrames); }, [&] { drawn.push(kFrames); },
                                       [&] {
                                         for (int i = 0; i < kFrames; ++i)
                                           draw_plainly(&plain, glyphs);
                                       }},
                                      rounds);
  const double us = (costs[1].cpu - costs[0].cpu) / kFrames * 1e6;
  const std::string name = "20 boxes, labels, key points on Full HD " + std::string(format);
  weir::bench::report(name + ": CPU time", "identity", us, "us", 1000);
  weir::bench::report(name + ": CPU time", "a plain loop over the pixels",
                      us / (costs[2].cpu / kFrames * 1e6), "x", 1);
  if (drawn.stat("pictures-copied") > 0) std::exit(1);
}

// Ten ellipses in boxes of 384 x 344 pixels, five in a row: together half of the picture.
constexpr int kMasks = 10, kMaskWidth = 384, kMaskHeight = 344, kCells = 86;
constexpr int kMaskTops[] = {100, 600};

// The ellipse's columns in a row of its box, in pixels of the picture.
struct Run {
  int y, left, right;
};
std::vector<Run> runs_of_masks() {
  std::vector<Run> out;
  for (int i = 0; i < kMasks; ++i)
    for (int y = 0; y < kMaskHeight; ++y) {
      const double down = (y + 0.5) / kMaskHeight * 2 - 1;
      const int half = static_cast<int>(kMaskWidth / 2 * std::sqrt(1 - down * down) + 0.5);
      const int centre = kMaskWidth * (i % 5) + kMaskWidth / 2;
      out.push_back({kMaskTops[i / 5] + y, centre - half, centre + half});
    }
  return out;
}
// Probabilities that fall from the middle; 127.5 at the ellipse.
void bring_masks(const ElementStage& stage) {
  std::vector<float> rows;
  std::vector<uint8_t> masks;
  for (int i = 0; i < kMasks; ++i) {
    const int x = kMaskWidth * (i % 5), y = kMaskTops[i / 5];
    for (const int n : {x, y, x + kMaskWidth, y + kMaskHeight, 1, i})
      rows.push_back(static_cast<float>(n));
    for (int row = 0; row < kCells; ++row)
      for (int column = 0; column < kCells; ++column) {
        const double away =
            std::hypot((column + 0.5) / kCells * 2 - 1, (row + 0.5) / kCells * 2 - 1);
        masks.push_back(static_cast<uint8_t>(std::clamp(127.5 + 400 * (1 - away), 0., 255.)));
      }
  }
  GstBuffer* buffer = gst_buffer_new();
  gst_buffer_append_memory(buffer, make_memory(rows));
  gst_buffer_append_memory(buffer, make_memory(masks));
  bring_results(stage,
                "other/tensors,format=static,num_tensors=2,dimensions=(string)\"6:10,86:86:10\","
                "types=(string)\"float32,uint8\",framerate=30/1,"
                "weir-columns=(string)\"x1,y1,x2,y2,score,class;masks\"",
                buffer);
}

// Reads and writes each byte once, with the vectors of every x86-64 or aarch64.
void pass_over(uint8_t* bytes, size_t count) {
  typedef uint8_t Vector __attribute__((vector_size(16), aligned(1), may_alias));
  size_t i = 0;
  for (; i + sizeof(Vector) <= count; i += sizeof(Vector))
    *reinterpret_cast<Vector*>(bytes + i) += 1;
  for (; i < count; ++i) ++bytes[i];
}
// The pixels of the runs, in a picture of `step` bytes per pixel; 1: NV12.
void pass_over_masks(const std::vector<Run>& runs, int step, uint8_t* picture) {
  const auto pass = [picture](int at, int bytes) {
    pass_over(picture + at, static_cast<size_t>(bytes));
  };
  for (const Run& run : runs) {
    pass((run.y * kWidth + run.left) * step, (run.right - run.left) * step);
    if (step == 1 && run.y % 2 == 0)
      pass(kWidth * kHeight + run.y / 2 * kWidth + run.left, run.right - run.left);
  }
}

void masks(const char* format, int step, int rounds) {
  const std::string caps = video(format);
  const size_t bytes = count_bytes(format);
  ElementStage none("identity", caps.c_str(), bytes);
  ElementStage drawn("tensor_overlay max-age=0 line-width=0 show-scores=false", caps.c_str(),
                     bytes);
  bring_masks(drawn);
  const auto runs = runs_of_masks();
  // As many pictures in turn as the pool of a stage has.
  std::vector<std::vector<uint8_t>> pictures(4, std::vector<uint8_t>(bytes, 1));
  const auto costs = weir::bench::min({[&] { none.push(kFrames); }, [&] { drawn.push(kFrames); },
                                       [&] {
                                         for (size_t i = 0; i < kFrames; ++i)
                                           pass_over_masks(runs, step, pictures[i % 4].data());
                                       }},
                                      rounds);
  const auto us = static_cast<int>(costs[2].cpu / kFrames * 1e6);
  weir::bench::report("10 masks over half of Full HD " + std::string(format) + ": CPU time",
                      "a pass over those pixels, " + std::to_string(us) + " us",
                      (costs[1].cpu - costs[0].cpu) / costs[2].cpu, "x", 2);
  if (drawn.stat("boxes-drawn") == 0 || drawn.stat("pictures-copied") > 0) std::exit(1);
}

// Rotates four buffers, like the stage's pool.
void copies(const char* format, const std::string& overlay, int rounds) {
  const std::string caps = video(format);
  const size_t bytes = count_bytes(format);
  ElementStage drawn(overlay, caps.c_str(), bytes), copied(overlay, caps.c_str(), bytes);
  bring_boxes(drawn);
  bring_boxes(copied);
  std::vector<std::vector<std::byte>> from(4, std::vector<std::byte>(bytes, std::byte{1}));
  std::vector<std::byte> to(bytes);
  Ref<GstBuffer> held;
  int written = 0;  // writes every page, because untouched pages share one physical page
  const auto hold = [&](GstBuffer* buffer) {
    if (written++ < kFrames) gst_buffer_memset(buffer, 0, 1, bytes);
    held = Ref<GstBuffer>::share(buffer);
  };
  const auto push_held = [&] {
    copied.push(kFrames, hold);
    held = {};
  };
  const auto copy = [&] {
    for (size_t i = 0; i < kFrames; ++i) {
      std::memcpy(to.data(), from[i % 4].data(), bytes);
      asm volatile("" ::"r"(to.data()) : "memory");
    }
  };
  const auto costs = weir::bench::min({[&] { drawn.push(kFrames); }, push_held, copy}, rounds);
  const auto us = static_cast<int>(costs[2].cpu / kFrames * 1e6);
  weir::bench::report("a Full HD " + std::string(format) + " frame held elsewhere: CPU above",
                      "a bare copy of it, " + std::to_string(us) + " us",
                      (costs[1].cpu - costs[0].cpu) / costs[2].cpu, "x", 1.3);
}

}  // namespace

int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 15;
  const std::string labels = "/tmp/weir-overlay-cost-" + std::to_string(getpid()) + ".txt";
  std::ofstream(labels) << "person\nperson\nperson\nperson\nperson\nperson\nperson\n";
  const std::string overlay = "tensor_overlay max-age=0 auto-size=false labels=" + labels;
  boxes("NV12", 1, overlay, rounds);
  boxes("I420", 1, overlay, rounds);
  boxes("RGBx", 4, overlay, rounds);
  boxes("RGB", 3, overlay, rounds);
  masks("NV12", 1, rounds);
  masks("RGBx", 4, rounds);
  masks("RGB", 3, rounds);
  copies("NV12", overlay, rounds);
  copies("RGBx", overlay, rounds);
  std::remove(labels.c_str());
}
