// Tests the table of servers that a broker announces, and class 11 of
// docs/compatibility/edge-wire.md 10.6.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/announced_servers.hpp"

#include <gtest/gtest.h>

#include "core/wire/wire_test_support.hpp"
#include "says.hpp"

namespace weir::wire {
namespace announced_servers_test {

using namespace test;

Status announce(AnnouncedServers* table, std::string_view topic, std::string_view address) {
  return table->update(topic, from_text(address) + Bytes(1));
}

std::string hosts(const AnnouncedServers& table) {
  std::string out;
  for (const auto& server : table.servers()) out += server.address.to_string() + " ";
  return out;
}

TEST(AnnouncedServers, AreInTheOrderOfTheirAnnouncements) {
  AnnouncedServers table;
  EXPECT_TRUE(announce(&table, "a", "h1:1"));
  EXPECT_TRUE(announce(&table, "b", "h2:2"));
  EXPECT_EQ(hosts(table), "h1:1 h2:2 ");
  EXPECT_TRUE(announce(&table, "a", "h3:3"));
  EXPECT_EQ(hosts(table), "h2:2 h3:3 ");
}

TEST(AnnouncedServers, LeaveWhenTheyWithdraw) {
  AnnouncedServers table;
  EXPECT_TRUE(announce(&table, "a", "h1:1"));
  EXPECT_TRUE(announce(&table, "b", "h2:2"));
  EXPECT_TRUE(table.update("a", {}));
  EXPECT_TRUE(table.update("unknown", {}));
  EXPECT_EQ(hosts(table), "h2:2 ");
}

TEST(AnnouncedServers, StayWhenAPayloadIsNoAddress) {
  AnnouncedServers table;
  EXPECT_TRUE(announce(&table, "a", "h1:1"));
  EXPECT_REFUSED(announce(&table, "a", "h1"), PEER_MESSAGE_INVALID, "has no port");
  EXPECT_REFUSED(table.update("a", from_hex("61")), PEER_MESSAGE_INVALID, "has no end");
  EXPECT_EQ(hosts(table), "h1:1 ");
}

TEST(AnnouncedServers, HoldNoFloodOfAddresses) {
  AnnouncedServers table;
  for (size_t i = 0; i < 256; ++i)
    ASSERT_TRUE(announce(&table, "topic-" + std::to_string(i), "h:1"));
  EXPECT_REFUSED(announce(&table, "one-more", "h:1"), PEER_MESSAGE_INVALID,
                 "a broker announces too many servers\n"
                 "  offered: 257 servers, the last one at \"one-more\"\n  needed: at most 256");
  EXPECT_EQ(table.servers().size(), 256u);
  // A known server may still change, and one that leaves makes room.
  EXPECT_TRUE(announce(&table, "topic-7", "h:2"));
  EXPECT_TRUE(table.update("topic-8", {}));
  EXPECT_TRUE(announce(&table, "one-more", "h:1"));
}

}  // namespace announced_servers_test
}  // namespace weir::wire
