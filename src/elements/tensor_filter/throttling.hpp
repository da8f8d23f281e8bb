// Throttling: drops frames that exceed the rate which downstream requested, and reports this
// upstream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "core/filter/throttle.hpp"

namespace weir {

class Throttling {
 public:
  // Any thread. True if the event requests throttling; it is not forwarded then.
  bool handle_qos(GstEvent* qos) noexcept;
  // Streaming thread. Whether to drop the frame; if so, a QoS event of type OVERFLOW was sent
  // upstream from `sink`. `latency`: of an invoke, in nanoseconds.
  bool should_drop(GstBuffer* buffer, GstClockTime running, uint64_t latency,
                   GstPad* sink) noexcept;
  bool active() const noexcept { return throttle_.limited(); }

  void restart() noexcept { throttle_.restart(); }
  void reset() noexcept { throttle_.reset(); }

 private:
  Throttle throttle_;
};

}  // namespace weir
