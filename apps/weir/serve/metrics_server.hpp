// MetricsServer: answers GET /metrics on one address of this machine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gio/gio.h>

#include <functional>
#include <list>
#include <memory>
#include <string>

#include "gstcpp/element/ref.hpp"
#include "serve/listen_address.hpp"
#include "weir/result.hpp"

namespace weir::app {

// Answers on the thread of the default main context, one request for each connection. Of more than
// 16 connections the oldest one is closed, and each one after five seconds.
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

  struct Exchange;
  // Until the last connection has ended.
  struct Shared {
    std::function<std::string()> page;
    std::list<Exchange*> exchanges;  // the oldest first
  };
  static gboolean on_incoming(GSocketService*, GSocketConnection* connection, GObject*,
                              gpointer user);

  const std::shared_ptr<Shared> shared_;
  gst::Unique<GSocketService, g_object_unref> service_;
  uint16_t port_ = 0;
};

}  // namespace weir::app
