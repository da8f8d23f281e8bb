// Compares the rate with a plain model, tick by tick, and rejects invalid framerates.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/rate/frame_rate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace weir {
namespace frame_rate_test {

constexpr uint64_t kMillisecond = 1'000'000;
using Times = std::vector<uint64_t>;

// The frame that each tick takes in FrameRate.
std::vector<size_t> taken(const Times& frames, Fraction rate) {
  FrameRate converter(rate);
  std::vector<size_t> out;
  for (size_t i = 0; i < frames.size(); ++i) {
    while (const auto tick = converter.take_before(frames[i])) {
      EXPECT_EQ(tick->number, out.size());
      out.push_back(i - 1);
    }
    converter.hold(frames[i]);
  }
  return out;
}

// The same, tick by tick: the first frame, from the last taken one on, whose successor is not
// nearer. At a tie, the frame takes this tick as its last one.
std::vector<size_t> model(const Times& frames, Fraction rate) {
  const auto away = [](uint64_t a, uint64_t b) { return std::max(a, b) - std::min(a, b); };
  std::vector<size_t> out;
  size_t frame = 0;
  while (true) {
    const uint64_t numerator =
        out.size() * 1'000'000'000ull * static_cast<uint64_t>(rate.denominator);
    const uint64_t tick = frames[0] + numerator / static_cast<uint64_t>(rate.numerator);
    while (frame + 1 < frames.size() && away(frames[frame], tick) > away(frames[frame + 1], tick))
      ++frame;
    if (frame + 1 >= frames.size()) return out;
    out.push_back(frame);
    if (away(frames[frame], tick) == away(frames[frame + 1], tick)) ++frame;
  }
}

Times steady(size_t count, uint64_t interval, uint64_t begin = 0) {
  Times out(count);
  for (size_t i = 0; i < count; ++i) out[i] = begin + i * interval;
  return out;
}

TEST(FrameRate, HalvesAndDoubles) {
  EXPECT_EQ(taken(steady(7, 100 * kMillisecond), {5, 1}), (std::vector<size_t>{0, 2, 4}));
  EXPECT_EQ(taken(steady(3, 200 * kMillisecond), {10, 1}), (std::vector<size_t>{0, 0, 1, 1}));
  EXPECT_EQ(taken(steady(4, 100 * kMillisecond, 777), {10, 1}), (std::vector<size_t>{0, 1, 2}));
}

TEST(FrameRate, AgreesWithThePlainModelForRandomStreams) {
  std::mt19937 random(21);
  const Fraction rates[] = {{30, 1}, {15, 1}, {30000, 1001}, {1, 1}, {7, 3}, {120, 1}};
  for (int round = 0; round < 600; ++round) {
    const Fraction rate = rates[random() % std::size(rates)];
    Times frames{random() % 1'000'000'000};
    const uint64_t typical = 1 + random() % (200 * kMillisecond);
    for (size_t i = 0; i < 60; ++i) {
      uint64_t gap = typical;                               // steady,
      if (round % 4 == 1) gap = random() % (2 * typical);   // with jitter,
      if (round % 4 == 2 && random() % 10 == 0) gap *= 10;  // with gaps,
      if (round % 4 == 3 && random() % 3 == 0) gap = 0;     // with equal times
      frames.push_back(frames.back() + gap);
    }
    ASSERT_EQ(taken(frames, rate), model(frames, rate)) << "round " << round;
  }
}

TEST(FrameRate, AssignsTicksInOrderOfFramesAndLosesNone) {
  std::mt19937 random(4);
  for (int round = 0; round < 100; ++round) {
    Times frames{5};
    for (size_t i = 0; i < 100; ++i)
      frames.push_back(frames.back() + random() % (90 * kMillisecond));
    const auto out = taken(frames, {25, 1});
    EXPECT_TRUE(std::is_sorted(out.begin(), out.end()));
    // All ticks up to half an interval before the last frame are taken.
    EXPECT_GE((out.size() + 1) * 40 * kMillisecond + 90 * kMillisecond, frames.back() - 5);
  }
}

TEST(FrameRate, DoesNotDriftOverAMillionTicks) {
  FrameRate converter({30000, 1001});
  converter.hold(3);
  uint64_t end = 3;
  for (uint64_t i = 0; i < 1'000'000; ++i) {
    const auto tick = converter.take_before(UINT64_MAX / 2);
    ASSERT_TRUE(tick);
    const uint64_t exact =
        i * 1001 / 30000 * 1'000'000'000 + i * 1001 % 30000 * 1'000'000'000 / 30000;
    ASSERT_EQ(tick->time, 3 + exact);
    ASSERT_EQ(tick->time, end) << "ticks have no gaps";
    end = tick->time + tick->duration;
  }
}

constexpr uint64_t kSecond = 1'000'000'000;

// Returns all ticks between two frames.
std::vector<Tick> ticks_between(uint64_t first, uint64_t second, Fraction rate,
                                uint64_t max_duplication) {
  FrameRate converter(rate);
  converter.hold(first);
  std::vector<Tick> out;
  while (const auto tick = converter.take_before(second, max_duplication)) out.push_back(*tick);
  converter.hold(second);
  while (const auto tick = converter.take_before(second + 1, max_duplication)) out.push_back(*tick);
  return out;
}

TEST(FrameRate, LeavesTicksFarFromBothFramesEmpty) {
  const uint64_t year = 365 * 24 * 3600 * kSecond;
  const auto ticks = ticks_between(0, year, {30, 1}, 2 * kSecond);
  ASSERT_EQ(ticks.size(), 61u + 1 + 61) << "ticks within 2 s of a frame, and one gap";
  const Tick& gap = ticks[61];
  EXPECT_FALSE(gap.has_frame);
  EXPECT_EQ(gap.number, 61u);
  EXPECT_EQ(gap.time, 61 * kSecond / 30);
  EXPECT_EQ(gap.time + gap.duration, year - 2 * kSecond);
  EXPECT_EQ(gap.count, year / kSecond * 30 - 60 - 61);
  EXPECT_EQ(ticks[62].time, year - 2 * kSecond);
  EXPECT_EQ(ticks[62].number, year / kSecond * 30 - 60) << "ticks are counted through the gap";
  EXPECT_EQ(ticks.back().time, year);
}

TEST(FrameRate, FillsAGapUpToTheLimitAsItDoesWithoutOne) {
  for (const uint64_t gap : {kSecond, 2 * kSecond, 4 * kSecond}) {
    const auto limited = ticks_between(7, 7 + gap, {30, 1}, 2 * kSecond);
    const auto unlimited = ticks_between(7, 7 + gap, {30, 1}, 0);
    EXPECT_EQ(limited.size(), gap / kSecond * 30 + 1);
    ASSERT_EQ(limited.size(), unlimited.size()) << gap;
    for (size_t i = 0; i < limited.size(); ++i) {
      EXPECT_TRUE(limited[i].has_frame) << gap << ", tick " << i;
      EXPECT_EQ(limited[i].time, unlimited[i].time);
    }
  }
}

TEST(FrameRate, CoversTheWholeTimeForRandomGapsAndLimits) {
  std::mt19937_64 random(5);
  const Fraction rates[] = {{30, 1}, {30000, 1001}, {1, 7}, {2147483647, 1}, {1, 2147483647}};
  for (int round = 0; round < 500; ++round) {
    const Fraction rate = rates[random() % std::size(rates)];
    const uint64_t interval = FrameRate(rate).interval();
    const uint64_t limit = 1 + random() % (50 * interval + 1);
    const uint64_t first = random() % kSecond;
    const uint64_t second = first + random() % (1000 * interval + 1);
    uint64_t end = first, number = 0;
    for (const Tick& tick : ticks_between(first, second, rate, limit)) {
      ASSERT_EQ(tick.time, end) << "no tick is lost or comes twice, round " << round;
      ASSERT_EQ(tick.number, number);
      const uint64_t nearest =
          std::min(tick.time - first, std::max(second, tick.time) - std::min(second, tick.time));
      ASSERT_EQ(tick.has_frame, nearest <= limit || tick.time >= second) << "round " << round;
      end = tick.time + tick.duration;
      number += tick.count;
    }
  }
}

TEST(FrameRate, HasNoTicksBeyondTheClocksRange) {
  for (const Fraction rate : {Fraction{30, 1}, Fraction{2147483647, 1}, Fraction{1, 2147483647}}) {
    FrameRate converter(rate);
    converter.hold(5);
    int ticks = 0;
    for (; converter.take_before(UINT64_MAX - 1, 1); ++ticks) ASSERT_LT(ticks, 10);
    EXPECT_GE(ticks, 1);
    converter.hold(UINT64_MAX - 1);
    while (converter.take_before(UINT64_MAX - 1, 1)) ASSERT_LT(++ticks, 20);
    while (converter.take_at_end(UINT64_MAX)) ASSERT_LT(++ticks, 40);
  }
}

TEST(FrameRate, EndsWithTheTickThatIsDue) {
  FrameRate converter({10, 1});
  EXPECT_FALSE(converter.take_at_end(UINT64_MAX)) << "nothing is held";
  converter.hold(0);
  EXPECT_TRUE(converter.take_at_end({})) << "tick 0 is not after the frame";
  EXPECT_FALSE(converter.take_at_end({}));
  EXPECT_TRUE(converter.take_at_end(150 * kMillisecond)) << "tick 1 is before the end";
  EXPECT_FALSE(converter.take_at_end(150 * kMillisecond));
  EXPECT_FALSE(converter.take_at_end(200 * kMillisecond)) << "the end itself is not before it";
}

TEST(FrameRate, StartsAgainAfterAReset) {
  FrameRate converter({10, 1});
  converter.hold(5);
  EXPECT_TRUE(converter.take_before(UINT64_MAX / 2));
  converter.reset();
  EXPECT_FALSE(converter.held());
  converter.hold(9);
  EXPECT_EQ(converter.next()->number, 0u);
  EXPECT_EQ(converter.next()->time, 9u);
}

TEST(FrameRate, IsReadAsAFraction) {
  EXPECT_FALSE(**parse_frame_rate("30000/1001") == (Fraction{30, 1}));
  EXPECT_EQ((*parse_frame_rate("30000/1001"))->denominator, 1001);
  EXPECT_EQ((*parse_frame_rate(" 7 / 2 "))->numerator, 7);
  EXPECT_FALSE(*parse_frame_rate(""));
}

TEST(FrameRate, ReportsThePlaceOfASyntaxError) {
  const struct {
    const char *text, *place;
  } cases[] = {{"x/1", "\n    x/1\n    ^"},
               {"30", "\n    30\n      ^"},
               {"30/", "\n    30/\n       ^"},
               {"30/x", "\n    30/x\n       ^"},
               {"0/1", "\n    0/1\n    ^"},
               {"30/0", "\n    30/0\n       ^"},
               {"-30/1", "\n    -30/1\n    ^"},
               {"30/1/2", "\n    30/1/2\n       ^"},
               {"2147483648/1", "\n    2147483648/1\n    ^"}};
  for (const auto& c : cases) {
    const auto rate = parse_frame_rate(c.text);
    ASSERT_FALSE(rate) << c.text;
    EXPECT_EQ(rate.error().code, Code::OPTION_SYNTAX);
    EXPECT_TRUE(rate.error().difference.ends_with(c.place)) << rate.error().difference;
    EXPECT_EQ(rate.error().fix, "framerate=30/1");
  }
}

}  // namespace frame_rate_test
}  // namespace weir
