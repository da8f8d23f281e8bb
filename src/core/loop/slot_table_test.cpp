// Slots: what ends a wait, what is passed on, and when slots are created and removed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/loop/slot_table.hpp"

#include <gtest/gtest.h>

#include <future>
#include <memory>

namespace weir::loop {
namespace slot_table_test {

using Frame = std::unique_ptr<int>;  // copying does not compile
using Table = SlotTable<Frame>;

Put put(Table::Writer& writer, int value) {
  Frame frame = std::make_unique<int>(value);
  return writer.put(frame);
}
// The value of a frame; -1 for anything else.
int value_of(const Taken<Frame>& taken) {
  return taken.outcome == Take::Frame ? **taken.frame : -1;
}

class SlotsByNumber : public ::testing::Test {
 protected:
  // Waits in a separate thread. The result does not depend on whether the wait has started when it
  // ends.
  auto taking() {
    return std::async(std::launch::async, [this] { return reader.take(); });
  }
  auto putting(int value) {
    return std::async(std::launch::async, [this, value] { return put(writer, value); });
  }

  Table table;
  Table::Writer writer{table};
  Table::Reader reader{table};
};

TEST_F(SlotsByNumber, PassesAFrame) {
  writer.attach(0);
  reader.attach(0);
  EXPECT_EQ(put(writer, 7), Put::Stored);
  EXPECT_EQ(value_of(reader.take()), 7);
}

TEST_F(SlotsByNumber, ExistsFromTheFirstEndToTheLast) {
  EXPECT_EQ(table.size(), 0u);
  reader.attach(3);
  EXPECT_EQ(table.size(), 1u);
  writer.attach(3);
  EXPECT_EQ(table.size(), 1u);
  reader.detach();
  EXPECT_EQ(table.size(), 1u);
  writer.detach();
  EXPECT_EQ(table.size(), 0u);
}

// An end that waits alone is reported after a delay, once per slot, and keeps waiting.
TEST_F(SlotsByNumber, ReportsAnEndWithoutAPeer) {
  std::promise<uint32_t> reported;
  Table::Reader lonely(table, {[&](uint32_t slot) { reported.set_value(slot); }, {}});
  lonely.attach(5);
  auto taken = std::async(std::launch::async, [&] { return lonely.take(); });
  EXPECT_EQ(reported.get_future().get(), 5u);
  writer.attach(5);
  EXPECT_EQ(put(writer, 8), Put::Stored);
  EXPECT_EQ(value_of(taken.get()), 8) << "a second report would have thrown";
  writer.detach();
  lonely.interrupt();
  EXPECT_EQ(lonely.take().outcome, Take::Interrupted);
}

TEST_F(SlotsByNumber, ReportsAWriterWithoutAReader) {
  std::promise<uint32_t> reported;
  Table::Writer lonely(table, {[&](uint32_t slot) { reported.set_value(slot); }, {}});
  lonely.attach(2);
  EXPECT_EQ(put(lonely, 1), Put::Stored) << "the first has its place";
  auto second = std::async(std::launch::async, [&] { return put(lonely, 2); });
  EXPECT_EQ(reported.get_future().get(), 2u);
  reader.attach(2);
  EXPECT_EQ(value_of(reader.take()), 1);
  EXPECT_EQ(second.get(), Put::Stored);
}

TEST_F(SlotsByNumber, DoesNotReportAnEndWithAPeer) {
  Table::Reader reader_in_company(table, {[](uint32_t) { ADD_FAILURE() << "not alone"; }, {}});
  writer.attach(0);
  reader_in_company.attach(0);
  auto taken = std::async(std::launch::async, [&] { return reader_in_company.take(); });
  EXPECT_EQ(taken.wait_for(std::chrono::milliseconds(20)), std::future_status::timeout);
  put(writer, 3);
  EXPECT_EQ(value_of(taken.get()), 3);
}

TEST_F(SlotsByNumber, KeepsAFrameForAReaderThatComesLater) {
  writer.attach(0);
  EXPECT_EQ(put(writer, 1), Put::Stored);
  writer.end();
  reader.attach(0);
  EXPECT_EQ(value_of(reader.take()), 1);
  EXPECT_EQ(reader.take().outcome, Take::Ended) << "the end follows what was written";
}

TEST_F(SlotsByNumber, ReturnsTheUnreadFrameWhenItIsDestroyed) {
  writer.attach(0);
  put(writer, 5);
  const auto left = writer.detach();
  ASSERT_TRUE(left);
  EXPECT_EQ(**left, 5);
  writer.attach(0);
  reader.attach(0);
  put(writer, 6);
  EXPECT_FALSE(writer.detach()) << "a reader is still there";
  EXPECT_EQ(**reader.detach(), 6);
}

TEST_F(SlotsByNumber, KeepsSlotsApart) {
  Table::Writer other(table);
  writer.attach(1);
  other.attach(2);
  reader.attach(2);
  put(writer, 1);
  put(other, 2);
  EXPECT_EQ(value_of(reader.take()), 2);
}

TEST_F(SlotsByNumber, LetsAWriterWaitUntilTheFrameIsTaken) {
  writer.attach(0);
  reader.attach(0);
  put(writer, 1);
  auto second = putting(2);
  EXPECT_EQ(value_of(reader.take()), 1);
  EXPECT_EQ(second.get(), Put::Stored);
  EXPECT_EQ(value_of(reader.take()), 2);
}

TEST_F(SlotsByNumber, LetsAReaderWaitForAFrame) {
  reader.attach(0);
  auto taken = taking();
  writer.attach(0);
  put(writer, 4);
  EXPECT_EQ(value_of(taken.get()), 4);
}

TEST_F(SlotsByNumber, TheEndOfTheWriterWakesTheReader) {
  reader.attach(0);
  writer.attach(0);
  auto taken = taking();
  writer.end();
  EXPECT_EQ(taken.get().outcome, Take::Ended);
}

TEST_F(SlotsByNumber, TheEndOfTheReaderWakesTheWriterAndDropsItsFrame) {
  writer.attach(0);
  reader.attach(0);
  put(writer, 1);
  auto second = putting(2);
  reader.end();
  EXPECT_EQ(second.get(), Put::Unwanted);
  reader.begin();
  EXPECT_EQ(value_of(reader.take()), 1);
}

TEST_F(SlotsByNumber, ARejectedFrameStaysWithTheWriter) {
  writer.attach(0);
  reader.attach(0);
  reader.end();
  Frame frame = std::make_unique<int>(3);
  EXPECT_EQ(writer.put(frame), Put::Unwanted);
  ASSERT_TRUE(frame);
  EXPECT_EQ(*frame, 3);
}

TEST_F(SlotsByNumber, AnInterruptWakesEitherAndLastsUntilResume) {
  writer.attach(0);
  put(writer, 1);
  auto second = putting(2);
  writer.interrupt();
  EXPECT_EQ(second.get(), Put::Interrupted);
  EXPECT_EQ(put(writer, 2), Put::Interrupted);
  writer.resume();
  reader.attach(0);
  EXPECT_EQ(value_of(reader.take()), 1);
  EXPECT_EQ(put(writer, 2), Put::Stored);
  reader.take();

  auto taken = taking();
  reader.interrupt();
  EXPECT_EQ(taken.get().outcome, Take::Interrupted);
  EXPECT_EQ(reader.take().outcome, Take::Interrupted);
  reader.resume();
  put(writer, 3);
  EXPECT_EQ(value_of(reader.take()), 3);
}

TEST_F(SlotsByNumber, DetachingWakesEither) {
  reader.attach(0);
  auto taken = taking();
  reader.detach();
  EXPECT_EQ(taken.get().outcome, Take::Interrupted);
  writer.attach(0);
  put(writer, 1);
  auto second = putting(2);
  writer.detach();
  EXPECT_EQ(second.get(), Put::Interrupted);
  EXPECT_EQ(put(writer, 3), Put::Interrupted) << "detached";
}

TEST_F(SlotsByNumber, AWaitContinuesInTheNewSlot) {
  Table::Writer there(table);
  there.attach(9);
  reader.attach(0);
  auto taken = taking();
  EXPECT_FALSE(reader.move(9));
  put(there, 8);
  EXPECT_EQ(value_of(taken.get()), 8);
  EXPECT_EQ(table.size(), 1u) << "slot 0 had no user left";

  writer.attach(1);
  put(writer, 1);
  auto second = putting(2);
  const auto left = writer.move(9);
  ASSERT_TRUE(left) << "the frame of the slot that is gone";
  EXPECT_EQ(**left, 1);
  EXPECT_EQ(second.get(), Put::Stored);
  EXPECT_EQ(value_of(reader.take()), 2);
}

TEST_F(SlotsByNumber, MovesOnlyWhoIsAttached) {
  EXPECT_FALSE(reader.move(1));
  EXPECT_EQ(table.size(), 0u);
  EXPECT_EQ(reader.take().outcome, Take::Interrupted);
}

TEST_F(SlotsByNumber, AFlushEmptiesTheSlotAndRestartsTheLoopOnce) {
  writer.attach(0);
  reader.attach(0);
  put(writer, 1);
  const auto lost = writer.flush();
  ASSERT_TRUE(lost);
  EXPECT_EQ(**lost, 1);
  EXPECT_EQ(reader.take().outcome, Take::Restarted);
  auto taken = taking();
  put(writer, 2);
  EXPECT_EQ(value_of(taken.get()), 2);
}

TEST_F(SlotsByNumber, AFlushWakesTheReader) {
  writer.attach(0);
  reader.attach(0);
  auto taken = taking();
  EXPECT_FALSE(writer.flush());
  EXPECT_EQ(taken.get().outcome, Take::Restarted);
}

TEST_F(SlotsByNumber, ALoopThatKeepsItsFrameIsNotRestarted) {
  writer.attach(0);
  reader.attach(0);
  writer.flush();
  put(writer, 3);
  EXPECT_EQ(value_of(reader.take()), 3);
  writer.end();
  EXPECT_EQ(reader.take().outcome, Take::Ended) << "not Restarted";
}

TEST_F(SlotsByNumber, AFlushTakesTheEndBack) {
  writer.attach(0);
  reader.attach(0);
  writer.end();
  writer.flush();
  EXPECT_EQ(reader.take().outcome, Take::Restarted);
  EXPECT_EQ(put(writer, 1), Put::Stored);
  EXPECT_EQ(value_of(reader.take()), 1);
}

TEST_F(SlotsByNumber, ARestartedReaderIgnoresAnEarlierFlush) {
  writer.attach(0);
  writer.flush();
  reader.attach(0);
  reader.begin_again();
  writer.end();
  EXPECT_EQ(reader.take().outcome, Take::Ended);
}

TEST_F(SlotsByNumber, EndsWhenTheLastOfSeveralWritersHasEnded) {
  Table::Writer second(table);
  writer.attach(0);
  second.attach(0);
  reader.attach(0);
  writer.end();
  writer.end();
  put(second, 2);
  EXPECT_EQ(value_of(reader.take()), 2);
  auto taken = taking();
  second.detach();
  EXPECT_EQ(taken.get().outcome, Take::Ended) << "one has ended, the other has gone";
}

TEST_F(SlotsByNumber, AWriterThatLeavesWithoutEosEndsNothing) {
  reader.attach(0);
  writer.attach(0);
  auto taken = taking();
  writer.detach();
  writer.attach(0);
  put(writer, 6);
  EXPECT_EQ(value_of(taken.get()), 6);
}

TEST_F(SlotsByNumber, TheEndOutlivesTheWriterButNotItsSuccessor) {
  reader.attach(0);
  writer.attach(0);
  writer.end();
  writer.detach();
  EXPECT_EQ(reader.take().outcome, Take::Ended);
  writer.attach(0);
  put(writer, 1);
  EXPECT_EQ(value_of(reader.take()), 1);
}

TEST_F(SlotsByNumber, ReportsWhetherAnotherReaderExists) {
  Table::Reader other(table);
  reader.attach(2);
  writer.attach(2);
  EXPECT_FALSE(reader.shares_slot()) << "a writer is no reader";
  other.attach(2);
  EXPECT_TRUE(reader.shares_slot());
  other.end();
  EXPECT_FALSE(reader.shares_slot()) << "it takes nothing any more";
  other.attach(2);
  reader.move(3);
  EXPECT_FALSE(other.shares_slot());
  reader.move(2);
  EXPECT_TRUE(other.shares_slot());
  reader.detach();
  EXPECT_FALSE(other.shares_slot());
  EXPECT_FALSE(reader.shares_slot());
}

TEST_F(SlotsByNumber, GivesEachFrameToOneOfSeveralReaders) {
  Table::Reader second(table);
  writer.attach(0);
  reader.attach(0);
  second.attach(0);
  auto one = taking();
  auto other = std::async(std::launch::async, [&] { return second.take(); });
  put(writer, 1);
  put(writer, 2);
  EXPECT_EQ(value_of(one.get()) + value_of(other.get()), 3);
}

}  // namespace slot_table_test
}  // namespace weir::loop
