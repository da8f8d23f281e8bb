// The head of a packet.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/local/local_message.hpp"

#include <cstring>

namespace weir::local {

std::optional<Opened> open_message(std::span<const std::byte> packet) {
  isolate::MessageHead head{};
  if (packet.size() < sizeof head) return std::nullopt;
  std::memcpy(&head, packet.data(), sizeof head);
  const auto body = packet.subspan(sizeof head);
  if (head.bytes != body.size()) return std::nullopt;
  return Opened{static_cast<Kind>(head.kind), isolate::MessageReader(body)};
}

}  // namespace weir::local
