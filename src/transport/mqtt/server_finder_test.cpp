// Which announced server goes first, and when one that failed is tried again.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/mqtt/server_finder.hpp"

#include <gtest/gtest.h>

namespace weir::transport {
namespace server_finder_test {

using namespace std::chrono_literals;
using Server = ServerChoice::Server;
using Servers = std::vector<Server>;

const Server kFirst{"a", {"h", 1}, 1}, kSecond{"b", {"h", 2}, 2}, kThird{"c", {"h", 3}, 3};
constexpr ServerChoice::Clock::time_point kStart{};

// The port of the chosen server, or 0.
int chosen(ServerChoice* choice, const Servers& servers, std::chrono::milliseconds after = 0ms) {
  const auto server = choice->choose(servers, kStart + after);
  return server ? server->address.port : 0;
}

TEST(ServerChoice, TakesTheOldestAnnouncement) {
  ServerChoice choice;
  EXPECT_EQ(chosen(&choice, {kFirst, kSecond}), 1);
  EXPECT_EQ(chosen(&choice, {kSecond, kThird}), 2);
  EXPECT_EQ(chosen(&choice, {}), 0);
  EXPECT_FALSE(choice.next_retry());
}

TEST(ServerChoice, GoesOnWithTheNextOneAfterAFailure) {
  ServerChoice choice;
  const Servers all{kFirst, kSecond, kThird};
  choice.failed(kFirst, kStart);
  EXPECT_EQ(chosen(&choice, all), 2);
  choice.failed(kSecond, kStart + 100ms);
  EXPECT_EQ(chosen(&choice, all, 5s), 3);
}

TEST(ServerChoice, TriesTheOneThatFailedFirstAgainAfterASecond) {
  ServerChoice choice;
  const Servers both{kFirst, kSecond};
  choice.failed(kSecond, kStart);
  choice.failed(kFirst, kStart + 100ms);
  EXPECT_EQ(chosen(&choice, both, 999ms), 0);
  EXPECT_EQ(choice.next_retry(), kStart + 1s);
  EXPECT_EQ(chosen(&choice, both, 1000ms), 2);
  choice.failed(kSecond, kStart + 1000ms);
  EXPECT_EQ(chosen(&choice, both, 1099ms), 0);
  EXPECT_EQ(chosen(&choice, both, 1100ms), 1);
}

TEST(ServerChoice, TriesAServerThatAnnouncesItselfAgainAtOnce) {
  ServerChoice choice;
  choice.failed(kFirst, kStart);
  EXPECT_EQ(chosen(&choice, {kFirst}), 0);
  EXPECT_EQ(chosen(&choice, {Server{"a", {"h", 1}, 4}}), 1);
}

TEST(ServerChoice, ForgetsAServerThatIsWithdrawn) {
  ServerChoice choice;
  choice.failed(kFirst, kStart);
  EXPECT_EQ(chosen(&choice, {}), 0);
  EXPECT_FALSE(choice.next_retry());
}

}  // namespace server_finder_test
}  // namespace weir::transport
