// The thread of a client: connects, reads, writes, and connects again.
//
// Not mosquitto_loop(): its pselect() ends the process for a socket number of 1024 or more, and the
// library's own thread waits at least a second before it connects again.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <arpa/inet.h>
#include <mqtt_protocol.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <gio/gio.h>
#include <csignal>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "transport/mqtt/broker_connection.hpp"

namespace weir::transport {
namespace {

std::string address_text(GInetAddress* address) {
  const std::unique_ptr<char, decltype(&g_free)> text(g_inet_address_to_string(address), g_free);
  return text.get();
}

// Addresses as text, in the order of the resolver; empty with `*reason` if there are none.
std::vector<std::string> find_addresses(const std::string& host, GCancellable* cancellable,
                                        std::string* reason) {
  GError* error = nullptr;
  const std::unique_ptr<GResolver, decltype(&g_object_unref)> resolver(g_resolver_get_default(),
                                                                       g_object_unref);
  GList* found = g_resolver_lookup_by_name(resolver.get(), host.c_str(), cancellable, &error);
  std::vector<std::string> out;
  for (GList* item = found; item; item = item->next)
    out.push_back(address_text(G_INET_ADDRESS(item->data)));
  g_resolver_free_addresses(found);
  if (error) *reason = error->message;
  g_clear_error(&error);
  return out;
}

// The address of this machine on a connected socket, or "".
std::string local_address_of(int socket) {
  sockaddr_storage storage{};
  socklen_t length = sizeof storage;
  auto* address = reinterpret_cast<sockaddr*>(&storage);
  if (socket < 0 || getsockname(socket, address, &length) != 0) return "";
  char text[INET6_ADDRSTRLEN] = "";
  if (storage.ss_family == AF_INET)
    inet_ntop(AF_INET, &reinterpret_cast<sockaddr_in*>(&storage)->sin_addr, text, sizeof text);
  if (storage.ss_family == AF_INET6)
    inet_ntop(AF_INET6, &reinterpret_cast<sockaddr_in6*>(&storage)->sin6_addr, text, sizeof text);
  return text;
}

using namespace std::chrono_literals;
constexpr auto kFirstDelay = 100ms, kLastDelay = 1000ms;
constexpr int kIdleWaitMs = 500;  // so often the library looks after its keep-alive
constexpr auto kGoodbye = 500ms;

std::string socket_error(int socket) {
  int error = 0;
  socklen_t length = sizeof error;
  if (getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &length) != 0 || error == 0) return "";
  char text[128];
  return strerror_r(error, text, sizeof text);
}

bool is_writable(int socket, int wait_ms) {
  pollfd wait{.fd = socket, .events = POLLOUT, .revents = 0};
  return poll(&wait, 1, wait_ms) > 0 && (wait.revents & POLLOUT);
}
bool has_failed(int socket) {
  pollfd wait{.fd = socket, .events = 0, .revents = 0};
  return poll(&wait, 1, 0) > 0 && (wait.revents & POLLERR);
}
// Whether a connection has ended and there is nothing left to read.
bool has_ended(int socket) {
  pollfd wait{.fd = socket, .events = 0, .revents = 0};
  char byte = 0;
  return poll(&wait, 1, 0) > 0 && (wait.revents & POLLHUP) &&
         recv(socket, &byte, 1, MSG_PEEK | MSG_DONTWAIT) <= 0;
}

}  // namespace

BrokerClient::Impl::Impl(BrokerOptions options)
    : options_(std::move(options)),
      received_(options_.max_received_messages, options_.max_received_bytes),
      lookup_(g_cancellable_new(), g_object_unref) {}

BrokerClient::Impl::~Impl() {
  stopping_ = true;
  g_cancellable_cancel(lookup_.get());
  interrupt(true);
  wake_.set();
  if (thread_.joinable()) thread_.join();
  client_.reset();
}

Status BrokerClient::Impl::start() {
  auto client = make_mosquitto(options_, this);
  if (!client) return client.error();
  client_ = *std::move(client);
  set_callbacks();
  thread_ = std::thread([this] { run(); });
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return first_.has_value(); });
  return *first_;
}

void BrokerClient::Impl::run() {
  // OpenSSL writes to sockets that the broker has closed.
  sigset_t pipe;
  sigemptyset(&pipe);
  sigaddset(&pipe, SIGPIPE);
  pthread_sigmask(SIG_BLOCK, &pipe, nullptr);

  std::chrono::milliseconds delay = kFirstDelay;
  while (!stopping_) {
    if (connect()) {
      use_connection();
      // A broker repeats a message that it retains, also an invalid one.
      if (!error_) delay = kFirstDelay;
    } else if (report_to_open()) {
      return;
    }
    wait_for_wake(delay);
    delay = std::min<std::chrono::milliseconds>(2 * delay, kLastDelay);
  }
}

void BrokerClient::Impl::use_connection() {
  connected();
  error_.reset();
  while (!stopping_ && step(kIdleWaitMs) == MOSQ_ERR_SUCCESS) {
  }
  if (stopping_) say_goodbye();
  disconnected();
}

bool BrokerClient::Impl::report_to_open() {
  std::lock_guard lock(mutex_);
  const bool first = !first_;
  if (first) first_ = error_ ? *error_ : broker_unreachable(options_, "the client was stopped");
  changed_.notify_all();
  return first;
}

bool BrokerClient::Impl::connect() {
  std::string reason = "no address";
  const auto addresses = find_addresses(options_.host, lookup_.get(), &reason);
  error_.reset();
  if (connect_to_one(addresses, &reason)) return true;
  // Only open() reports the reason.
  if (!error_ && !is_open_) error_ = find_tls_failure(options_, tls_error_);
  if (!error_) error_ = broker_unreachable(options_, reason);
  return false;
}

bool BrokerClient::Impl::connect_to_one(const std::vector<std::string>& addresses,
                                        std::string* reason) {
  // Certificates are verified against the name, so with TLS the library has to look it up again.
  // Not blocking, it tries the first address only.
  if (options_.tls.is_enabled() && options_.tls.psk.empty())
    return !addresses.empty() && connect_to(options_.host, addresses.size() > 1, reason);
  for (const auto& address : addresses) {
    if (stopping_) break;
    if (connect_to(address, false, reason)) return true;
  }
  return false;
}

bool BrokerClient::Impl::connect_to(const std::string& target, bool blocking, std::string* reason) {
  tls_error_.clear();
  // The library formats a line for each packet while there is this callback.
  mosquitto_log_callback_set(client_.get(), [](mosquitto*, void* self, int, const char* line) {
    auto& error = static_cast<Impl*>(self)->tls_error_;
    if (error.empty()) error = tls_error_of_log(line);
  });
  const bool connected = try_connect(target, blocking, reason);
  mosquitto_log_callback_set(client_.get(), nullptr);
  return connected;
}

bool BrokerClient::Impl::try_connect(const std::string& target, bool blocking,
                                     std::string* reason) {
  const auto end = Clock::now() + options_.connect_timeout;
  response_.reset();
  checked_.reset();
  const auto function = blocking ? mosquitto_connect : mosquitto_connect_async;
  const int result = function(client_.get(), target.c_str(), options_.port, options_.keep_alive);
  *reason = result == MOSQ_ERR_ERRNO ? std::strerror(errno) : mosquitto_strerror(result);
  if (result != MOSQ_ERR_SUCCESS) return false;
  while (!response_ && !stopping_)
    if (!await_response(end, reason)) return false;
  if (response_ == 0) return true;
  if (response_)
    error_ =
        broker_refused(options_, "does not accept the client " + options_.client_id,
                       options_.version == MqttVersion::V5 ? mosquitto_reason_string(*response_)
                                                           : mosquitto_connack_string(*response_));
  return false;
}

bool BrokerClient::Impl::await_response(Clock::time_point end, std::string* reason) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now());
  if (left <= 0ms) {
    *reason = "no answer within " + std::to_string(options_.connect_timeout.count()) + " ms";
    return false;
  }
  const bool has_more = checked_ && checked_->has_more();  // such as the reason for the end
  if (!has_more && has_failed(socket())) {
    *reason = socket_error(socket());
    return false;
  }
  const bool ended = !has_more && has_ended(socket());
  const auto is_checked = check_packets();
  if (!is_checked) error_ = is_checked.error();
  if (!is_checked || !*is_checked) return is_checked.has_value();
  const int result =
      step(static_cast<int>(std::min<std::chrono::milliseconds>(left, 50ms).count()));
  if (response_) return true;
  if (result != MOSQ_ERR_SUCCESS) *reason = mosquitto_strerror(result);
  // OpenSSL takes the error of a refused connection from the socket, and the library waits on.
  if (result == MOSQ_ERR_SUCCESS && ended) *reason = "the connection was refused or ended";
  return result == MOSQ_ERR_SUCCESS && !ended;
}

int BrokerClient::Impl::socket() const {
  return checked_ ? checked_->socket() : mosquitto_socket(client_.get());
}

Result<bool> BrokerClient::Impl::check_packets() {
  if (checked_ || options_.version != MqttVersion::V5) return true;
  if (!is_writable(socket(), 50)) return false;
  auto checked = CheckedSocket::replace_socket_of(client_.get());
  if (!checked) return checked.error();
  checked_ = *std::move(checked);
  return true;
}

int BrokerClient::Impl::step(int wait_ms) {
  const int socket = mosquitto_socket(client_.get());
  if (socket < 0) return MOSQ_ERR_NO_CONN;
  const bool reads = should_read();
  pollfd waits[] = {{.fd = socket, .events = static_cast<short>(reads ? POLLIN : 0), .revents = 0},
                    {.fd = wake_.descriptor(), .events = POLLIN, .revents = 0},
                    {.fd = -1, .events = 0, .revents = 0}};
  if (mosquitto_want_write(client_.get())) waits[0].events |= POLLOUT;
  if (checked_)
    waits[2] = {.fd = checked_->socket(), .events = checked_->events(reads), .revents = 0};
  const bool has_unread =
      reads && (has_unread_tls_data(client_.get()) || (checked_ && checked_->has_more()));
  poll(waits, 3, has_unread ? 0 : wait_ms);
  if (waits[1].revents) wake_.clear();
  if (has_unread) waits[0].revents |= POLLIN;
  int result = read(waits[0], waits[2]);
  if (result == MOSQ_ERR_SUCCESS && mosquitto_want_write(client_.get()))
    result = mosquitto_loop_write(client_.get(), 1);
  if (checked_ && !checked_->send() && result == MOSQ_ERR_SUCCESS) result = MOSQ_ERR_CONN_LOST;
  return result == MOSQ_ERR_SUCCESS ? mosquitto_loop_misc(client_.get()) : result;
}

int BrokerClient::Impl::read(const pollfd& client, const pollfd& broker) {
  bool is_readable = client.revents & (POLLIN | POLLHUP | POLLERR);
  if (checked_ && (is_readable || (broker.revents & ~POLLOUT))) {
    const auto received = checked_->receive(broker.revents);
    if (!received) {
      error_ = received.error();
      if (is_open_ && options_.on_invalid_packet && !std::exchange(has_reported_packet_, true))
        options_.on_invalid_packet(*error_);
      return MOSQ_ERR_MALFORMED_PACKET;
    }
    is_readable = is_readable || *received;
  }
  return is_readable ? mosquitto_loop_read(client_.get(), 1) : MOSQ_ERR_SUCCESS;
}

// Leaves messages of QoS 1 and 2 to the broker while the queue is half full, for as long as the
// connection survives without a response to the keep-alive.
bool BrokerClient::Impl::should_read() {
  bool needed = false;
  {
    std::lock_guard lock(mutex_);
    for (const auto& subscription : subscriptions_) needed = needed || subscription.qos > 0;
  }
  if (!needed || options_.on_message || !received_.is_half_full()) {
    reads_paused_ = false;
    return true;
  }
  if (!reads_paused_.exchange(true)) paused_since_ = Clock::now();
  // receive() may have emptied the queue before it could see the flag.
  return !received_.is_half_full() ||
         Clock::now() - paused_since_ > std::chrono::seconds(options_.keep_alive) / 2;
}

void BrokerClient::Impl::connected() {
  std::unique_lock lock(mutex_);
  const auto subscriptions = subscriptions_;
  const auto kept = kept_;
  lock.unlock();
  for (const auto& [filter, qos] : subscriptions)
    mosquitto_subscribe(client_.get(), nullptr, filter.c_str(), qos);
  for (const auto& [topic, message] : kept)
    mosquitto_publish(client_.get(), nullptr, topic.c_str(),
                      static_cast<int>(message.payload.size()), message.payload.data(), message.qos,
                      true);
  is_open_ = true;
  lock.lock();
  connected_ = true;
  local_address_ = local_address_of(socket());
  ++counts_.connections;
  if (!first_) first_ = ok();
  changed_.notify_all();
}

void BrokerClient::Impl::disconnected() {
  checked_.reset();
  std::lock_guard lock(mutex_);
  connected_ = false;
  counts_.lost += sent_.lose_unacknowledged();
  changed_.notify_all();
}

void BrokerClient::Impl::say_goodbye() {
  mosquitto_disconnect(client_.get());
  const auto end = Clock::now() + kGoodbye;
  while (Clock::now() < end && step(10) == MOSQ_ERR_SUCCESS) {
  }
  while (Clock::now() < end && checked_ && checked_->has_unsent())
    if (is_writable(checked_->socket(), 10) && !checked_->send()) break;
}

void BrokerClient::Impl::wait_for_wake(std::chrono::milliseconds time) {
  const auto end = Clock::now() + time;
  while (!stopping_ && Clock::now() < end) {
    pollfd wait{.fd = wake_.descriptor(), .events = POLLIN, .revents = 0};
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now());
    if (poll(&wait, 1, static_cast<int>(left.count())) > 0) wake_.clear();
  }
}

}  // namespace weir::transport
