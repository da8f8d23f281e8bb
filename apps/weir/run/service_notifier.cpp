// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/service_notifier.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <utility>

#include "core/text/text.hpp"
#include "machine/environment.hpp"

namespace weir::app {
namespace {

constexpr guint kUsPerMs = 1000;

std::string variable(const char* name) {
  const char* const value = environment_variable(name);
  return value ? value : "";
}

Error unreachable(const std::string& path, const char* why) {
  return Error{.code = Code::SERVER_UNREACHABLE,
               .what = "the service manager cannot be reached",
               .offered = "NOTIFY_SOCKET=" + path + ": " + why,
               .needed = "a socket of systemd: a service with Type=notify"};
}

// The time between two reports to the watchdog, half of what it allows; 0: it is off.
guint watchdog_interval() {
  const auto allowed = parse_unsigned(variable("WATCHDOG_USEC"));
  const std::string process = variable("WATCHDOG_PID");
  if (!allowed || (!process.empty() && process != std::to_string(getpid()))) return 0;
  return static_cast<guint>(std::min<uint64_t>(*allowed / 2 / kUsPerMs, G_MAXUINT));
}

}  // namespace

Result<std::unique_ptr<ServiceNotifier>> ServiceNotifier::open() {
  std::unique_ptr<ServiceNotifier> out(new ServiceNotifier);
  const std::string path = variable("NOTIFY_SOCKET");
  if (path.empty()) return out;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if ((path[0] != '/' && path[0] != '@') || path.size() >= sizeof address.sun_path)
    return unreachable(path, "not the path of a socket");
  std::memcpy(address.sun_path, path.data(), path.size());
  if (path[0] == '@') address.sun_path[0] = '\0';  // of the abstract namespace
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
  out->socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (out->socket_ < 0 ||
      connect(out->socket_, reinterpret_cast<const sockaddr*>(&address), size) != 0)
    return unreachable(path, std::strerror(errno));
  out->watchdog_ms_ = watchdog_interval();
  return out;
}

ServiceNotifier::~ServiceNotifier() {
  if (timer_ != 0) g_source_remove(timer_);
  if (socket_ >= 0) close(socket_);
}

void ServiceNotifier::ready(const std::string& status, std::function<bool(gint64)> is_alive) {
  if (is_ready_) return;
  is_ready_ = true;
  is_alive_ = std::move(is_alive);
  send("READY=1\nSTATUS=" + status);
  if (watchdog_ms_ == 0 || socket_ < 0) return;
  feed_watchdog();
  const auto feed = +[](gpointer self) -> gboolean {
    static_cast<ServiceNotifier*>(self)->feed_watchdog();
    return G_SOURCE_CONTINUE;
  };
  timer_ = g_timeout_add(watchdog_ms_, feed, this);
}

void ServiceNotifier::feed_watchdog() const {
  if (is_stopping_ || is_alive_(2 * gint64{kUsPerMs} * watchdog_ms_)) send("WATCHDOG=1");
}

void ServiceNotifier::stopping() {
  if (is_stopping_) return;
  is_stopping_ = true;
  send("STOPPING=1");
}

// A manager that is gone is no reason to stop.
void ServiceNotifier::send(std::string_view text) const {
  if (socket_ >= 0) ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
}

}  // namespace weir::app
