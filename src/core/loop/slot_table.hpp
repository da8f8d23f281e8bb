// SlotTable: slots by number, through which one place of a program hands frames to another.
//
// A slot comes with the first writer or reader that names it and goes with the last. It holds one
// frame: a writer waits until a reader has taken it, a reader waits until there is one. Whatever
// can end a wait wakes all who wait at the slot: frames, the end of either side, a flush,
// interrupt(), a move to another slot. Who waits where the other side has nobody is told so, once a
// slot. Frames are moved, never copied; none is destroyed, and nobody told anything, under the
// lock.
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
  Unwanted,     // each reader has ended: nobody will take it
  Interrupted,  // interrupt(), or detached
};
enum class Take {
  Frame,
  Restarted,  // a writer was flushed: what was on its way is lost, the loop begins anew
  Ended,      // each writer has ended, and what they left is taken
  Interrupted,
};

// Who is told that an end waits alone, with the number of its slot, and after how long: the other
// side may come a moment later.
struct Alone {
  std::function<void(uint32_t)> tell = {};
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
    unsigned ends = 0;  // writers and readers, also those that have ended
  };

  // One writer or reader. Any thread may call anything.
  class End {
   public:
    End(const End&) = delete;
    End& operator=(const End&) = delete;

    // Takes part in slot `index`; what an earlier run left at this end is forgotten.
    void attach(uint32_t index) {
      const auto left = detach();  // destroyed without the lock
      std::lock_guard lock(table_.mutex_);
      interrupted_ = false;
      join(index);
    }
    // Goes over to slot `index` if attached; a wait goes on there.
    // Returns the frame of a slot that is gone with this.
    std::optional<Frame> move(uint32_t index) {
      std::lock_guard lock(table_.mutex_);
      if (!slot_ || index == index_) return std::nullopt;
      auto left = leave();
      join(index);
      return left;
    }
    // Ends a wait. Returns the frame of a slot that is gone with this.
    std::optional<Frame> detach() {
      std::lock_guard lock(table_.mutex_);
      return leave();
    }
    // Ends a wait and those to come, until resume().
    void interrupt() {
      std::lock_guard lock(table_.mutex_);
      interrupted_ = true;
      wake();
    }
    void resume() {
      std::lock_guard lock(table_.mutex_);
      interrupted_ = false;
    }
    // Nothing comes from here, or is taken from here, until begin().
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

    // Another of its kind, which has not ended, is at the same slot: a frame goes to one of them.
    bool shares_slot() const {
      std::lock_guard lock(table_.mutex_);
      return slot_ && !ended_ && ((*slot_).*side_).open > 1;
    }

   protected:
    End(SlotTable& table, Side Slot::*side, Side Slot::*other, Alone alone)
        : table_(table), alone_(std::move(alone)), side_(side), other_(other) {}
    ~End() { detach(); }

    // Waits until `ready` says so of the slot that this end is at; null when interrupted.
    template <class Ready>
    Slot* wait(std::unique_lock<std::mutex>& lock, Ready&& ready) {
      while (slot_ && !interrupted_) {
        if (ready(*slot_)) return slot_.get();
        const auto here = slot_;  // a move takes the slot from under the wait
        const auto is_alone = [&] { return slot_ == here && ((*here).*other_).open == 0; };
        if (told_ || !alone_.tell || !is_alone()) {
          here->changed.wait(lock);
        } else if (here->changed.wait_for(lock, alone_.after) == std::cv_status::timeout &&
                   is_alone() && !interrupted_) {
          told_ = true;
          const uint32_t index = index_;
          lock.unlock();
          alone_.tell(index);
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
    std::shared_ptr<Slot> slot_;  // null = detached. This and what follows: table_.mutex_

   private:
    Side& side() noexcept { return (*slot_).*side_; }
    void join(uint32_t index) {
      auto& slot = table_.slots_[index];
      if (!slot) slot = std::make_shared<Slot>();
      slot_ = slot;
      index_ = index;
      ++slot->ends;
      ended_ = told_ = false;
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
    bool told_ = false;  // that it is alone in this slot
  };

 public:
  class Writer : public End {
   public:
    explicit Writer(SlotTable& table, Alone alone = {})
        : End(table, &Slot::writers, &Slot::readers, std::move(alone)) {}

    // Waits for room. The frame is moved from only when it is stored.
    Put put(Frame& frame) {
      std::unique_lock lock(this->table_.mutex_);
      Slot* slot = this->wait(lock, [](const Slot& s) { return !s.frame || s.readers.over(); });
      if (!slot) return Put::Interrupted;
      if (slot->readers.over()) return Put::Unwanted;
      slot->frame.emplace(std::move(frame));
      this->wake();
      return Put::Stored;
    }
    // Empties the slot, returns what was in it. Unless a frame comes first, a reader is told
    // Restarted, once. A writer that has ended begins again.
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

    // Waits for a frame, or for what comes instead of one.
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
    // Begins with a frame of its own: a restart that nobody was told of is void.
    void begin_anew() {
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
