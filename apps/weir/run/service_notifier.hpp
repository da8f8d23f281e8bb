// Reports to systemd that a service is ready, stops and lives, by the protocol of sd_notify(3).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "weir/result.hpp"

namespace weir::app {

class ServiceNotifier {
 public:
  // Reads the variables NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID. Without the first, as
  // outside of a service, nothing is sent. SERVER_UNREACHABLE when the socket cannot be reached.
  static Result<std::unique_ptr<ServiceNotifier>> open();
  ServiceNotifier(const ServiceNotifier&) = delete;
  ServiceNotifier& operator=(const ServiceNotifier&) = delete;
  ~ServiceNotifier();

  // The pipeline plays; begins to feed the watchdog. Until stopping() it is fed only while
  // `is_alive` returns true, which gets the microseconds that the watchdog allows.
  void ready(const std::string& status, std::function<bool(gint64)> is_alive);
  void stopping();  // once; later calls do nothing

 private:
  ServiceNotifier() = default;
  void feed_watchdog() const;
  void send(std::string_view text) const;

  int socket_ = -1;                    // -1: not a service
  guint watchdog_ms_ = 0, timer_ = 0;  // half of the time that the watchdog allows; 0 = it is off
  std::function<bool(gint64)> is_alive_;
  bool is_ready_ = false, is_stopping_ = false;
};

}  // namespace weir::app
