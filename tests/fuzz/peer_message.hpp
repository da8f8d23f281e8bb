// PeerMessage: fuzz input as a message of a peer (src/net), in chunks of any size.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <span>
#include <vector>

#include "net/protocol/wire.hpp"

namespace weir::fuzz {

struct PeerMessage {
  std::vector<std::vector<std::byte>> parts;
  net::Chunks chunks;  // the parts
  size_t room;         // bytes of memory for a tensor

  // The first byte is the size of the chunks, the second the room; none without them. Each chunk
  // has memory of its own, so that a read beyond it is found.
  static std::optional<PeerMessage> read(const uint8_t* data, size_t size) {
    if (size < 2) return std::nullopt;
    const size_t chunk = data[0] % 32 + 1;
    const auto bytes = std::as_bytes(std::span(data, size)).subspan(2);
    PeerMessage out{{}, {}, data[1]};
    for (size_t at = 0; at < bytes.size(); at += chunk) {
      const auto part = bytes.subspan(at, std::min(chunk, bytes.size() - at));
      out.parts.emplace_back(part.begin(), part.end());
    }
    out.chunks = net::Chunks({out.parts.begin(), out.parts.end()});
    return out;
  }
};

inline void expect(bool condition) {
  if (!condition) std::abort();
}

}  // namespace weir::fuzz
