// Runs random streams through the policies and compares with plain models of
// docs/compatibility/routing.md 6.1.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <random>

#include "core/sync/input_queues.hpp"

namespace weir::sync {
namespace streams_test {

using Streams = std::vector<std::vector<Stamp>>;  // one list for each pad
struct Row {
  Time time;
  std::vector<int> frames;  // the frame index of each pad
  bool operator==(const Row&) const = default;
};
using Rows = std::vector<Row>;

void PrintTo(const Row& row, std::ostream* out) {
  *out << row.time << ":";
  for (const int f : row.frames) *out << " " << f;
}

// The models know all frames of all pads from the start and walk them by index.
struct Model {
  explicit Model(const Streams& streams)
      : in(streams), next(streams.size(), 0), kept(streams.size(), -1) {}
  const Streams& in;
  std::vector<size_t> next;
  std::vector<int> kept;

  bool over() const {
    for (size_t p = 0; p < in.size(); ++p)
      if (next[p] == in[p].size()) return true;
    return false;
  }
  bool ended(size_t p) const { return next[p] == in[p].size(); }
  Stamp head(size_t p) const { return in[p][next[p]]; }
  Stamp last(size_t p) const { return kept[p] < 0 ? Stamp{} : in[p][static_cast<size_t>(kept[p])]; }
  int pop(size_t p) { return kept[p] = static_cast<int>(next[p]++); }
  Time highest(Time current) const {
    for (size_t p = 0; p < in.size(); ++p) current = std::max(current, head(p).value_or(0));
    return current;
  }
  void skip_before(Time current) {
    for (size_t p = 0; p < in.size(); ++p)
      while (!ended(p) && head(p) && *head(p) < current) pop(p);
  }
};

Rows model_of_no_sync(const Streams& in) {
  Rows out;
  Time current = 0;
  for (size_t i = 0;; ++i) {
    for (const auto& pad : in) {
      if (i == pad.size()) return out;
      current = std::max(current, pad[i].value_or(0));
    }
    out.push_back({current, std::vector<int>(in.size(), static_cast<int>(i))});
  }
}

Rows model_of_slowest(const Streams& in) {
  Model m(in);
  Rows out;
  for (Time current = 0; !m.over();) {
    current = m.highest(current);
    m.skip_before(current);
    Row row{current, {}};
    for (size_t p = 0; p < in.size(); ++p) {
      const Stamp head = m.ended(p) ? Stamp{} : m.head(p), last = m.last(p);
      const bool keep =
          m.ended(p) || (head && last && distance(current, *last) < distance(current, *head));
      row.frames.push_back(keep ? m.kept[p] : m.pop(p));
    }
    out.push_back(row);
  }
  return out;
}

Rows model_of_base_pad(const Streams& in, const Base& base) {
  Model m(in);
  Rows out;
  for (Time current = 0; !m.over();) {
    current = m.head(base.pad).value_or(current);
    const Stamp first = m.head(base.pad), before = m.last(base.pad);
    Time window = 0;
    if (first && before && *first != *before)
      window = std::min(base.duration, distance(*first, *before) - 1);
    m.skip_before(current);
    Row row{current, {}};
    for (size_t p = 0; p < in.size(); ++p) {
      const bool keep =
          m.ended(p) || (m.head(p) && m.kept[p] >= 0 && distance(current, *m.head(p)) > window);
      row.frames.push_back(keep ? m.kept[p] : m.pop(p));
    }
    out.push_back(row);
  }
  return out;
}

// Literal version of docs/compatibility/routing.md 6.1, step by step in pad order; a round that
// returns early has popped from the pads before the late one. Ends when a round starts and a pad
// has no head.
Rows literal_slowest(const Streams& in) {
  Model m(in);
  Rows out;
  Time current = 0;
  bool need_set = true;
  while (!need_set || !m.over()) {
    if (need_set) current = m.highest(current);
    need_set = false;
    Row row{current, {}};
    bool returned = false;
    for (size_t p = 0; p < in.size() && !returned; ++p) {
      if (m.ended(p)) {
        row.frames.push_back(m.kept[p]);
        continue;
      }
      const Time head = *m.head(p);
      if (head < current) {
        m.pop(p);
        returned = true;
      } else if (m.last(p) && distance(current, *m.last(p)) < distance(current, head)) {
        row.frames.push_back(m.kept[p]);
      } else {
        row.frames.push_back(m.pop(p));
      }
    }
    if (returned) continue;
    out.push_back(row);
    need_set = true;
  }
  return out;
}

struct Played {
  Rows rows;
  LedgerSnapshot ledger;
};

// Feeds the streams in random interleaving; `gaps` inserts truthful GAPs.
Played play(const Options& options, const Streams& in, unsigned seed, bool gaps = false) {
  std::mt19937 random(seed);
  Ledger ledger;
  InputQueues<int> queues(&ledger);
  std::vector<size_t> next(in.size(), 0);
  for (size_t p = 0; p < in.size(); ++p) queues.add(p);
  Played out;
  for (bool over = false; !over;) {
    const size_t p = random() % in.size();
    auto* queue = queues.find(p);
    if (queue->head || queue->ended) continue;
    if (next[p] == in[p].size()) {
      queues.end(p);
    } else if (gaps && in[p][next[p]] && random() % 2 == 0) {
      queues.gap(p, *in[p][next[p]] - random() % (*in[p][next[p]] + 1));
    } else {
      ledger.received();
      queues.put(p, static_cast<int>(next[p]), in[p][next[p]], OnBackwardsTime::Pass);
      ++next[p];
    }
    while (true) {
      const auto step = queues.step(options);
      EXPECT_TRUE(step);
      over = step->outcome == Outcome::End;
      if (step->outcome == Outcome::Emit)
        out.rows.push_back({step->emission.time, step->emission.frames});
      if (over || (step->outcome == Outcome::Wait && !step->changed)) break;
    }
  }
  out.ledger = ledger.snapshot();
  return out;
}

struct Shape {
  bool missing_stamps = false, equal_stamps = false;
};
Streams random_streams(std::mt19937& random, const Shape& shape) {
  Streams out(1 + random() % 4);
  for (auto& pad : out) {
    const Time interval = 1 + random() % 40;
    Time time = random() % 3 == 0 ? random() % 300 : random() % 20;  // some start late
    const size_t count = random() % 40;                              // some end early
    for (size_t i = 0; i < count; ++i) {
      pad.emplace_back(time);
      if (shape.missing_stamps && random() % 5 == 0) pad.back().reset();
      const bool equal = shape.equal_stamps && random() % 4 == 0;
      const Time lost = random() % 8 == 0 ? interval * (random() % 5) : 0;
      if (!equal) time += std::max<Time>(1, interval - interval / 4 + random() % 3) + lost;
    }
  }
  return out;
}

Rows model_of(const Options& options, const Streams& in) {
  if (options.mode == Mode::NoSync) return model_of_no_sync(in);
  if (options.mode == Mode::Slowest) return model_of_slowest(in);
  return model_of_base_pad(in, options.base);
}

void expect_sums(const Played& run, const Streams& in) {
  EXPECT_EQ(run.ledger.held(), 0u);
  uint64_t frames = 0;
  for (const auto& pad : in) frames += pad.size();
  EXPECT_LE(run.ledger.received, frames);
  std::vector<std::vector<bool>> used;
  for (const auto& pad : in) used.emplace_back(pad.size(), false);
  for (const Row& row : run.rows)
    for (size_t p = 0; p < row.frames.size(); ++p)
      used[p][static_cast<size_t>(row.frames[p])] = true;
  uint64_t consumed = 0;
  for (const auto& pad : used)
    consumed += static_cast<uint64_t>(std::count(pad.begin(), pad.end(), true));
  EXPECT_EQ(run.ledger.consumed, consumed);
}

TEST(SyncStreams, AgreeWithTheModelsInAnyInterleaving) {
  std::mt19937 random(1);
  for (unsigned round = 0; round < 600; ++round) {
    const Streams in = random_streams(random, {round % 3 == 1, round % 3 == 2});
    const Base base{random() % in.size(), random() % 2 == 0 ? kBaseDuration : random() % 50};
    for (const Mode mode : {Mode::NoSync, Mode::Slowest, Mode::BasePad}) {
      SCOPED_TRACE(std::string(to_string(mode)) + ", round " + std::to_string(round));
      const Played got = play({mode, base, {}}, in, round);
      EXPECT_EQ(got.rows, model_of({mode, base, {}}, in));
      expect_sums(got, in);
      if (HasFailure()) return;
    }
  }
}

TEST(SyncStreams, GapsChangeWhenButNeverWhat) {
  std::mt19937 random(2);
  for (unsigned round = 0; round < 400; ++round) {
    const Streams in = random_streams(random, {});
    const Base base{random() % in.size(), random() % 2 == 0 ? kBaseDuration : random() % 50};
    for (const Mode mode : {Mode::NoSync, Mode::Slowest, Mode::BasePad}) {
      SCOPED_TRACE(std::string(to_string(mode)) + ", round " + std::to_string(round));
      const Played got = play({mode, base, {}}, in, round, true);
      EXPECT_EQ(got.rows, model_of({mode, base, {}}, in));
      expect_sums(got, in);
      if (HasFailure()) return;
    }
  }
}

TEST(SyncStreams, SlowestPairsAsTheLiteralStepsDo) {
  std::mt19937 random(3);
  size_t rows = 0;
  for (unsigned round = 0; round < 400; ++round) {
    const Streams in = random_streams(random, {});
    const Rows literal = literal_slowest(in), got = play({Mode::Slowest, {}, {}}, in, round).rows;
    ASSERT_GE(got.size(), literal.size()) << round;
    EXPECT_EQ(Rows(got.begin(), got.begin() + static_cast<std::ptrdiff_t>(literal.size())), literal)
        << round;
    rows += literal.size();
  }
  EXPECT_GT(rows, 1000u);
}

TEST(SyncStreams, RefreshEmitsForEachFrameOnceAllWereFed) {
  std::mt19937 random(4);
  for (unsigned round = 0; round < 300; ++round) {
    const size_t pads = 1 + random() % 4;
    Ledger ledger;
    InputQueues<int> queues(&ledger);
    for (size_t p = 0; p < pads; ++p) queues.add(p);
    std::vector<int> last(pads, -1), expected;
    Time highest = 0;
    for (int frame = 0; frame < 100; ++frame) {
      const size_t p = random() % pads;
      if (queues.find(p)->head) continue;
      const Time time = random() % 1000;
      ledger.received();
      queues.put(p, frame, time, OnBackwardsTime::Pass);
      // Times go back at random here. When all pads have gone back, `current` starts again; the
      // model omits that because it compares frames.
      last[p] = frame;
      highest = std::max(highest, time);
      const auto step = queues.step({Mode::Refresh, {}, {}});
      ASSERT_TRUE(step);
      if (std::count(last.begin(), last.end(), -1) > 0) {
        EXPECT_EQ(step->outcome, Outcome::Wait);
        continue;
      }
      EXPECT_EQ(step->outcome, Outcome::Emit);
      EXPECT_EQ(step->emission.frames, last);
      EXPECT_LE(step->emission.time, highest);
    }
  }
}

TEST(SyncStreams, InfraRed30GoesWithColour29) {
  for (const bool swapped : {false, true}) {
    Streams in{{14, 30, 49}, {29}};
    if (swapped) std::swap(in[0], in[1]);
    for (unsigned seed = 0; seed < 20; ++seed) {
      const Rows rows = play({Mode::Slowest, {}, {}}, in, seed).rows;
      ASSERT_EQ(rows.size(), 1u);
      EXPECT_EQ(rows[0].time, 29u);
      EXPECT_EQ(rows[0].frames, swapped ? (std::vector{0, 1}) : (std::vector{1, 0}));
    }
  }
}

Streams at_rates(std::vector<std::pair<size_t, Time>> frames_and_rates) {
  Streams out;
  for (const auto& [frames, rate] : frames_and_rates) {
    auto& pad = out.emplace_back();
    for (Time i = 0; i < frames; ++i) pad.emplace_back(i * 1'000'000'000 / rate);
  }
  return out;
}

// Examples of docs/compatibility/routing.md 6.1 and docs/compatibility/programs.md 11.2.
TEST(SyncStreams, TheLastFrameIsPairedWithOneOfAPadThatHasEnded) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Rows slowest = play({Mode::Slowest, {}, {}}, at_rates({{30, 30}, {13, 12}}), seed).rows;
    ASSERT_EQ(slowest.size(), 13u);
    EXPECT_EQ(slowest.back(), (Row{1'000'000'000, {29, 12}}));
    const Rows base = play({Mode::BasePad, {1, 0}, {}}, at_rates({{20, 10}, {50, 25}}), seed).rows;
    ASSERT_EQ(base.size(), 49u);
    EXPECT_EQ(base.back(), (Row{1'920'000'000, {19, 48}}));
  }
}

TEST(SyncStreams, APadWithoutFramesEndsTheStreamInARepeatedRoundToo) {
  for (unsigned seed = 0; seed < 20; ++seed)
    for (const Mode mode : {Mode::NoSync, Mode::Slowest, Mode::BasePad})
      EXPECT_EQ(play({mode, {}, {}}, {{10, 20}, {}}, seed).rows, Rows{}) << to_string(mode);
}

TEST(SyncStreams, AStreamThatRestartsOnAllPadsIsPairedAgain) {
  Streams in(2);
  for (Time loop = 0; loop < 3; ++loop)
    for (Time t = 0; t < 10; ++t) {
      in[0].emplace_back(t * 10);
      in[1].emplace_back(t * 10 + 2);
    }
  for (const Mode mode : {Mode::NoSync, Mode::Slowest, Mode::BasePad})
    for (unsigned seed = 0; seed < 20; ++seed) {
      SCOPED_TRACE(std::string(to_string(mode)) + " " + std::to_string(seed));
      const Played got = play({mode, {}, {}}, in, seed);
      EXPECT_GE(got.rows.size(), 24u);
      for (const Row& row : got.rows) EXPECT_EQ(row.frames[0] / 10, row.frames[1] / 10);
      EXPECT_EQ(got.ledger.held(), 0u);
      EXPECT_LT(got.rows.back().time, 100u);
    }
}

TEST(SyncStreams, OnePadThatRestartsCatchesUp) {
  Streams in(2);
  for (Time t = 0; t < 20; ++t) in[0].emplace_back(t % 10 * 10);
  for (Time t = 0; t < 40; ++t) in[1].emplace_back(t * 10);
  const Played got = play({Mode::Slowest, {}, {}}, in, 1);
  EXPECT_GE(got.rows.size(), 10u);
  EXPECT_EQ(got.ledger.held(), 0u);
}

TEST(SyncStreams, DropRemovesFramesThatGoBackwards) {
  Ledger ledger;
  InputQueues<int> queues(&ledger);
  queues.add(1);
  std::vector<int> got;
  int frame = 0;
  for (const Time time : {10, 30, 20, 30, 40}) {
    ledger.received();
    if (!queues.put(1, frame++, time, OnBackwardsTime::Drop)) continue;
    got.push_back(queues.step({Mode::Slowest, {}, {}})->emission.frames[0]);
  }
  EXPECT_EQ(got, (std::vector{0, 1, 3, 4}));
  EXPECT_EQ(queues.counts().backwards, 1u);
  EXPECT_EQ(ledger.snapshot().dropped[static_cast<size_t>(DropReason::Time)], 1u);
  EXPECT_EQ(ledger.snapshot().held(), 0u);
}

TEST(SyncStreams, AMissingBasePadIsReported) {
  Ledger ledger;
  InputQueues<int> queues(&ledger);
  queues.add(1);
  queues.add(2);
  const auto step = queues.step({Mode::BasePad, {2, 5}, {}});
  ASSERT_FALSE(step);
  EXPECT_EQ(step.error().code, Code::OPTION_VALUE);
  EXPECT_EQ(step.error().offered, "pad 2 of 2");
}

// A waiting thread may notice only after the time-out that its frame was taken and no pad has one
// left.
TEST(MaxWait, NothingIsSentTwiceWhenAllPadsBecomeMissing) {
  using namespace std::chrono_literals;
  for (const Mode mode : {Mode::NoSync, Mode::Slowest, Mode::BasePad, Mode::Refresh}) {
    Ledger ledger;
    InputQueues<int> queues(&ledger);
    for (const QueueId id : {1u, 2u}) {
      queues.add(id);
      queues.put(id, 1, 10, OnBackwardsTime::Pass);
    }
    const Options options{mode, {}, {}};
    EXPECT_EQ(queues.step(options)->outcome, Outcome::Emit) << to_string(mode);
    EXPECT_TRUE(queues.mark_missing(Clock::now(), 1ms, Clock::now() + 1h)) << to_string(mode);
    const auto step = queues.step(options);
    EXPECT_EQ(step->outcome, Outcome::Wait) << to_string(mode);
    EXPECT_FALSE(step->changed) << to_string(mode);
    queues.put(1, 2, 20, OnBackwardsTime::Pass);
    EXPECT_EQ(queues.step(options)->emission.frames, (std::vector<int>{2, 1})) << to_string(mode);
  }
}

}  // namespace streams_test
}  // namespace weir::sync
