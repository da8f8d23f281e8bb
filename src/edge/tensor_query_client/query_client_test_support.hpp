// Helpers of the tests of tensor_query_client.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "elements/tests/element_test_support.hpp"
#include "transport/edge/query_server_test_support.hpp"

namespace weir::test {

using edge::test::ScriptedServer;
using wire::HeaderForm;

inline constexpr char kClient[] = "tensor_query_client";

inline std::string four_bytes() {
  return tensors("uint8", "4");
}
inline Bytes four(uint8_t value) {
  return Bytes(4, value);
}
inline std::string client_of(const ScriptedServer& server, const std::string& options = "") {
  return std::string(kClient) + " port=0 dest-port=" + std::to_string(server.port()) + " " +
         options;
}
// Answers each frame with itself, until the client ends the connection.
inline void echo_all(ScriptedServer& server, bool repeats_numbers = false) {
  for (;;) {
    const auto message = server.read();
    if (message.command != wire::Command::TransferData) return;
    server.echo(message, repeats_numbers);
  }
}
inline void handshake_and_echo_all(ScriptedServer& server, HeaderForm form = HeaderForm::Bytes2088,
                                   bool repeats_numbers = false) {
  server.handshake(four_bytes(), four_bytes(), form);
  echo_all(server, repeats_numbers);
}
inline GstFlowReturn push(const Harness& h, uint8_t value) {
  return gst_harness_push(h.get(), frame(four(value), value * GST_SECOND, GST_MSECOND));
}
// The next output has the bytes and the time of the frame that push() made of `value`.
inline void expect_response(const Harness& h, uint8_t value) {
  const auto got = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
  ASSERT_TRUE(got) << int{value};
  EXPECT_EQ(content(got.get()), four(value));
  EXPECT_EQ(GST_BUFFER_PTS(got.get()), value * GST_SECOND);
  EXPECT_EQ(GST_BUFFER_DURATION(got.get()), GST_MSECOND);
}
inline uint64_t client_stat(const Harness& h, const char* name) {
  return stat(h, kClient, name);
}
// The law of edge-wire.md: each frame that was sent has one outcome, and each that was received
// one place in the ledger.
inline void expect_sums(const Harness& h) {
  EXPECT_EQ(client_stat(h, "sent"), client_stat(h, "answered") + client_stat(h, "late") +
                                        client_stat(h, "refused") + client_stat(h, "lost"));
  EXPECT_EQ(client_stat(h, "held"), 0u);
}

}  // namespace weir::test
