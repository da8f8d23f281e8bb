// CompletionQueue: work may end in any order; results leave in the order in which it was submitted.
//
//   auto ticket = queue.submit();            // waits while `depth` pieces of work are open
//   queue.complete(*ticket, result);         // from any thread, in any order
//   queue.drain([](Entry entry) { ... });    // hands over what is finished at the head
//
// Entries that need no work (events of a stream) are appended and keep their place among the
// others. Every function may be called from any thread.
#pragma once
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace weir::infer {

template <class Entry>
class CompletionQueue {
 public:
  class Ticket {
    friend class CompletionQueue;
    explicit Ticket(uint64_t number) : number_(number) {}
    uint64_t number_;
  };

  // At most `depth` (>= 1) tickets are between submit() and their hand-over.
  explicit CompletionQueue(size_t depth) : depth_(depth), slots_(8) {}

  // A place for work that begins now. Waits for room; nullopt while the queue is flushing.
  std::optional<Ticket> submit() {
    std::unique_lock lock(mutex_);
    room_.wait(lock, [this] { return flushing_ || open_ < depth_; });
    if (flushing_) return std::nullopt;
    ++open_;
    return Ticket(place({std::nullopt, true}));
  }

  // Once for each ticket. False when the queue was flushed since submit(): the entry is dropped.
  bool complete(const Ticket& ticket, Entry entry) {
    std::lock_guard lock(mutex_);
    if (ticket.number_ < first_) return false;
    slot(ticket.number_).entry = std::move(entry);
    return true;
  }

  // An entry that is finished already. False while the queue is flushing: the entry is dropped.
  bool append(Entry entry) {
    std::lock_guard lock(mutex_);
    if (flushing_) return false;
    place({std::move(entry), false});
    return true;
  }

  // Hands over the finished entries at the head, in order, one at a time and with no lock held.
  // While one call hands over, others return at once: it takes theirs too. `hand_over` must not
  // throw.
  template <class HandOver>
  void drain(HandOver&& hand_over) {
    std::unique_lock lock(mutex_);
    if (draining_) return;
    draining_ = true;
    while (first_ < next_ && slot(first_).entry) {
      Slot taken = std::exchange(slot(first_), {});
      const uint64_t flushes = flushes_;
      ++first_;
      lock.unlock();
      hand_over(*std::move(taken.entry));
      lock.lock();
      if (taken.counted && flushes == flushes_) --open_;
      room_.notify_one();
    }
    draining_ = false;
  }

  // Drops every entry and lets waiting callers go; until resume() nothing is taken. Returns the
  // finished entries that were dropped; open tickets hear of it from complete().
  std::vector<Entry> flush() {
    std::lock_guard lock(mutex_);
    flushing_ = true;
    ++flushes_;
    std::vector<Entry> dropped;
    for (; first_ < next_; ++first_)
      if (auto taken = std::exchange(slot(first_), {}); taken.entry)
        dropped.push_back(*std::move(taken.entry));
    open_ = 0;
    room_.notify_all();
    return dropped;
  }
  void resume() {
    std::lock_guard lock(mutex_);
    flushing_ = false;
  }

 private:
  struct Slot {
    std::optional<Entry> entry;  // empty while the work goes on
    bool counted = false;        // holds one of `depth` places
  };

  Slot& slot(uint64_t number) { return slots_[number % slots_.size()]; }
  uint64_t place(Slot&& filled) {
    if (next_ - first_ == slots_.size()) grow();
    slot(next_) = std::move(filled);
    return next_++;
  }
  void grow() {
    std::vector<Slot> wider(slots_.size() * 2);
    for (uint64_t n = first_; n < next_; ++n) wider[n % wider.size()] = std::move(slot(n));
    slots_ = std::move(wider);
  }

  std::mutex mutex_;  // guards all below
  std::condition_variable room_;
  const size_t depth_;
  std::vector<Slot> slots_;  // a ring; the entry `n` lies at n % size
  uint64_t first_ = 0;       // the oldest entry that is not handed over
  uint64_t next_ = 0;        // the number of the next entry
  size_t open_ = 0;          // places taken
  uint64_t flushes_ = 0;     // tells places taken before a flush from those after
  bool draining_ = false, flushing_ = false;
};

}  // namespace weir::infer
