// Throttling: drops frames that the elements behind tensor_filter asked it not to make, and tells
// the elements before it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "core/filter/throttle.hpp"

namespace weir {

class Throttling {
 public:
  // Any thread. True when the event asks to throttle: it ends here.
  bool hear(GstEvent* qos) noexcept;
  // Streaming thread. Whether the frame is dropped; then a QoS event of type OVERFLOW went up from
  // `sink`. `latency`: of an invoke, ns.
  bool refuses(GstBuffer* buffer, GstClockTime running, uint64_t latency, GstPad* sink) noexcept;
  bool active() const noexcept { return throttle_.limited(); }

  void restart() noexcept { throttle_.restart(); }
  void reset() noexcept { throttle_.reset(); }

 private:
  Throttle throttle_;
};

}  // namespace weir
