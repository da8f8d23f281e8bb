// Branch: a line of elements that is put behind a tee while the pipeline plays, and taken away
// again. Each frame bears its number, so that the branch knows of each that is missing or out of
// SPDX-License-Identifier: LGPL-2.1-or-later
// place.
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "gstcpp/ref.hpp"
#include "unlink.hpp"

namespace weir::soak {

using gst::Ref;

// Numbers of frames go from 0 to 250 and begin again.
constexpr int kNumbers = 251;

// What stands behind the tee: the last element is `tensor_sink name=end`.
struct Line {
  std::string launch;
  int offset;   // what its elements add to each byte
  bool floats;  // float32 arrives, else uint8
  bool exact;   // no frame may be missing; else only the bytes of each must be right
};

// What tensor_sinks and probes tell, from their streaming threads.
class Arrivals {
 public:
  explicit Arrivals(const Line& line) : line_(line) {}
  void entered() { ++entered_; }
  void arrived(GstBuffer* buffer);
  void ended();

  uint64_t entries() const { return entered_; }
  uint64_t frames() const;
  uint64_t faults() const;                // frames of wrong bytes, missing ones, ones out of order
  bool waits_for(uint64_t frames) const;  // whether so many arrive, in time
  bool waits_for_end() const;

 private:
  int number_of(GstBuffer* buffer) const;  // -1 = the frame is damaged

  const Line line_;
  std::atomic<uint64_t> entered_{0};
  mutable std::mutex mutex_;  // guards what follows
  mutable std::condition_variable changed_;
  uint64_t frames_ = 0, faults_ = 0;
  int last_ = -1;
  bool ended_ = false;
};

enum class Removal { Drained, Abrupt };

class Branch {
 public:
  // Adds the line to the pipeline of `tee`, which may play.
  Branch(GstElement* tee, const Line& line);
  Branch(const Branch&) = delete;
  Branch& operator=(const Branch&) = delete;
  ~Branch();

  // Takes it away. Drained: each frame that entered arrives at the end. Returns what is wrong, ""
  // for nothing: waits that do not end, frames that no ledger accounts for.
  std::string remove(Removal removal);
  const Arrivals& arrivals() const { return *arrivals_; }

 private:
  bool drains();
  std::string ledgers(Removal removal) const;

  Line line_;
  Ref<GstElement> pipeline_, tee_, bin_;
  Ref<GstPad> tee_pad_, entry_;
  std::unique_ptr<Arrivals> arrivals_;
};

// "" when received = consumed + dropped and nothing is held, of each element of `bin` that counts;
// with `frames`, that each received and consumed so many at each
// of its sink pads.
std::string check_ledgers(GstBin* bin, const uint64_t* frames);

}  // namespace weir::soak
