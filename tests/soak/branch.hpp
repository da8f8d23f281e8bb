// Branch: a line of elements that is added to a tee while the pipeline plays, and removed again.
// Each frame carries its number, so that the branch detects missing and reordered frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "gstcpp/element/ref.hpp"
#include "unlink.hpp"

namespace weir::soak {

using gst::Ref;

// Frame numbers run from 0 to 250 and wrap around.
constexpr int kNumbers = 251;

// The elements downstream of the tee: the last one is `tensor_sink name=end`.
struct Line {
  std::string launch;
  int offset;   // what the elements add to each byte
  bool floats;  // the output is float32, otherwise uint8
  bool exact;   // no frame may be missing; otherwise only the bytes of each must be right
};

// Collects what tensor_sinks and probes report from their streaming threads.
class Arrivals {
 public:
  explicit Arrivals(const Line& line) : line_(line) {}
  void entered() { ++entered_; }
  void arrived(GstBuffer* buffer);
  void ended();

  uint64_t entries() const { return entered_; }
  uint64_t frames() const;
  uint64_t faults() const;                // frames that are wrong, missing or out of order
  bool waits_for(uint64_t frames) const;  // whether this many arrive in time
  bool waits_for_end() const;

 private:
  int read_number(GstBuffer* buffer) const;  // -1 for a damaged frame

  const Line line_;
  std::atomic<uint64_t> entered_{0};
  mutable std::mutex mutex_;  // guards the members below
  mutable std::condition_variable changed_;
  uint64_t frames_ = 0, faults_ = 0;
  int last_ = -1;
  bool ended_ = false;
};

enum class Removal { Drained, Abrupt };

class Branch {
 public:
  // Adds the line to the pipeline of `tee`, which may be playing.
  Branch(GstElement* tee, const Line& line);
  Branch(const Branch&) = delete;
  Branch& operator=(const Branch&) = delete;
  ~Branch();

  // Removes the line. With Drained, each frame that entered reaches the end. Returns what is wrong,
  // or "": endless waits, frames that no ledger accounts for.
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

// Returns "" when received = consumed + dropped and nothing is held, for each counting element of
// `bin`; with `frames`, each must have received and consumed this number at each sink pad.
std::string check_ledgers(GstBin* bin, const uint64_t* frames);

}  // namespace weir::soak
