// A converter of recordings of event cameras, Event Stream files (.es) of version 2.0, to event
// frames of 64x48 bytes: 128 + 16 * (events that became brighter - events that became darker) of
// the pixels that fall into the same place, limited to a byte.
//
//   filesrc location=recording.es blocksize=64 ! application/x-event-stream,framerate=30/1 !
//       tensor_converter
//
// Each buffer of the file completes one frame at most, hence the small blocksize. The last frame of
// a recording is never completed, and left out. Format:
// github.com/neuromorphic-paris/event_stream.
//
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <deque>

#include "weir/converter.hpp"

namespace {

constexpr int64_t kWidth = 64, kHeight = 48, kRest = 128, kGain = 16;
constexpr size_t kHeader = 20, kFramesKept = 300;
constexpr std::string_view kBegin{"Event Stream\x02"};
constexpr size_t kKind = 15;  // the place of the kind of events in the header
constexpr std::byte kDvs{1};
// An event is the time since the last one in 7 bits and whether it became brighter in the lowest
// bit, then x and y in two bytes each. Two values of the first byte are no events.
constexpr uint32_t kReset = 0xfe, kOverflow = 0xff;
constexpr int64_t kOverflowTime = 127;  // microseconds

// The frame rate in caps such as `application/x-event-stream, framerate=(fraction)30/1`; 0 if there
// is none.
std::pair<int64_t, int64_t> parse_rate(std::string_view caps) {
  constexpr std::string_view kField = "framerate=(fraction)";
  std::pair<int64_t, int64_t> rate{0, 1};
  if (const size_t at = caps.find(kField); at != std::string_view::npos) {
    const char* end = caps.data() + caps.size();
    const auto number = std::from_chars(caps.data() + at + kField.size(), end, rate.first);
    if (number.ptr != end) std::from_chars(number.ptr + 1, end, rate.second);
  }
  return rate;
}

class EventStream {
 public:
  explicit EventStream(const weir::Options&) {}

  std::vector<weir_tensor_info> configure(std::string_view caps) {
    rate_ = parse_rate(caps);
    reset();
    return {kFrame};
  }

  bool convert(const weir_frame& buffer, weir::ConverterOutput& output) {
    if (rate_.first < 1 || rate_.second < 1)
      throw weir::Failure({.code = weir::Code::OPTION_VALUE,
                           .what = "an event stream has no frame rate",
                           .offered = "framerate=0/1",
                           .needed = "the rate of the event frames in the caps",
                           .fix = "application/x-event-stream,framerate=30/1"});
    for (uint32_t i = 0; i < buffer.n_tensors; ++i)
      for (const auto byte : weir::elements<const std::byte>(buffer.tensors[i])) read(byte);
    if (frames_.size() < 2) return false;
    const auto to = output.add(kFrame);
    for (size_t i = 0; i < to.size(); ++i)
      to[i] = static_cast<std::byte>(
          std::clamp<int64_t>(kRest + kGain * frames_.front()[i], 0, UINT8_MAX));
    output.set_time(get_begin(first_), get_begin(first_ + 1) - get_begin(first_));
    frames_.pop_front();
    ++first_;
    return true;
  }

  void reset() noexcept {
    frames_.clear();
    header_.clear();
    event_bytes_ = 0;
    time_ = first_ = 0;
  }

 private:
  using Counts = std::array<int32_t, kWidth * kHeight>;
  static inline const weir_tensor_info kFrame =
      weir::dense_tensor(WEIR_UINT8, {1, kHeight, kWidth});

  // The time of a frame in nanoseconds.
  int64_t get_begin(int64_t frame) const {
    return frame * 1'000'000'000 * rate_.second / rate_.first;
  }

  void read(std::byte byte) {
    if (header_.size() < kHeader) {
      header_.push_back(byte);
      if (header_.size() == kHeader) check_header();
      return;
    }
    event_[event_bytes_++] = static_cast<uint32_t>(byte);
    if (event_[0] >= kReset) {  // no event
      if (event_[0] == kOverflow) time_ += kOverflowTime;
      event_bytes_ = 0;
    } else if (event_bytes_ == event_.size()) {
      time_ += event_[0] >> 1U;
      event_bytes_ = 0;
      add(event_[1] | event_[2] << 8U, event_[3] | event_[4] << 8U, event_[0] & 1U ? 1 : -1);
    }
  }

  void check_header() {
    const auto* text = reinterpret_cast<const char*>(header_.data());
    const auto extent = [this](size_t at) {
      return static_cast<int64_t>(header_[at]) | static_cast<int64_t>(header_[at + 1]) << 8;
    };
    width_ = extent(16);
    height_ = extent(18);
    if (std::string_view(text, kBegin.size()) != kBegin || header_[kKind] != kDvs)
      throw weir::Failure({.code = weir::Code::MODEL_INVALID,
                           .what = "the bytes are not an event stream",
                           .offered = "other bytes at the begin",
                           .needed = "a file of Event Stream 2.0 with DVS events",
                           .fix = "filesrc location=recording.es"});
    if (width_ < kWidth || height_ < kHeight || width_ % kWidth || height_ % kHeight)
      throw weir::Failure({.code = weir::Code::SPEC_MISMATCH,
                           .what = "the event camera has a size that does not fit the frames",
                           .offered = std::to_string(width_) + "x" + std::to_string(height_),
                           .needed = "multiples of 64x48, as 320x240",
                           .fix = "record with such a camera"});
  }

  void add(uint32_t x, uint32_t y, int32_t change) {
    if (x >= width_ || y >= height_)
      throw weir::Failure(
          {.code = weir::Code::SPEC_MISMATCH,
           .what = "an event lies outside the camera's picture",
           .offered = std::to_string(x) + "," + std::to_string(y),
           .needed = "less than " + std::to_string(width_) + "," + std::to_string(height_),
           .fix = "the file is damaged: record it again"});
    const int64_t frame = time_ * rate_.first / (1'000'000 * rate_.second);
    if (frame - first_ >= static_cast<int64_t>(kFramesKept))
      throw weir::Failure({.code = weir::Code::LIMIT_EXCEEDED,
                           .what = "the buffers of an event stream hold too many frames each",
                           .offered = std::to_string(frame - first_ + 1) + " frames wait",
                           .needed = "one frame in each buffer, at most " +
                                     std::to_string(kFramesKept) + " that wait",
                           .fix = "filesrc blocksize=64"});
    while (first_ + static_cast<int64_t>(frames_.size()) <= frame) frames_.push_back({});
    const int64_t column = x * kWidth / width_, row = y * kHeight / height_;
    frames_.back()[static_cast<size_t>(row * kWidth + column)] += change;
  }

  std::pair<int64_t, int64_t> rate_{0, 1};
  std::vector<std::byte> header_;
  int64_t width_ = 0, height_ = 0;
  std::array<uint32_t, 5> event_{};
  size_t event_bytes_ = 0;
  int64_t time_ = 0;           // of the last event, in microseconds
  int64_t first_ = 0;          // the number of the first frame in frames_
  std::deque<Counts> frames_;  // all but the last are complete
};

}  // namespace

WEIR_CONVERTER(EventStream, "event-stream", "",
               "application/x-event-stream, framerate=(fraction)[ 0/1, 2147483647/1 ]", "[]")
