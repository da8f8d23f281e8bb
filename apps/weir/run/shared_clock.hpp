// SharedClock: the clock that pipelines on several machines have in common.
//
//   auto clock = SharedClock::open({.address = "net://camera.local:5637"});
//   clock->apply_to(pipeline);  // before it plays
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "gstcpp/element/ref.hpp"
#include "report.hpp"
#include "weir/result.hpp"

namespace weir::app {

struct ClockOptions {
  std::string address;              // net://HOST:PORT, ntp://HOST[:PORT], ptp://DOMAIN; "" = own
  std::optional<int> serving_port;  // of this clock, for other machines; 0 = a free one
  bool wanted() const { return !address.empty() || serving_port.has_value(); }
};

class SharedClock {
 public:
  // Waits until the clock is synchronised. OPTION_VALUE for an address or a port that cannot be
  // used, SERVER_UNREACHABLE when the clock does not synchronise in time.
  static Result<std::unique_ptr<SharedClock>> open(const ClockOptions& options);

  // The pipeline plays by this clock, and its running time is the time of the clock: buffers that
  // live sources time on several machines have comparable times.
  void apply_to(GstElement* pipeline) const;
  int serving_port() const;  // 0 = not served
  // {"address", "offset_ns", "round_trip_ns", "error_ns", "port"}. The offset is that of the
  // shared clock to this machine's monotonic clock. The error is at most half of the last round
  // trip and what the clock has not yet corrected by its response. Round trip and error are null
  // for PTP and for the own clock.
  Json state() const;
  std::string state_text() const;  // the same as a line of text

 private:
  // The server's time in nanoseconds, which is known to half the round trip.
  struct Response {
    int64_t offset = 0, round_trip = 0;
  };
  struct Exactness {
    int64_t offset = 0;
    std::optional<int64_t> round_trip, error;
  };
  SharedClock() = default;
  Status connect(const std::string& address);
  Status serve(int port);
  void watch_responses();
  int64_t offset() const;  // nanoseconds
  Exactness exactness() const;

  std::string address_;
  gst::Ref<GstBus> bus_;  // of the clock's statistics; outlives clock_
  gst::Ref<GstClock> clock_;
  gst::Ref<GstObject> provider_;
  mutable std::mutex mutex_;          // guards response_
  std::optional<Response> response_;  // the last one
};

}  // namespace weir::app
