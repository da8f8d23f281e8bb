// Runs the decoders image_segment, pose_estimation and tensor_region against plain loops over the
// same data, without an element: their bytes must be the same.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "core/decoders/decoders.hpp"
#include "core/draw/glyphs.hpp"
#include "core/infer/module/decoder.hpp"
#include "core/infer/module/module_library.hpp"
#include "rounds.hpp"

namespace {

using Floats = std::vector<float>;
using Bytes = std::vector<uint8_t>;
using Options = weir::infer::Decoder::Options;

constexpr int kFrames = 20;

// Output memory that is used again for each frame.
struct Memory : weir_sink {
  Bytes bytes;
  weir::Status set_caps(const std::string&) override { return weir::ok(); }
  void* reserve(uint64_t size) override {
    bytes.resize(size);
    return bytes.data();
  }
  weir::Status share_input(uint32_t) override { return weir::ok(); }
};

// Dimensions outermost-first, and the values.
struct Input {
  std::vector<int64_t> shape;
  Floats values;

  weir_tensor tensor() {
    weir_tensor out{};
    out.data = values.data();
    out.bytes = out.capacity = values.size() * sizeof(float);
    out.info.type = WEIR_FLOAT32;
    out.info.rank = static_cast<uint32_t>(shape.size());
    std::copy(shape.begin(), shape.end(), out.info.shape);
    return out;
  }
};

[[noreturn]] void fail(const std::string& what) {
  std::fprintf(stderr, "%s\n", what.c_str());
  std::exit(1);
}

struct Stage {
  Stage(const std::string& mode, const Options& options, std::vector<Input> inputs)
      : inputs(std::move(inputs)) {
    library.add_builtin(&weir::decoders::builtin_decoders());
    auto opened = weir::infer::Decoder::open(**library.decoder(mode), options);
    if (!opened) fail(opened.error().message());
    decoder = *std::move(opened);
    for (auto& input : this->inputs) tensors.push_back(input.tensor());
  }
  void run() {
    weir_frame frame{};
    frame.struct_size = sizeof frame;
    frame.n_tensors = static_cast<uint32_t>(tensors.size());
    frame.tensors = tensors.data();
    const auto kept = decoder->decode(frame, &memory);
    if (!kept) fail(kept.error().message());
  }
  std::vector<Input> inputs;
  std::vector<weir_tensor> tensors;
  weir::infer::ModuleLibrary library;
  std::unique_ptr<weir::infer::Decoder> decoder;
  Memory memory;
};

template <class Plain>
void compare(const std::string& name, Stage& stage, Plain plain, int rounds) {
  Bytes expected;
  stage.run();
  plain(expected);
  if (stage.memory.bytes != expected) fail(name + ": the bytes differ");
  const auto costs = weir::bench::min({[&] {
                                         for (int i = 0; i < kFrames; ++i) stage.run();
                                       },
                                       [&] {
                                         for (int i = 0; i < kFrames; ++i) plain(expected);
                                       }},
                                      rounds);
  weir::bench::report(name + ": CPU time", "a plain loop over the same data",
                      costs[0].cpu / costs[1].cpu, "x", 1.2);
}

float number(size_t i) {
  return static_cast<float>(i * 7919 % 10007) / 10007;
}
void put(Bytes& bytes, size_t pixel, uint32_t color) {
  std::memcpy(&bytes[4 * pixel], &color, 4);
}

constexpr size_t kSide = 257, kClasses = 21, kPixels = kSide * kSide;
uint32_t class_color(size_t index) {
  return index == 0 ? 0 : static_cast<uint32_t>(0xFFFFFF / kClasses * index) | 0xFF000000;
}

void scores(int rounds) {
  Floats values(kPixels * kClasses);
  for (size_t i = 0; i < values.size(); ++i) values[i] = number(i);
  Stage stage("image_segment", {{"option1", "tflite-deeplab"}},
              {{{kSide, kSide, kClasses}, values}});
  const auto plain = [&](Bytes& out) {
    out.resize(4 * kPixels);
    for (size_t p = 0; p < kPixels; ++p) {
      size_t best = 0;
      float top = values[p * kClasses];
      for (size_t c = 1; c < kClasses; ++c)
        if (values[p * kClasses + c] > top) top = values[p * kClasses + c], best = c;
      put(out, p, class_color(top > 0.5f ? best : 0));
    }
  };
  compare("image_segment tflite-deeplab 21:257:257", stage, plain, rounds);
}

void numbers(int rounds) {
  Floats values(kPixels);
  for (size_t i = 0; i < kPixels; ++i) values[i] = static_cast<float>(i / 500 % kClasses);
  Stage stage("image_segment", {{"option1", "snpe-deeplab"}}, {{{kSide, kSide}, values}});
  std::vector<uint32_t> colors;
  for (size_t i = 0; i < kClasses; ++i) colors.push_back(class_color(i));
  const auto plain = [&](Bytes& out) {
    out.resize(4 * kPixels);
    for (size_t p = 0; p < kPixels; ++p) {
      const auto index = static_cast<size_t>(values[p]);
      if (index >= kClasses) fail("no class");
      put(out, p, colors[index]);
    }
  };
  compare("image_segment snpe-deeplab 257:257", stage, plain, rounds);
}

void depths(int rounds) {
  Floats values(kPixels);
  for (size_t i = 0; i < kPixels; ++i) values[i] = 80 * number(i);
  Stage stage("image_segment", {{"option1", "snpe-depth"}}, {{{kSide, kSide, 1}, values}});
  const auto plain = [&](Bytes& out) {
    out.resize(4 * kPixels);
    float max = 0;
    for (const float value : values) max = std::max(max, value);
    for (size_t p = 0; p < kPixels; ++p)
      put(out, p, static_cast<uint32_t>(values[p] / max * 255) * 0x010101 | 0xFF000000);
  };
  compare("image_segment snpe-depth 1:257:257", stage, plain, rounds);
}

// A drawing like that of a program without a library.
struct Drawing {
  int width, height;
  Bytes& bytes;
  void set(int x, int y, uint32_t color = 0xFFFFFFFF) {
    if (x >= 0 && y >= 0 && x < width && y < height)
      put(bytes, static_cast<size_t>(y * width + x), color);
  }
  void dot(int x, int y) {
    for (int dy = -4; dy <= 4; ++dy)
      for (int dx = -4; dx <= 4; ++dx)
        if (std::abs(dx) + std::abs(dy) <= 4 && (dx != 0 || dy != 0)) set(x + dx, y + dy);
  }
  void line(int x1, int y1, int x2, int y2) {
    const bool steep = std::abs(y2 - y1) > std::abs(x2 - x1);
    const int steps = std::max(std::abs(x2 - x1), std::abs(y2 - y1));
    const int rise = steep ? std::abs(x2 - x1) : std::abs(y2 - y1);
    for (int i = 0; i <= steps; ++i) {
      const int away = steps == 0 ? 0 : (2 * i * rise + steps) / (2 * steps);
      const int x = x1 + (x2 < x1 ? -1 : 1) * (steep ? away : i);
      const int y = y1 + (y2 < y1 ? -1 : 1) * (steep ? i : away);
      set(x, y);
      set(x + 1, y);
      set(x, y + 1);
    }
  }
  void text(int x, int y, const char* text) {
    for (; *text && x + 8 <= width; ++text, x += 9)
      for (int row = 0; row < 13; ++row)
        for (int column = 0; column < 8; ++column)
          set(x + column, y + row,
              weir::draw::get_glyph(*text)[static_cast<size_t>(row)] & 0x80 >> column ? 0xFFFFFFFF
                                                                                      : 0);
  }
};

constexpr int kPoints = 14, kGridWidth = 31, kGridHeight = 23, kWidth = 640, kHeight = 480;
constexpr int kInputWidth = 481, kInputHeight = 353;
constexpr int kBones[][2] = {{0, 1}, {1, 2}, {1, 5}, {1, 8},  {1, 11},  {2, 3},  {3, 4},
                             {5, 6}, {6, 7}, {8, 9}, {9, 10}, {11, 12}, {12, 13}};
constexpr const char* kNames[] = {"top",        "neck",    "r_shoulder", "r_elbow", "r_wrist",
                                  "l_shoulder", "l_elbow", "l_wrist",    "r_hip",   "r_knee",
                                  "r_ankle",    "l_hip",   "l_knee",     "l_ankle"};

// With offsets if `offsets` is not empty.
void pose(const Floats& maps, const Floats& offsets, Bytes& out) {
  int xs[kPoints], ys[kPoints];
  bool valid[kPoints];
  for (int k = 0; k < kPoints; ++k) {
    float top = -1;
    int column = 0, row = 0;
    for (int y = 0; y < kGridHeight; ++y)
      for (int x = 0; x < kGridWidth; ++x) {
        float value = maps[static_cast<size_t>((y * kGridWidth + x) * kPoints + k)];
        if (!offsets.empty()) value = 1 / (1 + std::exp(-value));
        if (value > top) top = value, column = x, row = y;
      }
    valid[k] = top >= 0.5f;
    if (offsets.empty()) {
      xs[k] = column * kWidth / kGridWidth;
      ys[k] = row * kHeight / kGridHeight;
      continue;
    }
    const float* offset = &offsets[static_cast<size_t>((row * kGridWidth + column) * 2 * kPoints)];
    const float x =
        static_cast<float>(column) / (kGridWidth - 1) * kInputWidth + offset[kPoints + k];
    const float y = static_cast<float>(row) / (kGridHeight - 1) * kInputHeight + offset[k];
    xs[k] = std::clamp(static_cast<int>(x * kWidth / kInputWidth), 0, kWidth);
    ys[k] = std::clamp(static_cast<int>(y * kHeight / kInputHeight), 0, kHeight);
  }
  out.assign(size_t{4} * kWidth * kHeight, 0);
  Drawing drawing{kWidth, kHeight, out};
  for (const auto& bone : kBones) {
    int from = bone[0], to = bone[1];
    if (!valid[from] || !valid[to]) continue;
    drawing.dot(xs[from], ys[from]);
    drawing.dot(xs[to], ys[to]);
    if (xs[from] > xs[to]) std::swap(from, to);
    drawing.line(xs[from], ys[from], xs[to], ys[to]);
  }
  for (int k = 0; k < kPoints; ++k)
    if (valid[k]) drawing.text(xs[k], std::max(0, ys[k] - 14), kNames[k]);
}

void poses(int rounds) {
  Floats maps(kPoints * kGridWidth * kGridHeight), offsets(2 * maps.size());
  for (size_t i = 0; i < maps.size(); ++i) maps[i] = number(i);
  for (size_t i = 0; i < offsets.size(); ++i) offsets[i] = 30 * number(i + 3) - 15;
  const Input heat{{kGridHeight, kGridWidth, kPoints}, maps};
  Stage only("pose_estimation", {{"option1", "640:480"}, {"option2", "31:23"}}, {heat});
  compare(
      "pose_estimation heatmap-only 14:31:23", only, [&](Bytes& out) { pose(maps, {}, out); },
      rounds);
  Stage with("pose_estimation",
             {{"option1", "640:480"}, {"option2", "481:353"}, {"option4", "heatmap-offset"}},
             {heat, {{kGridHeight, kGridWidth, 2 * kPoints}, offsets}});
  compare(
      "pose_estimation heatmap-offset 14:31:23", with,
      [&](Bytes& out) { pose(maps, offsets, out); }, rounds);
}

constexpr size_t kAnchors = 1917, kLabels = 91;

std::string file(const std::string& folder, const char* name, const std::string& text) {
  const std::string path = folder + "/" + name;
  std::ofstream(path) << text;
  return path;
}

// One detection; the suppression of many is that of bounding_boxes.
void regions(const std::string& folder, int rounds) {
  Floats boxes(4 * kAnchors), scores(kLabels * kAnchors);
  for (size_t i = 0; i < boxes.size(); ++i) boxes[i] = number(i) - 0.5f;
  for (size_t i = 0; i < scores.size(); ++i) scores[i] = -5 * number(i) - 1;
  scores[1000 * kLabels + 17] = 2;
  std::string priors, labels;
  for (const char* value : {"0.5", "0.5", "0.25", "0.25"}) {
    for (size_t i = 0; i < kAnchors; ++i) priors += std::string(value) + " ";
    priors += "\n";
  }
  for (size_t i = 0; i < kLabels; ++i) labels += "label\n";
  Stage stage("tensor_region",
              {{"option2", file(folder, "labels.txt", labels)},
               {"option3", file(folder, "priors.txt", priors)}},
              {{{kAnchors, 1, 4}, boxes}, {{kAnchors, kLabels}, scores}});
  stage.run();
  const Bytes header(stage.memory.bytes.begin(), stage.memory.bytes.begin() + 128);
  const auto plain = [&](Bytes& out) {
    out = header;
    out.resize(128 + 16);
    for (size_t a = 0; a < kAnchors; ++a)
      for (size_t c = 1; c < kLabels; ++c) {
        if (!(scores[a * kLabels + c] >= 0)) continue;
        const float* box = &boxes[4 * a];
        const float y = box[0] / 10 * 0.25f + 0.5f, x = box[1] / 10 * 0.25f + 0.5f;
        const float h = std::exp(box[2] / 5) * 0.25f, w = std::exp(box[3] / 5) * 0.25f;
        const int region[] = {std::max(0, static_cast<int>((x - w / 2) * 300)),
                              std::max(0, static_cast<int>((y - h / 2) * 300)),
                              static_cast<int>(w * 300), static_cast<int>(h * 300)};
        std::memcpy(&out[128], region, sizeof region);
        break;
      }
  };
  compare("tensor_region 91:1917", stage, plain, rounds);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: picture_decoder_cost FOLDER ROUNDS\n");
    return 2;
  }
  const int rounds = std::atoi(argv[2]);
  scores(rounds);
  numbers(rounds);
  depths(rounds);
  poses(rounds);
  regions(argv[1], rounds);
}
