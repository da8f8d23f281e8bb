// SlotTable: numbered slots that pass frames from one place of a program to another.
//
// A slot exists while a writer or reader is attached to it and holds one frame. A writer waits
// until a reader has taken the frame; a reader waits until there is one. Every event that can end a
// wait wakes all who wait at the slot: frames, the end of either side, a flush, interrupt(), a move
// to another slot. A writer or reader that waits while the other side has no user is
// reported once per slot. Frames are moved, never copied. No frame is destroyed and no callback
// runs under the lock.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

namespace weir::loop {

enum class Put {
  Stored,
  Unwanted,     // every reader has ended, so the frame will not be read
  Interrupted,  // interrupt(), or detached
};
enum class Take {
  Frame,
  Restarted,  // a writer was flushed: the frame in transit is lost, the loop starts again
  Ended,      // every writer has ended and all frames are taken
  Interrupted,
};

// The callback for an end that waits alone, called with the slot number after a delay, because the
// other side may attach a moment later.
struct Alone {
  std::function<void(uint32_t)> report = {};
  std::chrono::milliseconds after{1000};
};

template <class Frame>
struct Taken {
  Take outcome = Take::Interrupted;
  std::optional<Frame> frame;
};

template <class Frame>
class SlotTable {
  // The writers of a slot, or its readers.
  struct Side {
    unsigned open = 0;  // attached and not ended
    bool one_ended = false;
    bool over() const noexcept { return one_ended && open == 0; }
    void join() noexcept {
      if (open++ == 0) one_ended = false;
    }
    void end() noexcept { --open, one_ended = true; }
  };
  struct Slot {
    std::condition_variable changed;
    std::optional<Frame> frame;
    Side writers, readers;
    bool restarted = false;
    unsigned ends = 0;  // writers and readers, including those that have ended
  };

  // One writer or reader. Every method may be called from any thread.
  class End {
   public:
    End(const End&) = delete;
    End& operator=(const End&) = delete;

    // Attaches to slot `index` and discards the state of an earlier run.
    void attach(uint32_t index) {
      const auto left = detach();  // destroyed after the lock is released
      std::lock_guard lock(table_.mutex_);
      interrupted_ = false;
      join(index);
    }
    // Moves to slot `index` if attached; a wait continues there. Returns the frame of the old slot
    // if this removes the slot.
    std::optional<Frame> move(uint32_t index) {
      std::lock_guard lock(table_.mutex_);
      if (!slot_ || index == index_) return std::nullopt;
      auto left = leave();
      join(index);
      return left;
    }
    // Ends a wait. Returns the frame of the slot if this removes the slot.
    std::optional<Frame> detach() {
      std::lock_guard lock(table_.mutex_);
      return leave();
    }
    // Ends the current wait and all later ones until resume().
    void interrupt() {
      std::lock_guard lock(table_.mutex_);
      interrupted_ = true;
      wake();
    }
    void resume() {
      std::lock_guard lock(table_.mutex_);
      interrupted_ = false;
    }
    // Provides or accepts no more frames until begin().
    void end() {
      std::lock_guard lock(table_.mutex_);
      if (!slot_ || ended_) return;
      ended_ = true;
      side().end();
      wake();
    }
    void begin() {
      std::lock_guard lock(table_.mutex_);
      reopen();
    }

    // Whether another end of this kind that has not ended shares the slot: each frame then goes to
    // only one of them.
    bool shares_slot() const {
      std::lock_guard lock(table_.mutex_);
      return slot_ && !ended_ && ((*slot_).*side_).open > 1;
    }

   protected:
    End(SlotTable& table, Side Slot::*side, Side Slot::*other, Alone alone)
        : table_(table), alone_(std::move(alone)), side_(side), other_(other) {}
    ~End() { detach(); }

    // Waits until `ready` is true for the slot of this end; null if interrupted.
    template <class Ready>
    Slot* wait(std::unique_lock<std::mutex>& lock, Ready&& ready) {
      while (slot_ && !interrupted_) {
        if (ready(*slot_)) return slot_.get();
        const auto here = slot_;  // keeps the slot: a move may replace slot_ during the wait
        const auto is_alone = [&] { return slot_ == here && ((*here).*other_).open == 0; };
        if (reported_ || !alone_.report || !is_alone()) {
          here->changed.wait(lock);
        } else if (here->changed.wait_for(lock, alone_.after) == std::cv_status::timeout &&
                   is_alone() && !interrupted_) {
          reported_ = true;
          const uint32_t index = index_;
          lock.unlock();
          alone_.report(index);
          lock.lock();
        }
      }
      return nullptr;
    }
    void wake() noexcept {
      if (slot_) slot_->changed.notify_all();
    }
    void reopen() noexcept {
      if (!slot_ || !ended_) return;
      ended_ = false;
      side().join();
    }

    SlotTable& table_;
    std::shared_ptr<Slot> slot_;  // null = detached. This and the members below: table_.mutex_

   private:
    Side& side() noexcept { return (*slot_).*side_; }
    void join(uint32_t index) {
      auto& slot = table_.slots_[index];
      if (!slot) slot = std::make_shared<Slot>();
      slot_ = slot;
      index_ = index;
      ++slot->ends;
      ended_ = reported_ = false;
      side().join();
      wake();
    }
    std::optional<Frame> leave() {
      if (!slot_) return std::nullopt;
      if (!ended_) --side().open;
      std::optional<Frame> left;
      if (--slot_->ends == 0) {
        left.swap(slot_->frame);
        table_.slots_.erase(index_);
      }
      wake();
      slot_ = nullptr;
      return left;
    }

    const Alone alone_;
    Side Slot::*side_;
    Side Slot::*other_;
    uint32_t index_ = 0;
    bool interrupted_ = false, ended_ = false;
    bool reported_ = false;  // that it waits alone in this slot
  };

 public:
  class Writer : public End {
   public:
    explicit Writer(SlotTable& table, Alone alone = {})
        : End(table, &Slot::writers, &Slot::readers, std::move(alone)) {}

    // Waits for room. Moves from the frame only if it is stored.
    Put put(Frame& frame) {
      std::unique_lock lock(this->table_.mutex_);
      Slot* slot = this->wait(lock, [](const Slot& s) { return !s.frame || s.readers.over(); });
      if (!slot) return Put::Interrupted;
      if (slot->readers.over()) return Put::Unwanted;
      slot->frame.emplace(std::move(frame));
      this->wake();
      return Put::Stored;
    }
    // Empties the slot and returns its frame. The reader gets Restarted once, unless a new frame
    // arrives first. A writer that has ended starts again.
    std::optional<Frame> flush() {
      std::lock_guard lock(this->table_.mutex_);
      if (!this->slot_) return std::nullopt;
      std::optional<Frame> lost;
      lost.swap(this->slot_->frame);
      this->slot_->restarted = true;
      this->reopen();
      this->wake();
      return lost;
    }
  };

  class Reader : public End {
   public:
    explicit Reader(SlotTable& table, Alone alone = {})
        : End(table, &Slot::readers, &Slot::writers, std::move(alone)) {}

    // Waits for a frame, a restart, or the end of all writers.
    Taken<Frame> take() {
      std::unique_lock lock(this->table_.mutex_);
      Slot* slot = this->wait(
          lock, [](const Slot& s) { return s.frame || s.restarted || s.writers.over(); });
      Taken<Frame> taken;
      if (!slot) return taken;
      const bool restarted = std::exchange(slot->restarted, false);
      taken.frame.swap(slot->frame);
      taken.outcome = taken.frame ? Take::Frame : restarted ? Take::Restarted : Take::Ended;
      this->wake();
      return taken;
    }
    // Call when the reader starts with its own frame: cancels a restart that is not taken yet.
    void begin_again() {
      std::lock_guard lock(this->table_.mutex_);
      if (this->slot_) this->slot_->restarted = false;
    }
  };

  size_t size() const {
    std::lock_guard lock(mutex_);
    return slots_.size();
  }

 private:
  mutable std::mutex mutex_;  // guards all slots and ends
  std::map<uint32_t, std::shared_ptr<Slot>> slots_;
};

}  // namespace weir::loop
