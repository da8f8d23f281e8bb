// Compares windows with plain references: coordinate by coordinate, frame by frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/window/window.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

namespace weir::window {
namespace window_test {

using Bytes = std::vector<std::byte>;

TensorSpec spec(const char* dims, ElementType type = ElementType::UInt8) {
  return {type, Shape::parse(dims), ""};
}
Error error_of(const WindowRequest& request, const std::vector<TensorSpec>& input) {
  const auto result = plan(request, input);
  EXPECT_FALSE(result);
  return result ? Error{} : result.error();
}

TEST(Window, MultipliesItsDimension) {
  const auto p = plan({1, 4, 4, 3, true}, {spec("3:640:480:1")});
  ASSERT_TRUE(p);
  EXPECT_EQ(p->output[0].to_string(), "uint8 3:640:480:4");
  EXPECT_TRUE(p->layouts[0].is_plain());
  EXPECT_FALSE(p->passes_through);
  EXPECT_FALSE(p->overlaps());
  EXPECT_EQ(p->layouts[0].frame_bytes, 3u * 640 * 480);
}

TEST(Window, SplitsBuffersOfSeveralFrames) {
  const auto p = plan({6, 2, 0, 1, true}, {spec("4:12:1:1"), spec("6", ElementType::Float32)});
  ASSERT_TRUE(p);
  EXPECT_EQ(p->output[0].to_string(), "uint8 4:4:1:1");
  EXPECT_EQ(p->output[1].to_string(), "float32 6") << "dimension 1 of rank 1 stays unsaid";
  EXPECT_EQ(p->layouts[1].frame_bytes, 4u);
  EXPECT_TRUE(p->size_differs);
  EXPECT_EQ(*p->memory[1].bytes(), 8u);
}

TEST(Window, KeepsCapsIfTheDimensionIsBeyondTheRank) {
  const auto p = plan({1, 3, 0, 15, true}, {spec("3:4:4:1")});
  ASSERT_TRUE(p);
  EXPECT_EQ(p->output[0].to_string(), "uint8 3:4:4:1");
  EXPECT_TRUE(p->size_differs);
  EXPECT_EQ(*p->memory[0].bytes(), 3u * 48);
  const auto same = plan({2, 2, 1, 15, true}, {spec("3:4")});
  ASSERT_TRUE(same);
  EXPECT_FALSE(same->size_differs);
}

TEST(Window, PassesWholeWindowsThrough) {
  EXPECT_TRUE(plan({3, 3, 0, 0, true}, {spec("6")})->passes_through);
  EXPECT_TRUE(plan({3, 3, 3, 0, true}, {spec("6")})->passes_through);
  EXPECT_FALSE(plan({3, 3, 1, 0, true}, {spec("6")})->passes_through);
  EXPECT_FALSE(plan({3, 6, 0, 0, true}, {spec("6")})->passes_through);
}

// frames-in * ceil(frames-out / frames-in) < frames-flush, for every combination up to 7.
TEST(Window, CannotFlushMoreFramesThanItHolds) {
  for (uint32_t in = 1; in <= 7; ++in)
    for (uint32_t out = 1; out <= 7; ++out)
      for (uint32_t flush = 1; flush <= 20; ++flush) {
        uint32_t there = 0;
        while (there < out) there += in;
        const auto p = plan({in, out, flush, 0, true}, {spec("420")});
        EXPECT_EQ(p.has_value(), flush <= there) << in << " " << out << " " << flush;
      }
  const Error error = error_of({2, 3, 9, 0, true}, {spec("4")});
  EXPECT_EQ(error.code, Code::OPTION_VALUE);
  EXPECT_EQ(error.what, "frames-flush exceeds the number of frames in a full window");
  EXPECT_EQ(error.offered, "frames-flush=9, with frames-in=2 and frames-out=3");
  EXPECT_EQ(error.needed.substr(0, 9), "at most 4");
  EXPECT_EQ(error.fix, "frames-flush=4");
  EXPECT_TRUE(plan({2, 3, 4, 0, true}, {spec("4")})) << "the value that the error names works";
}

TEST(Window, ReportsADimensionThatIsNotAMultiple) {
  const Error error = error_of({4, 1, 0, 1, true}, {spec("3:4"), spec("3:10")});
  EXPECT_EQ(error.code, Code::OPTION_VALUE);
  EXPECT_EQ(error.offered, "frames-in=4, and dimension 1 of tensor 1 (uint8 3:10) is 10");
  EXPECT_EQ(error.difference, "10 modulo 4 is 2");
  EXPECT_EQ(error.fix, "frames-in=2");
  EXPECT_TRUE(plan({2, 1, 0, 1, true}, {spec("3:4"), spec("3:10")}));
  EXPECT_EQ(error_of({4, 1, 0, 15, true}, {spec("3:10")}).offered,
            "frames-in=4, and tensor 0 (uint8 3:10) has 30 elements");
}

TEST(Window, RejectsWindowsTooLargeForATensor) {
  EXPECT_EQ(error_of({1, UINT32_MAX, 0, 0, true}, {spec("2")}).code, Code::LIMIT_EXCEEDED);
  EXPECT_EQ(error_of({1, 1u << 20, 0, 2, true}, {spec("4000000000:4000000000:1")}).code,
            Code::LIMIT_EXCEEDED);
  EXPECT_EQ(error_of({1, 2, 0, 15, true}, {spec("4000000000:4000000000")}).code,
            Code::LIMIT_EXCEEDED);
}

TEST(Window, WaitsForAsManyBuffersAsItSpans) {
  // Counted: the largest distance in buffers between the first and the last frame of many windows.
  for (uint32_t in = 1; in <= 6; ++in)
    for (uint32_t out = 1; out <= 12; ++out)
      for (uint32_t step = 1; step <= in * ((out + in - 1) / in); ++step) {
        const auto p = plan({in, out, step, 0, true}, {spec("60")});
        ASSERT_TRUE(p);
        uint64_t max = 0;
        for (uint64_t k = 0; k < 60 && !p->passes_through; ++k)
          max = std::max(max, (k * step + out - 1) / in - k * step / in);
        EXPECT_EQ(p->buffers_waited(), max) << in << " " << out << " " << step;
      }
}

// A tensor of random rank whose elements are numbered.
struct Case {
  WindowRequest request;
  TensorSpec input;
};
Case random_case(std::mt19937* random) {
  const auto below = [&](uint32_t n) { return static_cast<uint32_t>((*random)() % n); };
  Case c;
  const size_t rank = 1 + below(16);
  c.request = {1 + below(3), 1 + below(5), 0, below(static_cast<uint32_t>(rank)), below(4) > 0};
  for (size_t i = 0; i < rank; ++i) c.input.shape[i] = below(4) ? 1 : 1 + below(4);
  c.input.shape[c.request.dimension] = c.request.frames_in * (1 + below(3));
  c.input.type = below(2) ? ElementType::UInt16 : ElementType::UInt64;
  return c;
}

// Each element of the window comes from the corresponding element of one frame.
std::vector<uint64_t> expected_window(const Case& c, const std::vector<uint64_t>& stream,
                                      const TensorSpec& out) {
  const uint64_t frame_elements = *c.input.shape.count() / c.request.frames_in;
  if (!c.request.concatenate)
    return {stream.begin(),
            stream.begin() + static_cast<std::ptrdiff_t>(frame_elements * c.request.frames_out)};
  const uint32_t extent = c.input.shape[c.request.dimension] / c.request.frames_in;
  std::vector<uint64_t> values;
  std::vector<uint32_t> at(out.shape.rank());
  for (uint64_t n = 0; n < *out.shape.count(); ++n) {
    uint64_t offset = 0, stride = 1;
    for (size_t i = 0; i < at.size(); ++i) {
      const bool along = i == c.request.dimension;
      offset += (along ? at[i] % extent : at[i]) * stride;
      stride *= along ? extent : out.shape[i];
    }
    values.push_back(stream[at[c.request.dimension] / extent * frame_elements + offset]);
    for (size_t i = 0; i < at.size() && ++at[i] == out.shape[i]; ++i) at[i] = 0;
  }
  return values;
}

TEST(Window, IsAConcatenationCoordinateByCoordinate) {
  std::mt19937 random(5);
  for (int round = 0; round < 400; ++round) {
    const Case c = random_case(&random);
    const auto p = plan(c.request, {c.input});
    ASSERT_TRUE(p) << p.error().message();
    const size_t size = element_size(c.input.type);
    const WindowLayout& layout = p->layouts[0];
    std::vector<uint64_t> stream(layout.frame_bytes / size * p->out);
    for (auto& value : stream) value = random() % 65536;
    Bytes out(*p->output[0].bytes());
    for (uint64_t f = 0; f < p->out; ++f) {
      Bytes frame(layout.frame_bytes);
      for (size_t i = 0; i < frame.size() / size; ++i)
        std::memcpy(frame.data() + i * size, &stream[f * (frame.size() / size) + i], size);
      place(layout, f, p->out, frame, out);
    }
    const auto expected = expected_window(c, stream, p->output[0]);
    ASSERT_EQ(expected.size() * size, out.size());
    for (size_t i = 0; i < expected.size(); ++i) {
      uint64_t value = 0;
      std::memcpy(&value, out.data() + i * size, size);
      ASSERT_EQ(value, expected[i]) << c.input.to_string() << " along " << c.request.dimension
                                    << " at " << i << " of " << p->output[0].to_string();
    }
  }
}

TEST(Window, PlacesBlocksOfEverySize) {
  for (const size_t block : {1, 2, 3, 4, 5, 7, 8, 12, 16, 24}) {
    const WindowLayout layout{block * 3, block};
    Bytes a(layout.frame_bytes), b(layout.frame_bytes), out(2 * layout.frame_bytes), expected;
    for (size_t i = 0; i < a.size(); ++i) a[i] = std::byte(i), b[i] = std::byte(100 + i);
    for (size_t k = 0; k < 3; ++k)
      for (const Bytes* frame : {&a, &b})
        expected.insert(expected.end(), frame->begin() + static_cast<std::ptrdiff_t>(k * block),
                        frame->begin() + static_cast<std::ptrdiff_t>((k + 1) * block));
    place(layout, 0, 2, a, out);
    place(layout, 1, 2, b, out);
    EXPECT_EQ(out, expected) << block;
  }
}

TEST(Window, HasExactTimesAfterAMillionFrames) {
  constexpr Fraction kNtsc{30000, 1001};
  for (const uint64_t frames : {1ull, 29ull, 999'999ull, 1'000'000ull, 123'456'789'012ull}) {
    // n * 1001 s / 30000, as quotient and remainder to stay within 64 bits.
    const uint64_t numerator = frames * 1001, denominator = 30000;
    const uint64_t expected = numerator / denominator * 1'000'000'000 +
                              numerator % denominator * 1'000'000'000 / denominator;
    EXPECT_EQ(to_time(frames, kNtsc), expected);
  }
  EXPECT_EQ(to_time(5, {0, 1}), 0u);
  EXPECT_EQ(to_time(5, {-1, -1}), 0u);
}

}  // namespace window_test
}  // namespace weir::window
