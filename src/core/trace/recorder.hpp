// Recorder: a log of records for each thread. Writing takes no lock and copies 32 bytes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "core/trace/record.hpp"

namespace weir::trace {

// One thread appends; any thread may read the records appended so far.
class ThreadLog {
 public:
  explicit ThreadLog(size_t limit);
  ~ThreadLog();
  ThreadLog(const ThreadLog&) = delete;
  ThreadLog& operator=(const ThreadLog&) = delete;

  void append(const Record& record) noexcept {
    const size_t used = last_->used.load(std::memory_order_relaxed);
    if (used == kChunk || full_) {
      append_to_new_chunk(record);
      return;
    }
    last_->records[used] = record;
    last_->used.store(used + 1, std::memory_order_release);
  }
  std::vector<Record> records() const;
  uint64_t lost() const noexcept { return lost_.load(std::memory_order_relaxed); }

  std::string name;        // the system's name of the thread
  int64_t system_id = 0;   // the system's thread number
  std::thread::id thread;  // the writer

 private:
  static constexpr size_t kChunk = 512;  // 16 KB
  struct Chunk {
    std::array<Record, kChunk> records;
    std::atomic<size_t> used = 0;
    std::atomic<Chunk*> next = nullptr;
  };
  void append_to_new_chunk(const Record& record) noexcept;

  Chunk* const first_;
  Chunk* last_;
  size_t chunks_left_;
  bool full_ = false;
  std::atomic<uint64_t> lost_ = 0;
};

struct ThreadRecords {
  std::string name;
  int64_t system_id = 0;
  uint64_t lost = 0;  // records that arrived after the log was full
  std::vector<Record> records;
};

class Recorder {
 public:
  // `limit`: the most records per thread, 32 bytes each; rounded up to whole chunks.
  explicit Recorder(size_t limit);
  // The calling thread's log. Takes a lock only on the thread's first call.
  ThreadLog& log() {
    if (cached_.owner != id_) find_log();
    return *cached_.log;
  }
  // A copy of the records written so far.
  std::vector<ThreadRecords> threads() const;

 private:
  struct Cached {
    uint64_t owner = 0;
    ThreadLog* log = nullptr;
  };
  void find_log();

  static thread_local Cached cached_;
  const uint64_t id_;  // never reused, unlike an address
  const size_t limit_;
  mutable std::mutex mutex_;                      // guards logs_
  std::vector<std::unique_ptr<ThreadLog>> logs_;  // kept after their thread has ended
};

}  // namespace weir::trace
