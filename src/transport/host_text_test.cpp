// Tests the spellings of hosts.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/host_text.hpp"

#include <gtest/gtest.h>

namespace weir::transport {
namespace host_text_test {

std::string read(std::string_view text) {
  const HostText out = read_host(text);
  return out.host + (out.port ? " " + std::to_string(*out.port) : "");
}

TEST(HostText, LosesTheSchemesOfBrokers) {
  EXPECT_EQ(read("tcp://localhost"), "localhost");
  EXPECT_EQ(read("mqtt://192.168.1.2"), "192.168.1.2");
  EXPECT_EQ(read("TCP://broker.lan/"), "broker.lan");
  EXPECT_EQ(read("localhost"), "localhost");
  EXPECT_EQ(read(""), "");
}

TEST(HostText, HasAPortBehindTheHost) {
  EXPECT_EQ(read("localhost:1884"), "localhost 1884");
  EXPECT_EQ(read("tcp://127.0.0.1:65535"), "127.0.0.1 65535");
  EXPECT_EQ(read("[::1]:1883"), "[::1] 1883");
  EXPECT_EQ(read("mqtt://[fe80::1]"), "[fe80::1]");
}

TEST(HostText, RemainsWhereThereIsNoPort) {
  for (const char* text : {"::1", "fe80::1:80", "localhost:", "localhost:0", "localhost:65536",
                           "localhost:x", ":80", "ws://broker", "ssl://broker:8883x"})
    EXPECT_EQ(read(text), text);
}

TEST(HostText, YieldsToAPortThatTheUserSet) {
  std::string host = "tcp://broker:1884";
  uint32_t port = 1883;
  read_address(&host, &port, 1883);
  EXPECT_EQ(host, "broker");
  EXPECT_EQ(port, 1884u);
  host = "broker:1884";
  port = 1900;
  read_address(&host, &port, 1883);
  EXPECT_EQ(host, "broker");
  EXPECT_EQ(port, 1900u);
}

TEST(HostText, HasNoBlanks) {
  for (const char* text : {"localhost", "::1", "", "host-1.lan",
                           "b\xc3\xbc"
                           "cher.example"})
    EXPECT_TRUE(may_be_host(text)) << text;
  for (const char* text : {"invalid host", " ", "host\n", "a\tb"})
    EXPECT_FALSE(may_be_host(text)) << text;
}

}  // namespace host_text_test
}  // namespace weir::transport
