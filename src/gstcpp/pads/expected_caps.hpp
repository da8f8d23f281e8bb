// ExpectedCaps: what a source pad will have, of what upstream offers, before caps arrive.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <cstdint>
#include <functional>
#include <mutex>

#include "gstcpp/element/ref.hpp"

namespace weir::gst {

// Any thread may call.
class ExpectedCaps {
 public:
  // Returns the output caps for one of the caps that upstream offers, which are writable, and fixed
  // unless more than the framerate is open; the framerate is 0/1. Empty: none for these. Null:
  // upstream may have caps whose output is not known.
  using Make = std::function<Ref<GstCaps>(GstCaps* input)>;

  // All that `make` returns for what the peer of `sink` offers, empty after a null. `make` is
  // called again only for other upstream caps, or after forget(). `filter` may be null.
  Ref<GstCaps> query(GstPad* sink, const GstCaps* filter, const Make& make);
  // Call when `make` would return other caps.
  void forget();

 private:
  Ref<GstCaps> find(const GstCaps* offered, const Make& make);
  std::mutex mutex_;        // guards the rest; not held in calls of `make`
  Ref<GstCaps> offered_;    // null: none is kept
  Ref<GstCaps> expected_;   // for offered_
  uint64_t forgotten_ = 0;  // number of forget() calls
};

}  // namespace weir::gst
