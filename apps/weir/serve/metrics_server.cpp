// SPDX-License-Identifier: LGPL-2.1-or-later
#include "serve/metrics_server.hpp"

#include <array>
#include <cstdlib>
#include <string_view>

namespace weir::app {
namespace {

constexpr guint kLimitMs = 5000;  // for a client to send its request and to read the response
constexpr size_t kMaxOpen = 16;
constexpr size_t kMaxRequestBytes = 8192;
constexpr int kMaxWaiting = 16;

std::string make_response(const char* status, const char* type, const std::string& body) {
  return std::string("HTTP/1.1 ") + status + "\r\nContent-Type: " + type +
         "\r\nContent-Length: " + std::to_string(body.size()) + "\r\nConnection: close\r\n\r\n" +
         body;
}

std::string respond(std::string_view request, const std::function<std::string()>& page) {
  const std::string_view line = request.substr(0, request.find("\r\n"));
  if (!line.starts_with("GET "))
    return make_response("405 Method Not Allowed", "text/plain", "GET /metrics\n");
  const std::string_view path = line.substr(4, line.substr(4).find_first_of(" ?"));
  if (path != "/metrics") return make_response("404 Not Found", "text/plain", "GET /metrics\n");
  return make_response("200 OK", "text/plain; version=0.0.4; charset=utf-8", page());
}

}  // namespace

// One connection: collects a request, sends the response, and is deleted.
struct MetricsServer::Exchange {
  explicit Exchange(std::shared_ptr<Shared> with) : shared(std::move(with)) {
    shared->exchanges.push_back(this);
    time_limit = g_timeout_add_once(
        kLimitMs,
        [](gpointer user) {
          auto* self = static_cast<Exchange*>(user);
          self->time_limit = 0;
          self->cancel();
        },
        this);
  }
  ~Exchange() {
    shared->exchanges.remove(this);
    if (time_limit != 0) g_source_remove(time_limit);
  }
  Exchange(const Exchange&) = delete;
  Exchange& operator=(const Exchange&) = delete;

  // The callback of what is in progress deletes it.
  void cancel() const { g_cancellable_cancel(end.get()); }

  const std::shared_ptr<Shared> shared;
  guint time_limit = 0;
  const gst::Unique<GCancellable, g_object_unref> end{g_cancellable_new()};
  gst::Unique<GSocketConnection, g_object_unref> connection;
  std::string request, response;
  std::array<char, kMaxRequestBytes> received{};

  static void read(Exchange* self) {
    GInputStream* in = g_io_stream_get_input_stream(G_IO_STREAM(self->connection.get()));
    g_input_stream_read_async(in, self->received.data(), self->received.size(), G_PRIORITY_DEFAULT,
                              self->end.get(), on_read, self);
  }
  static void on_read(GObject* in, GAsyncResult* result, gpointer user) {
    std::unique_ptr<Exchange> self(static_cast<Exchange*>(user));
    const gssize count = g_input_stream_read_finish(G_INPUT_STREAM(in), result, nullptr);
    if (count <= 0) return;
    self->request.append(self->received.data(), static_cast<size_t>(count));
    const bool is_whole = self->request.find("\r\n\r\n") != std::string::npos;
    if (!is_whole && self->request.size() < kMaxRequestBytes) return read(self.release());
    self->response = is_whole
                         ? respond(self->request, self->shared->page)
                         : make_response("431 Request Header Fields Too Large", "text/plain", "");
    GOutputStream* out = g_io_stream_get_output_stream(G_IO_STREAM(self->connection.get()));
    const std::string& bytes = self->response;
    GCancellable* const end = self->end.get();
    g_output_stream_write_all_async(out, bytes.data(), bytes.size(), G_PRIORITY_DEFAULT, end,
                                    on_written, self.release());
  }
  static void on_written(GObject* out, GAsyncResult* result, gpointer user) {
    const std::unique_ptr<Exchange> self(static_cast<Exchange*>(user));
    g_output_stream_write_all_finish(G_OUTPUT_STREAM(out), result, nullptr, nullptr);
  }
};

// The oldest connection makes room: it has had the most time.
gboolean MetricsServer::on_incoming(GSocketService*, GSocketConnection* connection, GObject*,
                                    gpointer user) {
  const auto& shared = *static_cast<const std::shared_ptr<Shared>*>(user);
  if (shared->exchanges.size() >= kMaxOpen) {
    shared->exchanges.front()->cancel();
    shared->exchanges.pop_front();
  }
  auto exchange = std::make_unique<Exchange>(shared);
  exchange->connection.reset(G_SOCKET_CONNECTION(g_object_ref(connection)));
  Exchange::read(exchange.release());
  return TRUE;
}

namespace {

Error not_listening(const ListenAddress& address, const std::string& reason) {
  return {.code = Code::SERVER_UNREACHABLE,
          .what = "the metrics cannot be served: " + reason,
          .offered = "--metrics=" + address.text(),
          .needed = "an address of this machine with a free port",
          .fix = "--metrics=127.0.0.1:0"};
}

}  // namespace

MetricsServer::MetricsServer(std::function<std::string()> page)
    : shared_(std::make_shared<Shared>()), service_(g_socket_service_new()) {
  shared_->page = std::move(page);
}

MetricsServer::~MetricsServer() {
  g_socket_service_stop(service_.get());
  g_socket_listener_close(G_SOCKET_LISTENER(service_.get()));
  for (const Exchange* exchange : shared_->exchanges) exchange->cancel();
}

Result<std::unique_ptr<MetricsServer>> MetricsServer::open(const ListenAddress& address,
                                                           std::function<std::string()> page) {
  if (!address.is_local() || !address.unix_path.empty())
    return Error{.code = Code::OPTION_VALUE,
                 .what = "metrics are served to this machine only",
                 .offered = "--metrics=" + address.text(),
                 .needed =
                     "127.0.0.1, localhost or [::1]; Prometheus on another machine scrapes "
                     "through a proxy with TLS",
                 .fix = "--metrics=127.0.0.1:8002"};
  std::unique_ptr<MetricsServer> out(new MetricsServer(std::move(page)));
  const std::string host = address.host == "localhost" ? "127.0.0.1" : address.host;
  const auto port = static_cast<guint>(std::atoi(address.port.c_str()));
  const gst::Unique<GSocketAddress, g_object_unref> wanted(
      g_inet_socket_address_new_from_string(host.c_str(), port));
  if (!wanted) return not_listening(address, "this is not an address");
  GError* error = nullptr;
  GSocketAddress* effective = nullptr;
  auto* listener = G_SOCKET_LISTENER(out->service_.get());
  g_socket_listener_set_backlog(listener, kMaxWaiting);
  if (!g_socket_listener_add_address(listener, wanted.get(), G_SOCKET_TYPE_STREAM,
                                     G_SOCKET_PROTOCOL_TCP, nullptr, &effective, &error)) {
    const std::string reason = error->message;
    g_error_free(error);
    return not_listening(address, reason);
  }
  out->port_ = g_inet_socket_address_get_port(G_INET_SOCKET_ADDRESS(effective));
  g_object_unref(effective);
  g_signal_connect_data(
      out->service_.get(), "incoming", G_CALLBACK(on_incoming),
      new std::shared_ptr<Shared>(out->shared_),
      [](gpointer user, GClosure*) { delete static_cast<std::shared_ptr<Shared>*>(user); },
      static_cast<GConnectFlags>(0));
  g_socket_service_start(out->service_.get());
  return out;
}

}  // namespace weir::app
