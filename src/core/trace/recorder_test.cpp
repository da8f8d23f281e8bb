// Thread logs are complete, ordered, bounded, and readable during writing.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/recorder.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "core/trace/trace_test_support.hpp"

namespace weir::trace {
namespace recorder_test {

TEST(TraceRecorder, KeepsEachThreadsRecordsInOrder) {
  constexpr int64_t kRecords = 20000;
  Recorder recorder(100000);
  std::vector<std::thread> threads;
  for (int t = 0; t < 3; ++t)
    threads.emplace_back([&recorder] {
      for (int64_t i = 0; i < kRecords; ++i) recorder.log().append(push(i, 12));
    });
  for (auto& thread : threads) thread.join();
  const auto logs = recorder.threads();
  ASSERT_EQ(logs.size(), 3u);
  for (const auto& log : logs) {
    ASSERT_EQ(log.records.size(), static_cast<size_t>(kRecords));
    for (int64_t i = 0; i < kRecords; ++i) ASSERT_EQ(log.records[static_cast<size_t>(i)].time, i);
    EXPECT_EQ(log.lost, 0u);
    EXPECT_NE(log.system_id, logs[&log == &logs[0] ? 1 : 0].system_id);
  }
}

TEST(TraceRecorder, CanBeReadWhileItIsWritten) {
  constexpr size_t kRecords = 50000;
  Recorder recorder(kRecords);
  const std::jthread writer([&recorder] {
    for (size_t i = 0; i < kRecords; ++i) recorder.log().append(push(static_cast<int64_t>(i), 12));
  });
  size_t seen = 0;
  while (seen < kRecords) {
    const auto logs = recorder.threads();
    if (logs.empty()) continue;
    ASSERT_GE(logs[0].records.size(), seen);
    seen = logs[0].records.size();
    if (seen > 0) {
      ASSERT_EQ(logs[0].records.back().time, static_cast<int64_t>(seen) - 1);
    }
  }
}

TEST(TraceRecorder, CountsRecordsLostWhenTheLogWasFull) {
  Recorder recorder(1);  // rounded up to a chunk of 512
  for (int64_t i = 0; i < 5000; ++i) recorder.log().append(push(i, 12));
  const auto logs = recorder.threads();
  EXPECT_EQ(logs[0].records.size(), 512u);
  EXPECT_EQ(logs[0].lost, 4488u);
  EXPECT_EQ(logs[0].records.back().time, 511);
}

TEST(TraceRecorder, RecordersOfOneThreadDoNotMix) {
  Recorder a(100);
  auto b = std::make_unique<Recorder>(100);
  a.log().append(push(1, 12));
  b->log().append(push(2, 12));
  a.log().append(push(3, 12));
  b.reset();  // the next recorder may get its address
  Recorder c(100);
  c.log().append(push(4, 12));
  EXPECT_EQ(a.threads()[0].records.size(), 2u);
  EXPECT_EQ(c.threads()[0].records.size(), 1u);
}

}  // namespace recorder_test
}  // namespace weir::trace
