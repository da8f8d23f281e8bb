// Writes frames of 100 objects with 17 key points each as JSON Lines: the part of a frame's time at
// 25 frames per second, and the ratio to nlohmann's writer of the same values.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/records/record_writer.hpp"
#include "rounds.hpp"

namespace {

using namespace weir;

constexpr uint32_t kObjects = 100, kPoints = 17, kNumbers = 9 + 3 * kPoints;
constexpr int kFrames = 50, kRounds = 15;
constexpr double kBudget = 1.0 / 25;  // seconds

std::vector<float> rows() {
  std::vector<float> out;
  for (uint32_t i = 0; i < kObjects; ++i) {
    const float x = 17.37f * static_cast<float>(i), y = 9.13f * static_cast<float>(i);
    for (const float number : {x, y, x + 61.7f, y + 143.9f, 0.31f + 0.0067f * static_cast<float>(i),
                               static_cast<float>(i % 80), static_cast<float>(i + 1), -1.0f, 0.0f})
      out.push_back(number);
    for (uint32_t p = 0; p < kPoints; ++p)
      for (const float number :
           {x + 3.61f * static_cast<float>(p), y + 8.43f * static_cast<float>(p), 0.9123f})
        out.push_back(number);
  }
  return out;
}

}  // namespace

int main() {
  const auto numbers = rows();
  const std::vector<records::ResultTensor> tensors{
      {{.type = ElementType::Float32, .shape = Shape{kNumbers, kObjects}, .name = {}},
       std::as_bytes(std::span(numbers))}};
  const auto reader = records::ResultReader::make(
      "x1,y1,x2,y2,score,class,track,parent,rotation,xys:17", "yolo11n-pose");
  if (!reader) return 1;
  const auto writer = records::json_writer({});
  records::ResultFrame frame;
  std::string text;
  const records::FrameFacts facts{.running_time = 1234567890, .width = 1920, .height = 1080};
  const auto write = [&] {
    for (int i = 0; i < kFrames; ++i) {
      text.clear();
      if (reader->read(tensors, &frame)) writer->write(*reader, frame, facts, &text);
    }
  };
  write();
  // The same values in nlohmann's objects; only dump() is measured.
  const auto json = nlohmann::ordered_json::parse(text);
  size_t dumped = 0;
  const auto dump = [&] {
    for (int i = 0; i < kFrames; ++i) dumped += json.dump().size();
  };
  const auto costs = bench::medians({write, dump}, kRounds);
  if (dumped == 0) return 1;
  bench::report("JSON of 100 objects with 17 key points each, part of a frame at 25 frames/s",
                "40 ms", costs[0].cpu / kFrames / kBudget, "x", 0.02);
  bench::report("JSON of 100 objects with 17 key points each", "dump() of nlohmann-json",
                costs[0].cpu / costs[1].cpu, "x", 1);
  return 0;
}
