// Stress test: threads lose and duplicate no frame, and no order of events leaves a wait hanging.
// Also runs under ThreadSanitizer.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <thread>
#include <vector>

#include "becomes.hpp"
#include "core/loop/slot_table.hpp"

namespace weir::loop {
namespace slot_table_stress_test {

using Table = SlotTable<std::unique_ptr<int>>;

Put put(Table::Writer& writer, int value) {
  auto frame = std::make_unique<int>(value);
  return writer.put(frame);
}

// Each thread passes a number through its own slot and adds 1 per round, undisturbed by the others.
TEST(SlotTableStress, SeveralLoopsRunIndependently) {
  constexpr int kLoops = 4, kRounds = 2000;
  Table table;
  std::vector<std::thread> threads;
  std::vector<int> results(kLoops, 0);
  for (int i = 0; i < kLoops; ++i) {
    threads.emplace_back([&, i] {
      Table::Writer writer(table);
      Table::Reader reader(table);
      reader.attach(static_cast<uint32_t>(i));
      writer.attach(static_cast<uint32_t>(i));
      int value = 0;
      for (int round = 0; round < kRounds; ++round) {
        ASSERT_EQ(put(writer, value + 1), Put::Stored);
        value = **reader.take().frame;
      }
      results[static_cast<size_t>(i)] = value;
    });
  }
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(results, std::vector<int>(kLoops, kRounds));
  EXPECT_EQ(table.size(), 0u);
}

TEST(SlotTableStress, ManyWritersAndReadersKeepEveryFrameOnce) {
  constexpr int kWriters = 3, kFrames = 2000;
  Table table;
  std::vector<std::atomic<int>> seen(kWriters * kFrames);
  std::vector<std::thread> threads;
  std::atomic<int> attached{0};
  for (int w = 0; w < kWriters; ++w) {
    threads.emplace_back([&, w] {
      Table::Writer writer(table);
      writer.attach(0);
      ++attached;
      EXPECT_TRUE(becomes_true([&] { return attached == kWriters; }, "all writers at the slot"));
      for (int i = 0; i < kFrames; ++i) ASSERT_EQ(put(writer, w * kFrames + i), Put::Stored);
      writer.end();
      EXPECT_TRUE(becomes_true([&] { return attached == 0; }, "the end of all readers"));
    });
    threads.emplace_back([&] {
      Table::Reader reader(table);
      reader.attach(0);
      for (auto taken = reader.take(); taken.outcome == Take::Frame; taken = reader.take())
        ++seen[static_cast<size_t>(**taken.frame)];
      --attached;
    });
  }
  for (auto& thread : threads) thread.join();
  for (const auto& count : seen) ASSERT_EQ(count, 1);
  EXPECT_EQ(table.size(), 0u);
}

// A third thread does random things to both ends; finally everything is ended. Each stored frame
// was taken or returned by a flush or by the removal of its slot.
TEST(SlotTableStress, NoOrderOfEventsLeavesAWaiterBlocked) {
  for (const uint32_t seed : {1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u}) {
    Table table;
    Table::Writer writer(table);
    Table::Reader reader(table);
    writer.attach(0);
    reader.attach(0);
    std::atomic<bool> over{false};
    std::atomic<int> stored{0}, taken{0}, lost{0};
    std::thread writing([&] {
      while (!over) stored += put(writer, 1) == Put::Stored;
    });
    std::thread reading([&] {
      while (!over) taken += reader.take().outcome == Take::Frame;
    });
    std::mt19937 random(seed);
    const auto count = [&](const auto& left) { lost += left.has_value(); };
    for (int i = 0; i < 3000; ++i) {
      const auto slot = static_cast<uint32_t>(random() % 3);
      switch (random() % 12) {
        case 0:
          count(writer.move(slot));
          break;
        case 1:
          count(reader.move(slot));
          break;
        case 2:
          count(writer.flush());
          break;
        case 3:
          writer.end();
          break;
        case 4:
          reader.end();
          break;
        case 5:
          reader.begin();
          break;
        case 6:
          writer.interrupt();
          break;
        case 7:
          reader.interrupt();
          break;
        case 8:
          count(writer.detach());
          writer.attach(slot);
          break;
        case 9:
          count(reader.detach());
          reader.attach(slot);
          break;
        default:
          writer.resume();
          reader.resume();
      }
    }
    over = true;
    writer.interrupt();
    reader.interrupt();
    writing.join();
    reading.join();
    count(writer.detach());
    count(reader.detach());
    EXPECT_EQ(stored, taken + lost) << "seed " << seed;
    EXPECT_EQ(table.size(), 0u);
  }
}

}  // namespace slot_table_stress_test
}  // namespace weir::loop
