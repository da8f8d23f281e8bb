// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/trace/recorder.hpp"

#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <new>

namespace weir::trace {

ThreadLog::ThreadLog(size_t limit)
    : first_(new Chunk),
      last_(first_),
      chunks_left_(std::max<size_t>((limit + kChunk - 1) / kChunk, 1) - 1) {}

ThreadLog::~ThreadLog() {
  for (std::unique_ptr<Chunk> chunk(first_); chunk;)
    chunk.reset(chunk->next.load(std::memory_order_relaxed));
}

void ThreadLog::append_to_new_chunk(const Record& record) noexcept {
  Chunk* chunk = full_ || chunks_left_ == 0 ? nullptr : new (std::nothrow) Chunk;
  if (!chunk) {
    full_ = true;
    lost_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  --chunks_left_;
  chunk->records[0] = record;
  chunk->used.store(1, std::memory_order_relaxed);
  last_->next.store(chunk, std::memory_order_release);
  last_ = chunk;
}

std::vector<Record> ThreadLog::records() const {
  std::vector<Record> out;
  for (const Chunk* chunk = first_; chunk;) {
    // Read before the number of records, because only a chunk with a successor is full. In the
    // opposite order the writer could fill the chunk in between, and records would be missing in
    // the middle.
    const Chunk* next = chunk->next.load(std::memory_order_acquire);
    const size_t used = chunk->used.load(std::memory_order_acquire);
    out.insert(out.end(), chunk->records.begin(),
               chunk->records.begin() + static_cast<std::ptrdiff_t>(used));
    chunk = next;
  }
  return out;
}

thread_local Recorder::Cached Recorder::cached_;

namespace {

uint64_t next_id() {
  static std::atomic<uint64_t> last = 0;
  return ++last;
}

}  // namespace

Recorder::Recorder(size_t limit) : id_(next_id()), limit_(limit) {}

void Recorder::find_log() {
  std::lock_guard lock(mutex_);
  const auto self = std::this_thread::get_id();
  const int64_t system_id = gettid();
  // A std::thread::id may be reused after its thread has ended, so the system's number must match
  // too.
  auto found = std::find_if(logs_.begin(), logs_.end(), [&](const auto& log) {
    return log->thread == self && log->system_id == system_id;
  });
  if (found == logs_.end()) {
    auto log = std::make_unique<ThreadLog>(limit_);
    std::array<char, 64> name{};
    pthread_getname_np(pthread_self(), name.data(), name.size());
    log->name = name.data();
    log->system_id = system_id;
    log->thread = self;
    found = logs_.insert(logs_.end(), std::move(log));
  }
  cached_ = {id_, found->get()};
}

std::vector<ThreadRecords> Recorder::threads() const {
  std::lock_guard lock(mutex_);
  std::vector<ThreadRecords> out;
  for (const auto& log : logs_)
    out.push_back({log->name, log->system_id, log->lost(), log->records()});
  return out;
}

}  // namespace weir::trace
