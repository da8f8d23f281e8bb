// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/mqtt/checked_socket.hpp"

#include <fcntl.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

#include "core/wire/peer_error.hpp"

namespace weir::transport {
namespace {

constexpr size_t kBufferBytes = 65536;
constexpr size_t kRecordHeader = 5;  // of TLS: type, version, size
constexpr size_t kMaxEncryptedRecord = 16384 + 2048;

SSL* tls_of(mosquitto* client) {
  return static_cast<SSL*>(mosquitto_ssl_get(client));
}

bool would_wait() {
  return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
}

Error no_descriptor() {
  return Error{.code = Code::OUT_OF_MEMORY,
               .what = "the packets of the MQTT broker cannot be checked",
               .offered = std::strerror(errno),
               .needed = "three free file descriptors",
               .fix = "ulimit -n $(ulimit -Hn), in the shell that starts the program"};
}

// A client that has read all has room for a record, unless its socket is smaller than one.
Error partial_record(size_t passed, size_t size) {
  return Error{.code = Code::LIMIT_EXCEEDED,
               .what = "a record of TLS does not fit into a socket of this machine",
               .offered = std::to_string(passed) + " of " + std::to_string(size) + " bytes fit",
               .needed = "net.core.wmem_default of at least 65536",
               .fix = "sysctl -w net.core.wmem_default=212992"};
}

}  // namespace

Result<std::unique_ptr<CheckedSocket>> CheckedSocket::replace_socket_of(mosquitto* client) {
  const int socket = mosquitto_socket(client);
  const SSL* const ssl = tls_of(client);
  const bool is_within_record =
      ssl && (SSL_has_pending(ssl) || std::string_view(SSL_rstate_string(ssl)) != "RH");
  if (is_within_record)
    return Error{.code = Code::BROKER_UNREACHABLE,
                 .what = "the broker answered too early",
                 .offered = "a part of its first answer of TLS",
                 .needed = "an answer after the connection is made",
                 .fix = "start the pipeline again, or protocol=4, which is MQTT 3.1.1"};
  std::array<int, 2> pair{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, pair.data()) != 0)
    return no_descriptor();
  const io::Descriptor outer(pair[0]);
  io::Descriptor inner(pair[1]), broker(fcntl(socket, F_DUPFD_CLOEXEC, 0));
  if (!broker || dup3(outer.get(), socket, O_CLOEXEC) < 0) return no_descriptor();
  return std::unique_ptr<CheckedSocket>(
      new CheckedSocket(client, std::move(broker), std::move(inner)));
}

CheckedSocket::CheckedSocket(mosquitto* client, io::Descriptor broker, io::Descriptor inner)
    : client_(client),
      broker_(std::move(broker)),
      inner_(std::move(inner)),
      buffer_(kBufferBytes) {}

short CheckedSocket::events(bool reads) const {
  const bool receives = reads && !is_closed_ && !has_more();
  return static_cast<short>((receives ? POLLIN : 0) | (has_unsent() ? POLLOUT : 0));
}

void CheckedSocket::fill() {
  if (is_closed_ || has_more()) return;
  received_.erase(received_.begin(), received_.begin() + static_cast<ptrdiff_t>(passed_));
  passed_ = 0;
  const ssize_t got = recv(broker_.get(), buffer_.data(), buffer_.size(), MSG_DONTWAIT);
  is_closed_ = got == 0 || (got < 0 && !would_wait());
  if (got <= 0) return;
  const auto bytes = std::span(buffer_).first(static_cast<size_t>(got));
  if (tls_of(client_))
    received_.insert(received_.end(), bytes.begin(), bytes.end());
  else
    status_ = filter_.feed(bytes, &received_);
}

// The bytes of the record that has begun to arrive; all bytes where it is none, which the client
// finds out; 0 while its end is not there.
size_t CheckedSocket::record_size() const {
  const auto bytes = std::span(received_).subspan(passed_);
  if (bytes.size() < kRecordHeader) return 0;
  constexpr std::byte kMajorVersion{3};
  const size_t size = std::to_integer<size_t>(bytes[3]) << 8 | std::to_integer<size_t>(bytes[4]);
  if (bytes[1] != kMajorVersion || size > kMaxEncryptedRecord) return bytes.size();
  return kRecordHeader + size <= bytes.size() ? kRecordHeader + size : 0;
}

size_t CheckedSocket::passable() const {
  return tls_of(client_) ? record_size() : received_.size() - passed_;
}

// Whether it has not read what it was given before.
bool CheckedSocket::is_client_busy() const {
  SSL* const ssl = tls_of(client_);
  int unread = 0;
  return (ssl && SSL_pending(ssl) > 0) ||
         (ioctl(mosquitto_socket(client_), FIONREAD, &unread) == 0 && unread > 0);
}

Status CheckedSocket::check_record() {
  SSL* const ssl = tls_of(client_);
  is_established_ = is_established_ || SSL_is_init_finished(ssl);  // and stays: renegotiations
  if (!is_established_) return ok();
  const int size = SSL_peek(ssl, buffer_.data(), static_cast<int>(buffer_.size()));
  if (size <= 0) return ok();  // the client sees that too
  std::vector<std::byte> ignored;
  auto status = filter_.feed(std::span(buffer_).first(static_cast<size_t>(size)), &ignored);
  if (!status) return status;
  if (filter_.replaced() > 0)
    return wire::peer_error("the broker refuses a message for a reason that MQTT 5 does not list",
                            "another reason", "one of chapter 3.4.2.1",
                            "protocol=4, which is MQTT 3.1.1");
  if (filter_.stripped() == 0) return status;
  return wire::peer_error("a message of the broker has too many properties",
                          "more than " + std::to_string(wire::kMaxMqttPropertyBytes) + " bytes",
                          "caps and times", "protocol=4, which is MQTT 3.1.1");
}

Result<bool> CheckedSocket::receive(int revents) {
  if (is_client_busy()) return true;
  if (revents & (POLLIN | POLLHUP | POLLERR)) fill();
  const size_t size = passable();
  if (size == 0) {
    if (!status_) return status_.error();
    if (is_closed_) shutdown(inner_.get(), SHUT_WR);
    return is_closed_;
  }
  const ssize_t passed =
      ::send(inner_.get(), received_.data() + passed_, size, MSG_DONTWAIT | MSG_NOSIGNAL);
  if (passed > 0) passed_ += static_cast<size_t>(passed);
  if (!tls_of(client_)) return true;
  if (passed > 0 && static_cast<size_t>(passed) != size)
    return partial_record(static_cast<size_t>(passed), size);
  auto status = check_record();
  return status ? Result<bool>(true) : Result<bool>(status.error());
}

bool CheckedSocket::send() {
  for (;;) {
    if (!has_unsent()) {
      const ssize_t got = recv(inner_.get(), buffer_.data(), buffer_.size(), MSG_DONTWAIT);
      if (got <= 0) return true;
      unsent_.assign(buffer_.begin(), buffer_.begin() + got);
      sent_ = 0;
    }
    const ssize_t sent = ::send(broker_.get(), unsent_.data() + sent_, unsent_.size() - sent_,
                                MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent < 0) return would_wait();
    sent_ += static_cast<size_t>(sent);
  }
}

}  // namespace weir::transport
