// Decodes the outputs of detectors and draws their boxes: tensor_decoder mode=bounding_boxes
// against plain loops over the same data that write the same frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "element_stage.hpp"
#include "rounds.hpp"

namespace {

using weir::bench::ElementStage;
using weir::gst::Ref;
using Floats = std::vector<float>;

constexpr int kFrames = 20, kObjects = 20;
constexpr int kWidth = 640, kHeight = 480, kInput = 320;  // the output; the model's input

struct Box {
  int x, y, width, height, class_index;
  float score;
};

// The frame of the plain loops.
struct Frame {
  std::vector<uint32_t> pixels = std::vector<uint32_t>(size_t{kWidth} * kHeight);

  void draw(const std::vector<Box>& boxes, bool has_labels) {
    std::memset(pixels.data(), 0, pixels.size() * 4);
    for (const Box& b : boxes) {
      const int x1 = kWidth * b.x / kInput, y1 = kHeight * b.y / kInput;
      const int x2 = std::min(kWidth - 1, kWidth * (b.x + b.width) / kInput);
      const int y2 = std::min(kHeight - 1, kHeight * (b.y + b.height) / kInput);
      for (int x = x1; x <= x2; ++x) set(x, y1), set(x, y2);
      for (int y = y1 + 1; y < y2; ++y) set(x1, y), set(x2, y);
      // Six cells of 8 x 13 pixels, as many set as in letters.
      for (int cell = 0; has_labels && cell < 6 && x1 + 9 * cell + 8 <= kWidth; ++cell)
        for (int y = 0; y < 13; ++y)
          for (int x = 0; x < 8; ++x)
            pixels[at(x1 + 9 * cell + x, std::max(0, y1 - 14) + y)] =
                (x + y) % 4 == 0 ? 0xFF0000FFu : 0;
    }
    asm volatile("" ::"r"(pixels.data()) : "memory");
  }

 private:
  static size_t at(int x, int y) { return static_cast<size_t>(y * kWidth + x); }
  void set(int x, int y) {
    if (x >= 0 && y >= 0 && x < kWidth && y < kHeight) pixels[at(x, y)] = 0xFF0000FFu;
  }
};

std::vector<Box> suppress_plainly(std::vector<Box> boxes, float threshold) {
  std::sort(boxes.begin(), boxes.end(),
            [](const Box& a, const Box& b) { return a.score > b.score; });
  std::vector<Box> kept;
  for (const Box& b : boxes) {
    bool is_kept = true;
    for (const Box& a : kept) {
      const int w = std::min(a.x + a.width, b.x + b.width) - std::max(a.x, b.x) + 1;
      const int h = std::min(a.y + a.height, b.y + b.height) - std::max(a.y, b.y) + 1;
      if (w <= 0 || h <= 0) continue;
      const float both = static_cast<float>(w * h);
      const auto areas = static_cast<float>(a.width * a.height + b.width * b.height);
      if (both / (areas - both) > threshold) {
        is_kept = false;
        break;
      }
    }
    if (is_kept) kept.push_back(b);
  }
  return kept;
}

// A head with `rows` rows of `length` values, of which kObjects have a high score; places and sizes
// are 0 to 1 across the picture.
struct Rows {
  size_t rows, length;
  Floats values;
};
struct Place {
  float x, y, width, height;
};
Place place(std::mt19937& random) {
  std::uniform_real_distribution<float> unit(0, 1);
  return {0.1f + 0.6f * unit(random), 0.1f + 0.6f * unit(random), 0.05f + 0.2f * unit(random),
          0.05f + 0.2f * unit(random)};
}
// Rows of a YOLO head with `fixed` values before 80 classes.
Rows yolo_rows(size_t rows, size_t fixed, bool has_angle) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> low(0, 0.2f);
  const size_t length = fixed + 80 + (has_angle ? 1 : 0);
  Rows out{rows, length, Floats(rows * length)};
  for (size_t i = 0; i < rows; ++i) {
    float* row = &out.values[i * length];
    const Place p = place(random);
    row[0] = p.x, row[1] = p.y, row[2] = p.width, row[3] = p.height;
    for (size_t c = 4; c < length; ++c) row[c] = low(random);
    if (i % (rows / kObjects) == 0) {
      row[4] = 0.9f;
      row[fixed + i % 80] = 0.6f + low(random);
    }
  }
  return out;
}
std::vector<Box> decode_yolo_plainly(const Rows& head, size_t fixed) {
  std::vector<Box> boxes;
  for (size_t i = 0; i < head.rows; ++i) {
    const float* row = &head.values[i * head.length];
    size_t best = 0;
    for (size_t c = 1; c < 80; ++c)
      if (row[fixed + c] > row[fixed + best]) best = c;
    const float score = row[fixed + best] * (fixed == 5 ? row[4] : 1);
    if (!(score > 0.25f)) continue;
    const float w = row[2] * kInput, h = row[3] * kInput;
    boxes.push_back({static_cast<int>(std::max(0.f, row[0] * kInput - w / 2)),
                     static_cast<int>(std::max(0.f, row[1] * kInput - h / 2)), static_cast<int>(w),
                     static_cast<int>(h), static_cast<int>(best), score});
  }
  return boxes;
}

// One scheme: its tensors, the options of the element and the plain loop.
struct Case {
  std::string name, dimensions, options;
  std::vector<Floats> tensors;
  std::function<std::vector<Box>()> decode;
  bool has_labels;
};

void measure(const Case& c, int rounds) {
  std::string types = "float32";
  for (size_t i = 1; i < c.tensors.size(); ++i) types += "\\,float32";
  const std::string caps = "other/tensors,format=static,num_tensors=(int)" +
                           std::to_string(c.tensors.size()) + ",dimensions=(string)\"" +
                           c.dimensions + "\",types=(string)\"" + types +
                           "\",framerate=(fraction)30/1";
  const std::string size = std::to_string(kInput);
  ElementStage none("identity", caps.c_str(), 1);
  ElementStage drawn("tensor_decoder mode=bounding_boxes option4=640:480 option5=" + size + ":" +
                         size + " option1=" + c.name + " " + c.options,
                     caps.c_str(), 1);
  std::vector<Ref<GstMemory>> memories;
  for (const Floats& values : c.tensors) {
    const size_t bytes = values.size() * sizeof(float);
    memories.push_back(Ref<GstMemory>::adopt(
        gst_memory_new_wrapped(GST_MEMORY_FLAG_READONLY, const_cast<float*>(values.data()), bytes,
                               0, bytes, nullptr, nullptr)));
  }
  const auto fill = [&](GstBuffer* buffer) {
    gst_buffer_remove_all_memory(buffer);
    for (const auto& memory : memories)
      gst_buffer_append_memory(buffer, gst_memory_ref(memory.get()));
  };
  Frame plain;
  const auto costs =
      weir::bench::min({[&] { none.push(kFrames, fill); }, [&] { drawn.push(kFrames, fill); },
                        [&] {
                          for (int i = 0; i < kFrames; ++i) plain.draw(c.decode(), c.has_labels);
                        }},
                       rounds);
  const int us = static_cast<int>(costs[2].cpu / kFrames * 1e6);
  weir::bench::report("bounding_boxes " + c.name + ", 640x480: CPU time",
                      "a plain loop, " + std::to_string(us) + " us",
                      (costs[1].cpu - costs[0].cpu) / costs[2].cpu, "x", 1.2);
}

Case yolo_case(const std::string& name, size_t rows, size_t fixed, const std::string& labels) {
  const bool is_oriented = name == "yolov8-obb";
  const Rows head = yolo_rows(rows, fixed, is_oriented);
  return {name,
          std::to_string(head.length) + ":" + std::to_string(rows),
          labels,
          {head.values},
          [=] { return suppress_plainly(decode_yolo_plainly(head, fixed), 0.45f); },
          !is_oriented};
}

Case yolov10_case(const std::string& labels) {
  std::mt19937 random(2);
  Floats rows;
  for (int i = 0; i < 300; ++i) {
    const Place p = place(random);
    rows.insert(rows.end(), {p.x, p.y, p.x + p.width, p.y + p.height, i < kObjects ? 0.9f : 0.1f,
                             static_cast<float>(i % 80)});
  }
  return {
      "yolov10",
      "6:300",
      labels,
      {rows},
      [rows] {
        std::vector<Box> boxes;
        for (const float* r = rows.data(); r[4] >= 0.25f; r += 6)
          boxes.push_back({static_cast<int>(r[0] * kInput), static_cast<int>(r[1] * kInput),
                           static_cast<int>((r[2] - r[0]) * kInput),
                           static_cast<int>((r[3] - r[1]) * kInput), static_cast<int>(r[5]), r[4]});
        return boxes;
      },
      true};
}

Case postprocess_case(const std::string& labels) {
  std::mt19937 random(3);
  Floats places, classes, scores;
  for (int i = 0; i < kObjects; ++i) {
    const Place p = place(random);
    places.insert(places.end(), {p.y, p.x, p.y + p.height, p.x + p.width});
    classes.push_back(static_cast<float>(i));
    scores.push_back(0.9f);
  }
  return {"mobilenet-ssd-postprocess",
          "4:20\\,20\\,20\\,1",
          "option3=0:1:2:3,50 " + labels,
          {places, classes, scores, {kObjects}},
          [=] {
            std::vector<Box> boxes;
            for (size_t i = 0; i < kObjects; ++i) {
              if (!(scores[i] >= 0.5f)) continue;
              float p[4];
              for (size_t k = 0; k < 4; ++k) p[k] = std::clamp(places[4 * i + k], 0.f, 1.f);
              boxes.push_back({static_cast<int>(p[1] * kInput), static_cast<int>(p[0] * kInput),
                               static_cast<int>((p[3] - p[1]) * kInput),
                               static_cast<int>((p[2] - p[0]) * kInput),
                               static_cast<int>(classes[i]), scores[i]});
            }
            return boxes;
          },
          true};
}

Case ssd_case(const std::string& labels, const std::string& priors_path) {
  constexpr size_t kAnchors = 1917, kClasses = 80;
  std::mt19937 random(4);
  std::uniform_real_distribution<float> low(-8, -3);
  Floats priors(4 * kAnchors), offsets(4 * kAnchors, 0.1f), scores(kClasses * kAnchors);
  std::ofstream file(priors_path);
  for (size_t i = 0; i < kAnchors; ++i) {
    const Place p = place(random);
    const float values[] = {p.y, p.x, p.height, p.width};
    for (size_t k = 0; k < 4; ++k) priors[k * kAnchors + i] = values[k];
    for (size_t c = 0; c < kClasses; ++c) scores[i * kClasses + c] = low(random);
    if (i % (kAnchors / kObjects) == 0) scores[i * kClasses + 7] = 2;
  }
  for (size_t i = 0; i < priors.size(); ++i) file << priors[i] << ((i + 1) % kAnchors ? " " : "\n");
  return {"mobilenet-ssd",
          "4:1:1917\\,80:1917",
          "option3=" + priors_path + " " + labels,
          {offsets, scores},
          [=] {
            std::vector<Box> boxes;
            for (size_t i = 0; i < kAnchors; ++i) {
              const float* s = &scores[i * kClasses];
              size_t best = 1;
              for (size_t c = 2; c < kClasses; ++c)
                if (s[c] > s[best]) best = c;
              if (!(s[best] >= 0)) continue;
              const float *b = &offsets[4 * i], *p = &priors[i];
              const float yc = b[0] / 10 * p[2 * kAnchors] + p[0];
              const float xc = b[1] / 10 * p[3 * kAnchors] + p[kAnchors];
              const float h = std::exp(b[2] / 5) * p[2 * kAnchors];
              const float w = std::exp(b[3] / 5) * p[3 * kAnchors];
              boxes.push_back({std::max(0, static_cast<int>((xc - w / 2) * kInput)),
                               std::max(0, static_cast<int>((yc - h / 2) * kInput)),
                               static_cast<int>(w * kInput), static_cast<int>(h * kInput),
                               static_cast<int>(best), 1 / (1 + std::exp(-s[best]))});
            }
            return suppress_plainly(std::move(boxes), 0.5f);
          },
          true};
}

Case openvino_case() {
  std::mt19937 random(5);
  Floats records;
  for (int i = 0; i < 200; ++i) {
    const Place p = place(random);
    records.insert(records.end(), {i < 100 ? 0.f : -1.f, 1, i % 5 ? 0.1f : 0.9f, p.x, p.y,
                                   p.x + p.width, p.y + p.height});
  }
  return {"ov-person-detection",
          "7:200",
          "",
          {records},
          [records] {
            std::vector<Box> boxes;
            for (const float* r = records.data(); r[0] >= 0; r += 7)
              if (r[2] >= 0.8f)
                boxes.push_back({static_cast<int>(r[3] * kInput), static_cast<int>(r[4] * kInput),
                                 static_cast<int>((r[5] - r[3]) * kInput),
                                 static_cast<int>((r[6] - r[4]) * kInput), -1, 1});
            return boxes;
          },
          false};
}

// 2016 anchors of a grid that all have the size of the picture.
Case palm_case() {
  constexpr size_t kRows = 2016, kLength = 18;
  Floats boxes(kRows * kLength), scores(kRows, -9), centres(2 * kRows);
  for (size_t i = 0; i < kRows; ++i) {
    const bool is_fine = i < 1152;
    const size_t cell = is_fine ? i / 2 : (i - 1152) / 6, cells = is_fine ? 24 : 12;
    centres[2 * i] = (static_cast<float>(cell % cells) + 0.5f) / static_cast<float>(cells);
    centres[2 * i + 1] = (static_cast<float>(cell / cells) + 0.5f) / static_cast<float>(cells);
    std::fill_n(&boxes[i * kLength + 2], 2, 30.f);
    if (i % (kRows / kObjects) == 0) scores[i] = 2;
  }
  return {
      "mp-palm-detection",
      "18:2016\\,1:2016",
      "option3=0.5",
      {boxes, scores},
      [=] {
        std::vector<Box> found;
        for (size_t i = 0; i < kRows; ++i) {
          const float score = 1 / (1 + std::exp(-std::clamp(scores[i], -100.f, 100.f)));
          if (!(score >= 0.5f)) continue;
          const float* b = &boxes[i * kLength];
          const float yc = b[0] / kInput + centres[2 * i + 1], xc = b[1] / kInput + centres[2 * i];
          const float h = b[2] / kInput, w = b[3] / kInput;
          found.push_back({std::max(0, static_cast<int>((xc - w / 2) * kInput)),
                           std::max(0, static_cast<int>((yc - h / 2) * kInput)),
                           static_cast<int>(w * kInput), static_cast<int>(h * kInput), 0, score});
        }
        return suppress_plainly(std::move(found), 0.05f);
      },
      false};
}

}  // namespace

int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 15;
  const std::string folder = "/tmp/weir-boxes-cost-" + std::to_string(getpid());
  const std::string label_path = folder + "-labels.txt", priors_path = folder + "-priors.txt";
  std::ofstream labels(label_path);
  for (int i = 0; i < 80; ++i) labels << "person\n";
  labels.close();
  const std::string option2 = "option2=" + label_path;
  measure(ssd_case(option2, priors_path), rounds);
  measure(postprocess_case(option2), rounds);
  measure(openvino_case(), rounds);
  measure(yolo_case("yolov5", 6300, 5, option2), rounds);
  measure(yolo_case("yolov8", 2100, 4, option2), rounds);
  measure(yolo_case("yolov8-obb", 2100, 4, option2), rounds);
  measure(yolov10_case(option2), rounds);
  measure(palm_case(), rounds);
  std::remove(label_path.c_str());
  std::remove(priors_path.c_str());
}
