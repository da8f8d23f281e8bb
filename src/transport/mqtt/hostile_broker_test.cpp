// BrokerClient with brokers that send what no broker may, with and without TLS.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <csignal>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "becomes.hpp"
#include "core/wire/wire_test_support.hpp"
#include "says.hpp"
#include "transport/edge/stream_socket.hpp"
#include "transport/mqtt/broker_certificates.hpp"
#include "transport/mqtt/broker_client.hpp"
#include "transport/mqtt/server_discovery.hpp"

namespace weir::transport {
namespace hostile_broker_test {

using namespace std::chrono_literals;
using wire::test::Bytes;
using wire::test::from_hex;
using wire::test::operator+;

template <auto free>
struct Free {
  template <class T>
  void operator()(T* object) const {
    free(object);
  }
};
using Context = std::unique_ptr<SSL_CTX, Free<SSL_CTX_free>>;
using Tls = std::unique_ptr<SSL, Free<SSL_free>>;

// One connection, as the broker sees it. It ends the script when the client leaves.
class Connection {
 public:
  struct Ended {};
  Connection(io::Descriptor socket, SSL_CTX* context) : socket_(std::move(socket)) {
    if (!context) return;
    tls_.reset(SSL_new(context));
    SSL_set_fd(tls_.get(), socket_.get());
    if (SSL_accept(tls_.get()) != 1) throw Ended();
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void send(const Bytes& bytes) const {
    for (size_t sent = 0; sent < bytes.size();) {
      const size_t left = bytes.size() - sent;
      const ssize_t step = tls_ ? SSL_write(tls_.get(), bytes.data() + sent, static_cast<int>(left))
                                : ::send(socket_.get(), bytes.data() + sent, left, MSG_NOSIGNAL);
      if (step <= 0) throw Ended();
      sent += static_cast<size_t>(step);
    }
  }
  // The type of the next packet, which it reads.
  uint8_t read() const {
    const uint8_t type = byte();
    size_t size = 0;
    for (int shift = 0;; shift += 7) {
      const uint8_t part = byte();
      size |= size_t{part & 127u} << shift;
      if (part < 128) break;
    }
    for (; size > 0; --size) byte();
    return type >> 4;
  }
  void read_until(uint8_t type) const {
    while (read() != type) {
    }
  }
  // Accepts the client and its first subscription, which has the number 1.
  void accept() const {
    read_until(1);
    send(from_hex("20 03 00 00 00"));
    read_until(8);
    send(from_hex("90 04 00 01 00 00"));
  }
  void shut_down() const { shutdown(socket_.get(), SHUT_RDWR); }

 private:
  uint8_t byte() const {
    uint8_t out = 0;
    const ssize_t got = tls_ ? SSL_read(tls_.get(), &out, 1) : recv(socket_.get(), &out, 1, 0);
    if (got != 1) throw Ended();
    return out;
  }

  const io::Descriptor socket_;
  Tls tls_;
};

// Runs the script for one connection after the other, and keeps each until its client leaves.
class ScriptedBroker {
 public:
  using Script = std::function<void(const Connection&)>;
  ScriptedBroker(Script script, bool has_tls) : script_(std::move(script)) {
    auto listener = edge::listen_on("127.0.0.1", 0);
    EXPECT_TRUE(listener);
    listener_ = *std::move(listener);
    if (has_tls) {
      context_.reset(SSL_CTX_new(TLS_server_method()));
      SSL_CTX_use_certificate_chain_file(context_.get(), files_.file("broker.pem").c_str());
      SSL_CTX_use_PrivateKey_file(context_.get(), files_.file("broker.key").c_str(),
                                  SSL_FILETYPE_PEM);
    }
    thread_ = std::thread([this] { run(); });
  }
  ScriptedBroker(const ScriptedBroker&) = delete;
  ScriptedBroker& operator=(const ScriptedBroker&) = delete;
  ~ScriptedBroker() {
    shutdown(listener_.get(), SHUT_RDWR);
    thread_.join();
  }
  BrokerOptions options() const {
    BrokerOptions out;
    out.port = edge::get_port(listener_.get());
    out.version = MqttVersion::V5;
    if (context_) out.tls.ca = files_.file("ca.pem");
    return out;
  }

 private:
  void run() {
    sigset_t pipe;
    sigemptyset(&pipe);
    sigaddset(&pipe, SIGPIPE);
    pthread_sigmask(SIG_BLOCK, &pipe, nullptr);
    for (;;) {
      pollfd waiting{listener_.get(), POLLIN, 0};
      poll(&waiting, 1, -1);
      io::Descriptor socket(accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC));
      if (!socket && errno == EAGAIN) continue;
      if (!socket) return;
      try {
        const Connection connection(std::move(socket), context_.get());
        script_(connection);
        for (;;) connection.read();
      } catch (const Connection::Ended&) {
      }
    }
  }

  const test::BrokerCertificates files_{};
  const Script script_;
  Context context_;
  io::Descriptor listener_;
  std::thread thread_;
};

class HostileBrokerTest : public ::testing::Test {
 protected:
  ScriptedBroker::Script accept_and_send(Bytes bytes) {
    return [bytes = std::move(bytes)](const Connection& client) {
      client.accept();
      client.send(bytes);
    };
  }
  // A client that reports invalid packets.
  std::unique_ptr<BrokerClient> subscribed(const ScriptedBroker& broker) {
    auto options = broker.options();
    options.on_invalid_packet = [this](const Error& error) {
      const std::lock_guard lock(mutex_);
      reports_.push_back(error.message());
    };
    auto client = BrokerClient::open(std::move(options));
    EXPECT_TRUE(client) << client.error().message();
    if (!client) return nullptr;
    EXPECT_TRUE((*client)->subscribe("t", 0));
    return *std::move(client);
  }
  std::vector<std::string> reports() const {
    const std::lock_guard lock(mutex_);
    return reports_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> reports_;
};

// Without and with TLS.
class HostileBroker : public HostileBrokerTest, public ::testing::WithParamInterface<bool> {};

// A message "x" with 300,000 bytes of user properties.
Bytes large_message() {
  Bytes out = from_hex("30 e7 a7 12 00 01 74 e0 a7 12");
  for (int i = 0; i < 60'000; ++i) out = std::move(out) + from_hex("26 00 00 00 00");
  return std::move(out) + from_hex("78");
}

// libmosquitto 2.0.11 aborts the process at such a property.
TEST_P(HostileBroker, AnUnknownPropertyEndsTheConnectionOnly) {
  for (const char* packet :
       {"30 06 00 01 74 01 7f 78", "40 05 00 07 00 01 7f", "90 06 00 02 01 7f 00 00",
        "e0 03 00 01 7f", "f0 03 18 01 7f", "20 05 00 00 02 7f 00"}) {
    const ScriptedBroker broker(accept_and_send(from_hex(packet)), GetParam());
    const auto client = subscribed(broker);
    ASSERT_TRUE(client);
    EXPECT_TRUE(becomes_true([&] { return client->counts().connections > 1; }, "a new connection"));
    ASSERT_FALSE(reports().empty()) << packet;
    EXPECT_SAYS(reports().back(), "WEIR-6004: a packet of the broker cannot be read");
    EXPECT_SAYS(reports().back(), "offered: a property with the number 127");
  }
  EXPECT_EQ(reports().size(), 6u) << "one for each client";
}

TEST_P(HostileBroker, AnUnknownPropertyInTheFirstPacketIsAnErrorAtTheStart) {
  const ScriptedBroker broker(
      [](const Connection& client) {
        client.read();
        client.send(from_hex("20 05 00 00 02 7f 00"));
      },
      GetParam());
  EXPECT_REFUSED(BrokerClient::open(broker.options()), PEER_MESSAGE_INVALID,
                 "a property with the number 127");
}

TEST_P(HostileBroker, MessagesArriveInPiecesOfAnySize) {
  const Bytes message = from_hex("30 0f 00 01 74 07 26 00 01 61 00 01 62 61 62 63 64");
  const ScriptedBroker broker(
      [&](const Connection& client) {
        client.accept();
        for (const auto byte : message) client.send({byte});
        client.send(message + message);
      },
      GetParam());
  const auto client = subscribed(broker);
  ASSERT_TRUE(client);
  for (int i = 0; i < 3; ++i) {
    const auto received = client->receive(30s);
    ASSERT_TRUE(received);
    EXPECT_EQ(received->payload, wire::test::from_text("abcd"));
    EXPECT_EQ(received->properties.find("a"), "b");
  }
  EXPECT_TRUE(reports().empty());
}

// 16 MiB of them took 200 MB as objects. Everyone who may publish can send such a message.
TEST_F(HostileBrokerTest, AMessageWithTooManyPropertiesLosesThem) {
  const ScriptedBroker broker(accept_and_send(large_message() + from_hex("30 05 00 01 74 00 79")),
                              false);
  const auto client = subscribed(broker);
  ASSERT_TRUE(client);
  for (const char* payload : {"78", "79"}) {
    const auto received = client->receive(30s);
    ASSERT_TRUE(received);
    EXPECT_EQ(received->payload, from_hex(payload));
    EXPECT_TRUE(received->properties.user.empty());
  }
  EXPECT_EQ(client->counts().connections, 1u);
}

TEST_F(HostileBrokerTest, WhatCameBeforeAnInvalidPacketArrives) {
  const ScriptedBroker broker(
      accept_and_send(
          from_hex("30 05 00 01 74 00 78 30 05 00 01 74 00 79 30 06 00 01 74 01 7f 7a")),
      false);
  const auto client = subscribed(broker);
  ASSERT_TRUE(client);
  for (const char* payload : {"78", "79"}) {
    const auto received = client->receive(30s);
    ASSERT_TRUE(received);
    EXPECT_EQ(received->payload, from_hex(payload));
  }
  EXPECT_TRUE(becomes_true([&] { return reports().size() == 1; }, "a report"));
}

TEST_F(HostileBrokerTest, SubscriptionsOfTwoThreadsAreAcceptedAtOnce) {
  const ScriptedBroker broker(
      [](const Connection& client) {
        client.read_until(1);
        client.send(from_hex("20 03 00 00 00"));
        client.read_until(8);
        client.read_until(8);
        client.send(from_hex("90 04 00 01 00 00 90 04 00 02 00 00"));
      },
      false);
  const auto client = BrokerClient::open(broker.options());
  ASSERT_TRUE(client);
  std::thread other([&] { EXPECT_TRUE((*client)->subscribe("a", 0)); });
  EXPECT_TRUE((*client)->subscribe("b", 0));
  other.join();
}

// What is encrypted cannot be changed.
TEST_F(HostileBrokerTest, WithTlsAMessageWithTooManyPropertiesEndsTheConnection) {
  const ScriptedBroker broker(accept_and_send(large_message()), true);
  const auto client = subscribed(broker);
  ASSERT_TRUE(client);
  EXPECT_TRUE(becomes_true([&] { return client->counts().connections > 1; }, "a new connection"));
  ASSERT_FALSE(reports().empty());
  EXPECT_SAYS(reports()[0], "a message of the broker has too many properties");
}

// A stop of the element ends the wait.
TEST_F(HostileBrokerTest, AnAnnouncementToASilentBrokerCanBeInterrupted) {
  const ScriptedBroker broker(
      [](const Connection& client) {
        client.read();
        client.send(from_hex("20 03 00 00 00"));
      },
      false);
  const auto announcement =
      ServerAnnouncement::connect(broker.options(), "1", "t", {"127.0.0.1", 9});
  ASSERT_TRUE(announcement) << announcement.error().message();
  (*announcement)->interrupt(true);
  EXPECT_REFUSED((*announcement)->announce(), CANCELLED, "interrupted");
}

INSTANTIATE_TEST_SUITE_P(Connection, HostileBroker, ::testing::Bool(),
                         [](const auto& info) { return info.param ? "Tls" : "Plain"; });

}  // namespace hostile_broker_test
}  // namespace weir::transport
