// Fuzz target: what a broker of MQTT 5 sends, in pieces of any size.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/mqtt_packets.hpp"

#include <algorithm>
#include <vector>

#include "fuzz_input.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace weir;
  fuzz::FuzzInput input(data, size);
  const size_t piece = size_t{1} + input.byte();
  wire::MqttPacketFilter whole, in_pieces;
  std::vector<std::byte> expected_bytes, bytes;
  const auto expected = whole.feed(input.rest(), &expected_bytes);
  Status status = ok();
  while (!input.empty()) status = in_pieces.feed(input.bytes(piece), &bytes);
  fuzz::require(status.has_value() == expected.has_value(), "pieces do not matter");
  fuzz::require(bytes == expected_bytes, "pieces do not matter for what is passed on");
  if (!status)
    fuzz::require(status.error().code == Code::PEER_MESSAGE_INVALID,
                  "bad bytes are a peer's fault");
  if (!status) fuzz::require(!in_pieces.feed({}, &bytes), "an error is the end of the connection");
  wire::MqttPacketFilter again;
  std::vector<std::byte> same;
  fuzz::require(again.feed(bytes, &same).has_value(), "what is passed on can be passed on again");
  fuzz::require(same.size() <= bytes.size() && std::equal(same.begin(), same.end(), bytes.begin()),
                "without a change");
  return 0;
}
