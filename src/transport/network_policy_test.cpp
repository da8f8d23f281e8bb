// Which connections need TLS.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/network_policy.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "says.hpp"

namespace weir::transport {
namespace network_policy_test {

config::Configuration settings(const char* require_tls) {
  return config::Configuration([require_tls](const char* name) -> const char* {
    if (!std::strcmp(name, "WEIR_CONFIG")) return "";
    return std::strcmp(name, "WEIR_NETWORK_REQUIRE_TLS") ? nullptr : require_tls;
  });
}
Endpoint to(const char* host) {
  return {.host = host, .port = 1883, .tls_fix = "tls-ca=ca.pem port=8883"};
}
Endpoint on(const char* host) {
  return {.role = Role::Listens, .host = host, .port = 3000};
}
std::string get_warning(const Endpoint& endpoint, const char* require_tls = nullptr) {
  const auto result = check_old_protocol(endpoint, settings(require_tls));
  if (!result) return "error " + result.error().message();
  return *result ? (*result)->message() : "";
}

TEST(NetworkPolicy, AllowsThePeersOfAList) {
  EXPECT_TRUE(is_allowed("", "10.1.2.3"));
  EXPECT_TRUE(is_allowed("10.0.0.0/8", "10.1.2.3"));
  EXPECT_TRUE(is_allowed("a.example, 10.1.2.3", "10.1.2.3"));
  EXPECT_TRUE(is_allowed("Camera.local", "camera.LOCAL"));
  EXPECT_TRUE(is_allowed("[fd00::]/8,fd00::1", "[fd00::1]"));
  EXPECT_FALSE(is_allowed("10.0.0.0/8", "11.1.2.3"));
  EXPECT_FALSE(is_allowed("10.1.2.3", "10.1.2.33"));
  EXPECT_FALSE(is_allowed("camera.local", "camera.local.example"));
  EXPECT_FALSE(is_allowed("10.0.0.0/8", "broker.example"));
  for (const char* without_entries : {",", " ", " , ,"})
    EXPECT_FALSE(is_allowed(without_entries, "10.1.2.3")) << without_entries;
}

TEST(NetworkPolicy, RejectsEntriesThatNameNothing) {
  EXPECT_TRUE(check_allow_list(""));
  EXPECT_TRUE(check_allow_list("192.168.1.0/24, camera_2.local,::1"));
  EXPECT_REFUSED(check_allow_list("192.168.1.0/33"), OPTION_VALUE, "offered: 192.168.1.0/33");
  EXPECT_REFUSED(check_allow_list("a.example,192.168"), OPTION_VALUE, "offered: 192.168\n");
  EXPECT_REFUSED(check_allow_list("a b"), OPTION_VALUE, "fix: allow=192.168.1.0/24,camera.local");
  for (const char* without_entries : {",", " ", " , ,"})
    EXPECT_REFUSED(check_allow_list(without_entries), OPTION_VALUE,
                   "the property allow has no entry");
  EXPECT_SAYS(check_allow_list(",").error().message(), "offered: allow=\",\"");
}

TEST(NetworkPolicy, ServersMustBeInTheList) {
  const auto check = [](const char* host, const char* allow) {
    Endpoint endpoint = to(host);
    endpoint.allow = allow;
    return check_server_is_allowed(endpoint);
  };
  EXPECT_TRUE(check("camera.local", ""));
  EXPECT_TRUE(check("camera.local", "10.0.0.0/8,camera.local"));
  EXPECT_TRUE(check("10.1.2.3", "10.0.0.0/8"));
  const auto status = check("11.1.2.3", "10.0.0.0/8");
  EXPECT_REFUSED(status, CONNECTION_INSECURE, "the property allow does not name the server");
  EXPECT_SAYS(status.error().message(),
              "offered: connecting to 11.1.2.3:1883 with allow=10.0.0.0/8");
  EXPECT_SAYS(status.error().message(), "fix: allow=10.0.0.0/8,11.1.2.3");
  EXPECT_FALSE(check("camera.local", "10.0.0.0/8"));
  for (const char* host : {"localhost", "127.0.0.1", "[::1]"}) {
    EXPECT_FALSE(check(host, "10.0.0.0/8")) << host;
    for (const char* allow : {"localhost", "127.0.0.0/8", "::1"})
      EXPECT_TRUE(check(host, allow)) << host << " " << allow;
  }
}

TEST(NetworkPolicy, OwnProtocolsNeedTlsForOtherMachines) {
  EXPECT_TRUE(check_own_protocol(to("127.0.0.1")));
  Endpoint broker = to("broker.example");
  const auto status = check_own_protocol(broker);
  EXPECT_REFUSED(status, CONNECTION_INSECURE, "offered: connecting to broker.example:1883");
  EXPECT_SAYS(status.error().message(), "needed: TLS, or insecure=true");
  EXPECT_SAYS(status.error().message(), "fix: tls-ca=ca.pem port=8883");
  broker.insecure = true;
  EXPECT_TRUE(check_own_protocol(broker));
  broker.insecure = false;
  broker.encrypted = true;
  EXPECT_TRUE(check_own_protocol(broker));
  EXPECT_REFUSED(check_own_protocol(on("")), CONNECTION_INSECURE, "listening on 0.0.0.0:3000");
  EXPECT_REFUSED(check_own_protocol(on("fd00::1")), CONNECTION_INSECURE, "on [fd00::1]:3000");
}

TEST(NetworkPolicy, OldProtocolsWarn) {
  EXPECT_EQ(get_warning(to("localhost")), "");
  const std::string text = get_warning(to("10.0.0.9"));
  EXPECT_SAYS(text, "WEIR-6003: the connection to another machine is not encrypted");
  EXPECT_SAYS(text, "offered: connecting to 10.0.0.9:1883");
  EXPECT_SAYS(text, "fix: tls-ca=ca.pem port=8883");
  EXPECT_SAYS(get_warning(on("0.0.0.0"), "false"), "other machines can connect");
  EXPECT_SAYS(get_warning(on("0.0.0.0")), "fix: host=127.0.0.1 and a stunnel");
}

TEST(NetworkPolicy, RequireTlsNeedsInsecureAndAllow) {
  EXPECT_EQ(get_warning(to("127.0.0.1"), "true"), "");
  Endpoint broker = to("10.0.0.9");
  const std::string text = get_warning(broker, "true");
  EXPECT_SAYS(text, "error WEIR-6003");
  EXPECT_SAYS(text, "require-tls of WEIR_NETWORK_REQUIRE_TLS is true");
  EXPECT_SAYS(text, "fix: tls-ca=ca.pem port=8883, or insecure=true allow=10.0.0.9");
  broker.insecure = true;
  EXPECT_SAYS(get_warning(broker, "true"), "error WEIR-6003");
  broker.allow = "10.0.0.8";
  EXPECT_SAYS(get_warning(broker, "true"), "error WEIR-6003");
  broker.allow = "10.0.0.8,10.0.0.9";
  EXPECT_EQ(get_warning(broker, "true"), "");
  broker.insecure = false;
  EXPECT_SAYS(get_warning(broker, "true"), "error WEIR-6003");
  broker.encrypted = true;
  EXPECT_EQ(get_warning(broker, "true"), "");

  Endpoint server = on("0.0.0.0");
  server.insecure = true;
  EXPECT_SAYS(get_warning(server, "true"), "fix: insecure=true allow=192.168.1.0/24");
  server.allow = "10.0.0.0/8";
  EXPECT_EQ(get_warning(server, "true"), "");
  server.allow = "10.0.0.0/99";
  EXPECT_SAYS(get_warning(server), "error WEIR-1004");
}

}  // namespace network_policy_test
}  // namespace weir::transport
