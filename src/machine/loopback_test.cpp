// Which hosts count as this machine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "loopback.hpp"

#include <gtest/gtest.h>

namespace weir {
namespace loopback_test {

TEST(Loopback, IsThisMachineByNameOrNumber) {
  for (const char* host : {"localhost", "LOCALHOST", "127.0.0.1", "127.8.9.10", "::1", "[::1]"})
    EXPECT_TRUE(is_loopback(host)) << host;
}

TEST(Loopback, IsNoOtherAddressAndNoNameThatBeginsOrEndsAlike) {
  for (const char* host :
       {"", "0.0.0.0", "::", "192.168.1.2", "localhost.example", "127.0.0.1.nip", "fe80::1",
        "128.0.0.1", "[", "[]", "[localhost", "127.1", "::ffff:127.0.0.1"})
    EXPECT_FALSE(is_loopback(host)) << host;
  EXPECT_FALSE(is_loopback({"localhost\0.example", 18})) << "a name with a zero byte";
}

}  // namespace loopback_test
}  // namespace weir
