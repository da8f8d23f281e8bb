// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/run_lengths.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace weir::records {
namespace {

constexpr uint8_t kSet = 128;  // least probability

// Appends runs of pixels; equal neighbours become one run.
class RunWriter {
 public:
  // `set` pixels from `begin` to `end`, counted down the columns; those between are not set.
  void add(uint64_t begin, uint64_t end) {
    if (begin >= end) return;
    if (begin == at_ && !runs_.empty()) {
      runs_.back() += static_cast<uint32_t>(end - begin);
    } else {
      runs_.push_back(static_cast<uint32_t>(begin - at_));
      runs_.push_back(static_cast<uint32_t>(end - begin));
    }
    at_ = end;
  }
  RunLengths finish(uint64_t pixels) {
    if (at_ < pixels || runs_.empty()) runs_.push_back(static_cast<uint32_t>(pixels - at_));
    return std::move(runs_);
  }

 private:
  RunLengths runs_;
  uint64_t at_ = 0;
};

// The first pixel whose centre is at or after the edge of each cell, for `cells` cells from `begin`
// to `end`.
std::vector<uint32_t> pixel_edges(float begin, float end, uint32_t cells, uint32_t pixels) {
  std::vector<uint32_t> out(cells + size_t{1});
  const double step = (double{end} - begin) / cells;
  for (size_t i = 0; i < out.size(); ++i) {
    const double edge = std::ceil(begin + static_cast<double>(i) * step - 0.5);
    out[i] = static_cast<uint32_t>(std::clamp(edge, 0.0, static_cast<double>(pixels)));
  }
  return out;
}

}  // namespace

RunLengths runs_of_mask(const MaskView& mask, const Box& box, uint32_t width, uint32_t height) {
  RunWriter out;
  const uint64_t pixels = uint64_t{width} * height;
  if (!(box.area() > 0) || mask.values.empty()) return out.finish(pixels);
  const auto columns = pixel_edges(box.x1, box.x2, mask.width, width);
  const auto rows = pixel_edges(box.y1, box.y2, mask.height, height);
  for (uint32_t column = 0; column < mask.width; ++column)
    for (uint64_t x = columns[column]; x < columns[column + 1]; ++x)
      for (uint32_t row = 0; row < mask.height; ++row)
        if (static_cast<uint8_t>(mask.values[size_t{row} * mask.width + column]) >= kSet)
          out.add(x * height + rows[row], x * height + rows[row + 1]);
  return out.finish(pixels);
}

std::vector<ClassRuns> runs_of_classes(const ClassMapView& classes, const SourceMap& map,
                                       uint32_t width, uint32_t height) {
  std::map<uint32_t, RunWriter> writers;
  RunWriter* writer = nullptr;  // of the class `last`
  uint32_t last = 0;
  for (uint64_t x = 0; x < width; ++x)
    for (uint64_t y = 0; y < height; ++y) {
      const Point at = map.to_tensor({static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5});
      if (!(at.x >= 0 && at.y >= 0 && at.x < classes.width && at.y < classes.height)) continue;
      const size_t index = static_cast<size_t>(at.y) * classes.width + static_cast<size_t>(at.x);
      const uint32_t here = classes.at(index);
      if (!writer || here != last) writer = &writers[here];
      last = here;
      writer->add(x * height + y, x * height + y + 1);
    }
  std::vector<ClassRuns> out;
  out.reserve(writers.size());
  for (auto& [index, runs] : writers) out.push_back({index, runs.finish(uint64_t{width} * height)});
  return out;
}

std::string to_string(const RunLengths& runs) {
  std::string out;
  for (size_t i = 0; i < runs.size(); ++i) {
    int64_t rest = runs[i];
    if (i > 2) rest -= runs[i - 2];
    for (bool more = true; more;) {
      int64_t bits = rest & 0x1F;
      rest >>= 5;
      // The highest of the five bits is the sign of what is left out.
      more = bits & 0x10 ? rest != -1 : rest != 0;
      if (more) bits |= 0x20;
      out.push_back(static_cast<char>('0' + bits));
    }
  }
  return out;
}

namespace {

// Takes a number off the beginning: groups of five bits, the lowest first.
std::optional<int64_t> take_number(std::string_view* text) {
  constexpr unsigned kMaxShift = 35;  // a run of 32 bits, with its sign
  int64_t value = 0;
  for (unsigned shift = 0; shift <= kMaxShift; shift += 5) {
    if (text->empty() || text->front() < '0' || text->front() > 'o') return std::nullopt;
    const int64_t group = text->front() - '0';
    text->remove_prefix(1);
    value |= (group & 0x1F) << shift;
    if ((group & 0x20) != 0) continue;
    return (group & 0x10) != 0 ? value - (int64_t{1} << (shift + 5)) : value;
  }
  return std::nullopt;
}

}  // namespace

std::optional<RunLengths> runs_of_text(std::string_view text, uint64_t pixels) {
  RunLengths out;
  uint64_t sum = 0;
  while (!text.empty()) {
    auto value = take_number(&text);
    if (!value) return std::nullopt;
    if (out.size() > 2) *value += out[out.size() - 2];
    if (*value < 0 || static_cast<uint64_t>(*value) > pixels - sum) return std::nullopt;
    sum += static_cast<uint64_t>(*value);
    out.push_back(static_cast<uint32_t>(*value));
  }
  return sum == pixels ? std::optional(out) : std::nullopt;
}

}  // namespace weir::records
