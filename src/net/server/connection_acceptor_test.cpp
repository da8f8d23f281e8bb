// Names of peers, and which connections a ConnectionAcceptor ends. In the place of gRPC: a test
// that has the other descriptor of each connection.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <condition_variable>
#include <deque>

#include "net/server/connection_acceptor.hpp"
#include "net/server/peer_name.hpp"
#include "says.hpp"

namespace weir::net {
namespace connection_acceptor_test {

TEST(PeerName, HasTheHostAndWhatItsOwnerHasOneOf) {
  EXPECT_EQ(peer_host("ipv4:192.0.2.1:50000"), "192.0.2.1");
  EXPECT_EQ(peer_network("ipv4:192.0.2.1:50000"), "192.0.2.1");
  EXPECT_EQ(peer_host("ipv6:%5B2001:db8::1%5D:50000"), "2001:db8::1");
  EXPECT_EQ(peer_host("ipv6:[2001:db8::1]:50000"), "2001:db8::1");
  EXPECT_EQ(peer_network("ipv6:%5B2001:db8:1:2:3:4:5:6%5D:50000"), "2001:db8:1:2::/64");
  EXPECT_EQ(peer_network("ipv6:%5B2001:db8:1:2:ffff::%5D:7"), "2001:db8:1:2::/64");
  EXPECT_EQ(peer_network("ipv6:%5B2001:db8:1:3::1%5D:7"), "2001:db8:1:3::/64");
  EXPECT_EQ(peer_host("ipv6:%5Bfe80::1%252%5D:50000"), "fe80::1");
  EXPECT_EQ(peer_host("unix:/run/weir"), "");
  EXPECT_EQ(peer_network("unix:/run/weir"), "unix:");
  EXPECT_EQ(plain_peer_name("ipv6:%5B::1%5D:50000"), "ipv6:::1:50000");
  EXPECT_EQ(plain_peer_name("ipv4:127.0.0.1:50000"), "ipv4:127.0.0.1:50000");
}

// What one connection costs over time, at a look each quarter of a second.
class Cost {
 public:
  // Receives and acknowledges so many bytes from one look to the next. False: too much.
  bool look(uint64_t received, uint64_t acknowledged) {
    now_ += std::chrono::milliseconds(250);
    traffic_.received += received;
    traffic_.acknowledged += acknowledged;
    return !cost_.is_too_high(traffic_, 0, now_);
  }
  bool pass(std::chrono::hours time, uint64_t received, uint64_t acknowledged) {
    constexpr int kLooks = 4 * 3600;
    for (int64_t i = 0; i < time.count() * kLooks; ++i)
      if (!look(received, acknowledged)) return false;
    return true;
  }

 private:
  ConnectionCost::Time now_ = std::chrono::steady_clock::now();
  Traffic traffic_;
  ConnectionCost cost_;
};

constexpr uint64_t kPing = 17, kPingTls = 39;  // bytes on the wire

TEST(ConnectionCost, AClientThatOnlyPingsGoesOnForYears) {
  Cost slow;
  for (int i = 0; i < 2 * 365 * 24 * 360; ++i)  // one each ten seconds, as of this server
    ASSERT_TRUE(slow.look(kPingTls, kPingTls)) << "after " << i << " pings";
  Cost fast;  // ten a second, the most that gRPC allows here
  EXPECT_TRUE(fast.pass(std::chrono::hours(100), 3 * kPingTls, 3 * kPingTls));
}

TEST(ConnectionCost, AFloodOfPingsEnds) {
  Cost flood;
  EXPECT_FALSE(flood.pass(std::chrono::hours(1), 1000 * kPing, 1000 * kPing));
}

TEST(ConnectionCost, BytesWithoutAnAnswerAreNotForgotten) {
  Cost slow;  // headers that never end, while it answers the pings of this server
  EXPECT_FALSE(slow.pass(std::chrono::hours(20), 20, 1));
  Cost after_a_response;  // of 100 MB
  EXPECT_TRUE(after_a_response.look(0, 100'000'000));
  EXPECT_FALSE(after_a_response.look(3 << 20, 0));
}

class Accepting : public ::testing::Test {
 protected:
  void listen(const ListenOptions& options) {
    listen(options, [this](int socket) {
      const std::lock_guard lock(mutex_);
      accepted_.emplace_back(socket);
      changed_.notify_all();
    });
  }
  void listen(const ListenOptions& options, ConnectionAcceptor::Connected connected) {
    auto made = ConnectionAcceptor::listen(options);
    ASSERT_TRUE(made) << made.error().message();
    acceptor_ = *std::move(made);
    acceptor_->start(std::move(connected));
  }
  // As gRPC, which reads a new connection as long as data come; until its end here.
  void listen_and_read() {
    ListenOptions options;
    options.host = "127.0.0.1";
    listen(options, [this](int socket) {
      const io::Descriptor served(socket);
      pollfd readable{socket, POLLIN, 0};
      std::vector<char> bytes(64 << 10);
      while (poll(&readable, 1, -1) > 0 && read(socket, bytes.data(), bytes.size()) > 0) {
      }
      const std::lock_guard lock(mutex_);
      ++ended_;
      changed_.notify_all();
    });
  }
  void TearDown() override { acceptor_.reset(); }

  io::Descriptor connect(const char* from = "127.0.0.1") const {
    io::Descriptor out(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    inet_pton(AF_INET, from, &address.sin_addr);
    EXPECT_EQ(bind(out.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    address.sin_port = htons(static_cast<uint16_t>(acceptor_->port()));
    inet_pton(AF_INET, "127.0.0.1", &address.sin_addr);
    EXPECT_EQ(::connect(out.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    return out;
  }
  // What gRPC would have got.
  io::Descriptor accepted() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !accepted_.empty(); });
    io::Descriptor out = std::move(accepted_.front());
    accepted_.pop_front();
    return out;
  }
  bool has_accepted() {
    const std::lock_guard lock(mutex_);
    return !accepted_.empty();
  }
  static bool ends(const io::Descriptor& socket) {
    char byte = 0;
    return read(socket.get(), &byte, 1) <= 0;
  }

  // Sends bytes and receives them. False when the connection ends before all were sent.
  static bool transfer(const io::Descriptor& from, const io::Descriptor& to, size_t count) {
    std::vector<char> bytes(64 << 10);
    for (size_t sent = 0; sent < count; sent += bytes.size()) {
      if (send(from.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL) <= 0) return false;
      for (size_t got = 0; got < bytes.size();) {
        const ssize_t part = recv(to.get(), bytes.data(), bytes.size() - got, 0);
        if (part == 0) return false;
        if (part > 0) got += static_cast<size_t>(part);
      }
    }
    return true;
  }
  // Returns when the acceptor has looked at what all connections have received: then it ends one
  // that sends without calls.
  void wait_for_look(const char* from) {
    const io::Descriptor client = connect(from);
    const io::Descriptor served = accepted();
    EXPECT_FALSE(transfer(client, served, size_t{1} << 40));
  }

  std::unique_ptr<ConnectionAcceptor> acceptor_;
  std::mutex mutex_;  // guards the rest
  std::condition_variable changed_;
  std::deque<io::Descriptor> accepted_;
  int ended_ = 0;  // after listen_and_read()
};

TEST_F(Accepting, LimitsWhatOneAddressHasOpenUntilOneEnds) {
  ListenOptions options;
  options.host = "127.0.0.1";
  options.max_address_connections = 1;  // eight may be open
  listen(options);
  std::vector<io::Descriptor> clients, served;
  for (int i = 0; i < 8; ++i) {
    clients.push_back(connect());
    served.push_back(accepted());
  }
  EXPECT_TRUE(ends(connect()));
  const io::Descriptor other = connect("127.0.0.2");
  served.push_back(accepted());
  EXPECT_EQ(acceptor_->refused(), 1u);
  shutdown(served[0].get(), SHUT_RDWR);  // as gRPC ends a connection
  EXPECT_TRUE(ends(clients[0]));
  while (!has_accepted()) connect();  // until the acceptor has seen the end
}

TEST_F(Accepting, EndsTheOldestWithoutACallWhenThereAreTooMany) {
  ListenOptions options;
  options.host = "127.0.0.1";
  options.max_connections = 1;  // eight may be open
  options.max_address_connections = 0;
  listen(options);
  std::vector<io::Descriptor> clients, served;
  for (int i = 0; i < 8; ++i) {
    clients.push_back(connect());
    served.push_back(accepted());
    if (i != 2) acceptor_->call_began(peer_name(served.back().get()));
  }
  const io::Descriptor one = connect();
  const io::Descriptor one_served = accepted();
  EXPECT_TRUE(ends(clients[2]));
  acceptor_->call_began(peer_name(one_served.get()));
  EXPECT_TRUE(ends(connect()));
  EXPECT_EQ(acceptor_->refused(), 2u);
}

TEST_F(Accepting, EndsAConnectionWithTooManyCallsThatHaveNotEnded) {
  ListenOptions options;
  options.host = "127.0.0.1";
  options.max_requests = 1;
  listen(options);
  const io::Descriptor client = connect();
  const io::Descriptor served = accepted();
  const io::Descriptor other = connect();
  const io::Descriptor other_served = accepted();
  const std::string peer = peer_name(served.get());
  const uint32_t limit = 2 * max_streams(options);
  for (uint32_t i = 0; i < 2 * limit; ++i) {  // those that end do not count
    acceptor_->call_began(peer);
    acceptor_->call_ended(peer);
  }
  for (uint32_t i = 0; i < limit; ++i) acceptor_->call_began(peer);
  EXPECT_EQ(acceptor_->refused(), 0u);
  acceptor_->call_began(peer);
  EXPECT_TRUE(ends(client));
  EXPECT_EQ(acceptor_->refused(), 1u);
  EXPECT_TRUE(ends(connect())) << "its address must wait";
  const io::Descriptor third = connect("127.0.0.2");
  const io::Descriptor third_served = accepted();
  EXPECT_EQ(write(other.get(), "x", 1), 1);
  EXPECT_FALSE(ends(other_served));
}

TEST_F(Accepting, EndsAConnectionThatReceivesMoreThanItsMessages) {
  ListenOptions options;
  options.host = "127.0.0.1";
  options.max_bytes = 1024;
  listen(options);
  const io::Descriptor client = connect();
  const io::Descriptor served = accepted();
  const std::string peer = peer_name(served.get());
  acceptor_->call_began(peer);
  EXPECT_FALSE(transfer(client, served, size_t{1} << 40));
}

TEST_F(Accepting, KeepsAConnectionWhoseCallEndsBeforeItsMessageHasCome) {
  ListenOptions options;
  options.host = "127.0.0.1";
  listen(options);
  const io::Descriptor client = connect();
  const io::Descriptor served = accepted();
  const std::string peer = peer_name(served.get());
  acceptor_->call_began(peer);
  wait_for_look("127.0.0.2");
  EXPECT_TRUE(transfer(client, served, 8 << 20));
  acceptor_->call_ended(peer);  // at its deadline, for example
  wait_for_look("127.0.0.3");
  EXPECT_EQ(acceptor_->refused(), 2u) << "those that wait_for_look() made";
  EXPECT_TRUE(transfer(client, served, 1));
}

TEST_F(Accepting, EndsAConnectionThatSendsWithoutAPause) {
  listen_and_read();
  const io::Descriptor client = connect();
  const std::vector<char> bytes(64 << 10);
  pollfd open{client.get(), POLLOUT | POLLRDHUP, 0};  // the end may come while no byte fits
  size_t sent = 0;
  while (sent < size_t{4} << 30 && poll(&open, 1, -1) > 0 && open.revents == POLLOUT) {
    const ssize_t part =
        send(client.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (part > 0) sent += static_cast<size_t>(part);
  }
  EXPECT_LT(sent, size_t{4} << 30);
  EXPECT_EQ(acceptor_->refused(), 1u);
}

TEST_F(Accepting, AcceptsAndStopsWhileAConnectionIsRead) {
  listen_and_read();
  const io::Descriptor client = connect();
  { const io::Descriptor other = connect("127.0.0.2"); }
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return ended_ == 1; });
  }
  acceptor_->stop();
  EXPECT_TRUE(ends(client));
  EXPECT_EQ(ended_, 2);
}

TEST_F(Accepting, ListensOnNamesAddressesAndPaths) {
  const std::string path = testing::TempDir() + "weir-acceptor-" + std::to_string(getpid());
  ListenOptions unix_options;
  unix_options.unix_path = path;
  const auto first = ConnectionAcceptor::listen(unix_options);
  ASSERT_TRUE(first);
  EXPECT_EQ((*first)->port(), 0u);
  EXPECT_FALSE(ConnectionAcceptor::listen(unix_options)) << "another server has it";
  ListenOptions options;
  options.host = "localhost";
  const auto named = ConnectionAcceptor::listen(options);
  ASSERT_TRUE(named);
  EXPECT_NE((*named)->port(), 0u);
  options.port = (*named)->port();
  const auto used = ConnectionAcceptor::listen(options);
  EXPECT_REFUSED(used, OPTION_VALUE, "the server cannot listen on this address");
  options.host = "no.such.host.invalid";
  EXPECT_FALSE(ConnectionAcceptor::listen(options));
}

}  // namespace connection_acceptor_test
}  // namespace weir::net
