// CompletionQueue: work may complete in any order; results leave in the order of submission.
//
//   auto ticket = queue.submit();            // waits while `depth` tickets are open
//   queue.complete(*ticket, result);         // from any thread, in any order
//   queue.add(*ticket, part); queue.end(*ticket);  // or any number of results, then the end
//   queue.drain([](Entry entry) { ... });    // dispatches the finished entries at the head
//
// Entries added to the oldest ticket can leave immediately; others wait for their turn. Entries
// without work (events of a stream) are appended and keep their place among the others. All
// functions are thread-safe.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace weir::infer {

template <class Entry>
class CompletionQueue {
 public:
  class Ticket {
    friend class CompletionQueue;
    Ticket(uint64_t number, uint64_t serial) : number_(number), serial_(serial) {}
    uint64_t number_;  // its place, reusable after its end
    uint64_t serial_;  // unique
  };

  // At most `depth` (>= 1) tickets are open, from submit() until their dispatch.
  explicit CompletionQueue(size_t depth) : depth_(depth), slots_(8) {}

  // Tickets beyond a smaller depth stay open.
  void set_depth(size_t depth) {
    std::lock_guard lock(mutex_);
    depth_ = depth;
    room_.notify_all();
  }

  // Opens a ticket. Waits for a free place; nullopt while the queue is flushing.
  std::optional<Ticket> submit() {
    std::unique_lock lock(mutex_);
    room_.wait(lock, [this] { return flushing_ || open_ < depth_; });
    return take_place();
  }
  // The same without waiting: nullopt also without a free place.
  std::optional<Ticket> try_submit() {
    std::lock_guard lock(mutex_);
    return open_ < depth_ ? take_place() : std::nullopt;
  }

  // Adds the last entry. Returns false, here and below, and drops the entry if the ticket is not
  // open: it was ended, or the queue was flushed since submit().
  bool complete(const Ticket& ticket, Entry entry) {
    std::lock_guard lock(mutex_);
    Slot* open = open_slot(ticket);
    if (!open) return false;
    open->add(std::move(entry));
    open->ended = true;
    return true;
  }
  // Returns false if the queue was flushed since submit(), as complete() would.
  bool holds(const Ticket& ticket) const {
    std::lock_guard lock(mutex_);
    return ticket.number_ >= first_;
  }
  // Adds one of several entries.
  bool add(const Ticket& ticket, Entry entry) {
    std::lock_guard lock(mutex_);
    Slot* open = open_slot(ticket);
    if (open) open->add(std::move(entry));
    return open;
  }
  // Ends a ticket. Its place is free immediately if no entry is queued for it.
  bool end(const Ticket& ticket) {
    std::lock_guard lock(mutex_);
    Slot* open = open_slot(ticket);
    if (!open) return false;
    open->ended = true;
    if (open->entry) return true;
    open->counted = false;
    --open_;
    while (first_ < next_ && slot(next_ - 1).passed_over()) slot(--next_) = {};
    room_.notify_one();
    if (first_ == next_) quiet_.notify_all();
    return true;
  }

  // True if an entry leaves without further work: it is being dispatched or finished.
  bool leaves() const {
    std::lock_guard lock(mutex_);
    return draining_ ||
           (first_ < next_ && (slot(first_).entry.has_value() || slot(first_).passed_over()));
  }
  // True if the ticket's entries are the next to leave.
  bool is_next(const Ticket& ticket) const {
    std::lock_guard lock(mutex_);
    return ticket.number_ == first_;
  }
  // Removes the oldest queued entry that is `of_this_kind`, as if it had not been added. Call
  // drain() afterwards.
  template <class Kind>
  std::optional<Entry> take_oldest(Kind&& of_this_kind) {
    std::lock_guard lock(mutex_);
    for (uint64_t n = first_; n < next_; ++n) {
      Slot& waiting = slot(n);
      auto taken = waiting.take_first(of_this_kind);
      if (!taken) continue;
      if (waiting.passed_over() && std::exchange(waiting.counted, false)) {
        --open_;
        room_.notify_one();
      }
      return taken;
    }
    return std::nullopt;
  }

  // Appends a finished entry. Returns false and drops it while the queue is flushing.
  bool append(Entry entry) {
    std::lock_guard lock(mutex_);
    if (flushing_) return false;
    Slot finished;
    finished.add(std::move(entry));
    finished.ended = true;
    place(std::move(finished));
    return true;
  }

  // Dispatches the entries at the head, in order, one at a time, with no lock held. While one call
  // dispatches, others return immediately; it dispatches their entries too. `hand_over` must not
  // throw.
  template <class HandOver>
  void drain(HandOver&& hand_over) {
    std::unique_lock lock(mutex_);
    if (draining_) return;
    draining_ = true;
    drainer_ = std::this_thread::get_id();
    while (first_ < next_) {
      Slot& head = slot(first_);
      auto entry = head.take();
      const bool leaves = head.passed_over(), counted = leaves && head.counted;
      if (!entry && !leaves) break;
      if (leaves) {
        head = {};
        ++first_;
      }
      if (!entry) continue;
      const uint64_t flushes = flushes_;
      lock.unlock();
      hand_over(*std::move(entry));
      lock.lock();
      if (counted && flushes == flushes_) --open_;
      if (counted) room_.notify_one();
    }
    draining_ = false;
    quiet_.notify_all();
  }

  // Waits until all entries are dispatched, which other threads must do with drain(). Returns false
  // if the queue was flushed instead.
  bool wait_until_empty() {
    std::unique_lock lock(mutex_);
    const uint64_t flushes = flushes_;
    quiet_.wait(lock, [&] { return flushes != flushes_ || (first_ == next_ && !draining_); });
    return flushes == flushes_ && !flushing_;
  }

  // Drops every entry, wakes waiting callers and rejects new entries until resume(). Returns the
  // dropped entries; complete(), add() and end() then return false for open tickets.
  std::vector<Entry> flush() {
    std::lock_guard lock(mutex_);
    flushing_ = true;
    ++flushes_;
    std::vector<Entry> dropped;
    for (; first_ < next_; ++first_)
      for (Slot taken = std::exchange(slot(first_), {}); auto entry = taken.take();)
        dropped.push_back(*std::move(entry));
    open_ = 0;
    room_.notify_all();
    quiet_.notify_all();
    return dropped;
  }
  // Accepts entries again, once no other thread dispatches entries from before the flush.
  void resume() {
    std::unique_lock lock(mutex_);
    quiet_.wait(lock, [this] { return !draining_ || drainer_ == std::this_thread::get_id(); });
    flushing_ = false;
  }

 private:
  struct Slot {
    std::optional<Entry> entry;  // the next one; empty while the work is in progress
    std::unique_ptr<std::deque<Entry>> further;  // later entries; few slots need it
    uint64_t serial = 0;                         // of its ticket
    bool ended = false;                          // no entry follows
    bool counted = false;                        // occupies one of `depth` places

    bool passed_over() const { return ended && !entry; }
    void add(Entry&& added) {
      if (!entry) {
        entry = std::move(added);
        return;
      }
      if (!further) further = std::make_unique<std::deque<Entry>>();
      further->push_back(std::move(added));
    }
    std::optional<Entry> take() {
      auto taken = std::exchange(entry, std::nullopt);
      if (further && !further->empty()) {
        entry = std::move(further->front());
        further->pop_front();
      }
      return taken;
    }
    template <class Kind>
    std::optional<Entry> take_first(Kind&& of_this_kind) {
      if (!entry || of_this_kind(*entry)) return take();
      if (!further) return std::nullopt;
      const auto at = std::find_if(further->begin(), further->end(), of_this_kind);
      if (at == further->end()) return std::nullopt;
      std::optional<Entry> taken(std::move(*at));
      further->erase(at);
      return taken;
    }
  };

  // Null if the ticket is not open. Call it with mutex_ held.
  Slot* open_slot(const Ticket& ticket) {
    if (ticket.number_ < first_ || ticket.number_ >= next_) return nullptr;
    Slot& found = slot(ticket.number_);
    return found.ended || found.serial != ticket.serial_ ? nullptr : &found;
  }

  Slot& slot(uint64_t number) { return slots_[number % slots_.size()]; }
  const Slot& slot(uint64_t number) const { return slots_[number % slots_.size()]; }
  std::optional<Ticket> take_place() {
    if (flushing_) return std::nullopt;
    ++open_;
    Slot waiting;
    waiting.counted = true;
    const uint64_t serial = waiting.serial = ++serials_;
    return Ticket(place(std::move(waiting)), serial);
  }
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

  mutable std::mutex mutex_;  // guards all below
  std::condition_variable room_;
  std::condition_variable quiet_;  // nothing is being dispatched; the queue may be empty
  size_t depth_;
  std::vector<Slot> slots_;  // a ring; entry `n` is at n % size
  uint64_t first_ = 0;       // the oldest entry not dispatched
  uint64_t next_ = 0;        // the number of the next entry
  uint64_t serials_ = 0;     // of tickets
  size_t open_ = 0;          // occupied places
  uint64_t flushes_ = 0;     // separates tickets from before a flush from later ones
  bool draining_ = false, flushing_ = false;
  std::thread::id drainer_;  // while draining_
};

}  // namespace weir::infer
