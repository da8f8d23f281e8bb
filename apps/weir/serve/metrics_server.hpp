// MetricsServer: answers GET /metrics on one address of this machine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gio/gio.h>

#include <functional>
#include <memory>
#include <string>

#include "gstcpp/element/ref.hpp"
#include "serve/served_models.hpp"
#include "weir/result.hpp"

namespace weir::app {

// Answers on the thread of the default main context, one request for each connection.
class MetricsServer {
 public:
  // `page` writes the body of each response. OPTION_VALUE for addresses that other machines reach;
  // SERVER_UNREACHABLE when the address cannot be used.
  static Result<std::unique_ptr<MetricsServer>> open(const ListenAddress& address,
                                                     std::function<std::string()> page);
  ~MetricsServer();
  MetricsServer(const MetricsServer&) = delete;
  MetricsServer& operator=(const MetricsServer&) = delete;

  uint16_t port() const noexcept { return port_; }

 private:
  explicit MetricsServer(std::function<std::string()> page);

  const std::function<std::string()> page_;
  gst::Unique<GSocketService, g_object_unref> service_;
  gst::Unique<GCancellable, g_object_unref> end_;
  uint16_t port_ = 0;
};

}  // namespace weir::app
