// Servers announced by a broker: bytes, withdrawal, a broker that restarts, and hostile messages
// (docs/compatibility/edge-wire.md 10.6, class 11).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/mqtt/server_discovery.hpp"

#include <sys/prctl.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <thread>

#include "says.hpp"
#include "transport/mqtt/broker_test_support.hpp"
#include "transport/wake_event.hpp"

namespace weir::transport {
namespace server_discovery_test {

using namespace std::chrono_literals;
using test::TestBroker;
using Addresses = std::vector<wire::HostAddress>;

class ServerDiscovery : public test::BrokerTest {
 protected:
  static BrokerOptions options(const TestBroker& broker) {
    BrokerOptions out;
    out.port = broker.port();
    return out;
  }
  static std::unique_ptr<ServerAnnouncement> announce(const TestBroker& broker, const char* id,
                                                      uint16_t port) {
    auto out = ServerAnnouncement::open(options(broker), id, "objects", {"127.0.0.1", port});
    EXPECT_TRUE(out) << out.error().message();
    return *std::move(out);
  }
  static std::unique_ptr<ServerDirectory> directory(const TestBroker& broker) {
    auto out = ServerDirectory::open(options(broker), "objects");
    EXPECT_TRUE(out) << out.error().message();
    return *std::move(out);
  }
  static std::unique_ptr<BrokerClient> client(const TestBroker& broker) {
    return *BrokerClient::open(options(broker));
  }
  static bool has(const ServerDirectory& directory, const Addresses& wanted) {
    return becomes_true(
        [&] {
          return std::ranges::equal(directory.servers(), wanted, {},
                                    &wire::AnnouncedServers::Server::address);
        },
        "the servers");
  }
};

TEST_F(ServerDiscovery, AnnouncesTheBytesOfThePage) {
  const TestBroker broker;
  const auto server = announce(broker, "7", 4100);
  const auto peer = client(broker);
  ASSERT_TRUE(peer->subscribe("#", 1));
  const auto message = peer->receive(30s);
  ASSERT_TRUE(message);
  EXPECT_EQ(message->topic, "edge/inference/device-7/objects/");
  EXPECT_TRUE(message->retained);
  const std::string_view text("127.0.0.1:4100\0", 15);
  ASSERT_EQ(message->payload.size(), text.size());
  EXPECT_EQ(std::memcmp(message->payload.data(), text.data(), text.size()), 0);
}

TEST_F(ServerDiscovery, FindsServersAndForgetsThoseThatEnd) {
  const TestBroker broker;
  auto first = announce(broker, "1", 4101);
  const auto clients = directory(broker);
  EXPECT_TRUE(has(*clients, {{"127.0.0.1", 4101}}));
  const uint64_t version = clients->version();
  const auto second = announce(broker, "2", 4102);
  EXPECT_TRUE(clients->wait_for_change(version, io::deadline_in(30s), -1));
  EXPECT_TRUE(has(*clients, {{"127.0.0.1", 4101}, {"127.0.0.1", 4102}}));
  first.reset();
  EXPECT_TRUE(has(*clients, {{"127.0.0.1", 4102}}));
  EXPECT_TRUE(has(*directory(broker), {{"127.0.0.1", 4102}}));
}

constexpr char kBrokerPort[] = "WEIR_TEST_BROKER_PORT";

// Run by the test below in a separate process, which is killed.
TEST_F(ServerDiscovery, DISABLED_AnnouncesUntilItIsKilled) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  BrokerOptions broker;
  broker.port = static_cast<uint16_t>(std::atoi(getenv(kBrokerPort)));
  const auto announced = ServerAnnouncement::open(broker, "1", "objects", {"127.0.0.1", 4101});
  while (announced) pause();
}

TEST_F(ServerDiscovery, ForgetsAServerThatWasKilled) {
  const TestBroker broker;
  const auto clients = directory(broker);
  setenv(kBrokerPort, std::to_string(broker.port()).c_str(), 1);
  test::Process server({"/proc/self/exe", "--gtest_also_run_disabled_tests",
                        "--gtest_filter=*DISABLED_AnnouncesUntilItIsKilled"});
  unsetenv(kBrokerPort);
  EXPECT_TRUE(has(*clients, {{"127.0.0.1", 4101}}));
  server.end(SIGKILL);
  EXPECT_TRUE(has(*clients, {}));
}

TEST_F(ServerDiscovery, AnnouncesAgainToABrokerThatForgot) {
  TestBroker broker;
  const auto server = announce(broker, "1", 4101);
  broker.stop();
  broker.start();
  const auto clients = directory(broker);
  EXPECT_TRUE(has(*clients, {{"127.0.0.1", 4101}}));
}

TEST_F(ServerDiscovery, AnnouncesTheAddressThatReachesTheBroker) {
  const TestBroker broker;
  const auto server = ServerAnnouncement::open(options(broker), "1", "objects", {"", 4101});
  ASSERT_TRUE(server);
  EXPECT_EQ((*server)->address().to_string(), "127.0.0.1:4101");
}

TEST_F(ServerDiscovery, IgnoresHostileMessages) {
  const TestBroker broker;
  const auto clients = directory(broker);
  const auto peer = client(broker);
  const auto publish = [&](const std::string& id, std::string_view payload) {
    ASSERT_TRUE(peer->publish({.topic = "edge/inference/device-" + id + "/objects/",
                               .payload = std::as_bytes(std::span(payload)),
                               .qos = 1},
                              30s));
  };
  publish("1", "x");
  publish("2", "");
  publish("3", "127.0.0.1:4100");  // no NUL
  publish("4", std::string_view("host:0\0", 7));
  publish("5", std::string_view("no colon\0", 9));
  publish("6", std::string(100000, 'x'));
  publish("7", std::string_view("127.0.0.1:4100\0", 15));
  EXPECT_TRUE(has(*clients, {{"127.0.0.1", 4100}}));
  EXPECT_EQ(clients->refused(), 5u);
}

TEST_F(ServerDiscovery, KeepsAtMost256ServersOfAFlood) {
  const TestBroker broker;
  const auto clients = directory(broker);
  const auto peer = client(broker);
  const std::string_view payload("127.0.0.1:4100\0", 15);
  for (int i = 0; i < 1000; ++i)
    ASSERT_TRUE(peer->publish({.topic = "edge/inference/device-" + std::to_string(i) + "/objects/",
                               .payload = std::as_bytes(std::span(payload)),
                               .qos = 1},
                              30s));
  EXPECT_TRUE(becomes_true([&] { return clients->refused() == 744; }, "744 servers too many"));
  EXPECT_EQ(clients->servers().size(), 256u);
}

TEST_F(ServerDiscovery, RejectsTopicsWithWildcards) {
  BrokerOptions nowhere;
  EXPECT_REFUSED(ServerDirectory::open(nowhere, "a/#"), OPTION_VALUE, "offered: \"a/#\"");
  EXPECT_REFUSED(ServerDirectory::open(nowhere, std::string("a\0", 2)), OPTION_VALUE, "a\\x00");
  EXPECT_REFUSED(ServerAnnouncement::open(nowhere, "a/b", "objects", {"h", 1}), OPTION_VALUE, "id");
  EXPECT_REFUSED(ServerAnnouncement::open(nowhere, "1", "", {"h", 1}), OPTION_VALUE, "topic");
}

size_t open_descriptors() {
  const std::filesystem::directory_iterator all("/proc/self/fd");
  return static_cast<size_t>(std::distance(begin(all), end(all)));
}

TEST_F(ServerDiscovery, AStormOfServersAndClientsLeavesNothingBehind) {
  const TestBroker broker;
  client(broker).reset();  // what the libraries open once
  const size_t before = open_descriptors();
  {
    std::vector<std::jthread> storm;
    for (int thread = 0; thread < 8; ++thread)
      storm.emplace_back([&, thread] {
        for (int i = 0; i < 20; ++i) {
          const auto server = announce(broker, std::to_string(thread).c_str(), 4100);
          const auto servers = directory(broker);
          EXPECT_TRUE(becomes_true([&] { return !servers->servers().empty(); }, "a server"));
        }
      });
  }
  EXPECT_TRUE(has(*directory(broker), {}));
  EXPECT_EQ(open_descriptors(), before);
}

TEST_F(ServerDiscovery, WaitsNoLongerWhenInterrupted) {
  const TestBroker broker;
  const auto clients = directory(broker);
  transport::WakeEvent interruption;
  std::jthread waiting([&] {
    EXPECT_FALSE(
        clients->wait_for_change(clients->version(), std::nullopt, interruption.descriptor()));
  });
  interruption.set();
  waiting.join();
  EXPECT_FALSE(clients->wait_for_change(clients->version(), io::deadline_in(1ms), -1));
}

}  // namespace server_discovery_test
}  // namespace weir::transport
