// Metadata of nnstreamer-edge messages: pairs of key and value
// (docs/compatibility/edge-wire.md 10.3).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "weir/result.hpp"

namespace weir::wire {

// Keys are unique, ASCII upper and lower case are the same. The pair that was set last comes first.
class EdgeMetadata {
 public:
  using Pair = std::pair<std::string, std::string>;

  // Replaces the value of an existing key. OPTION_VALUE for an empty key or value, and for one that
  // contains a NUL: receivers would drop all pairs.
  Status set(std::string_view key, std::string_view value);
  // The value of `key`.
  std::optional<std::string_view> find(std::string_view key) const;
  const std::vector<Pair>& pairs() const noexcept { return pairs_; }

  // The bytes of all pairs; none without a pair, because a message then has no metadata.
  std::vector<std::byte> encode() const;
  // Reads what encode() or another sender wrote; no bytes are no pairs. PEER_MESSAGE_INVALID if the
  // pairs are more or fewer than the count, if a NUL is missing, and for empty or repeated keys or
  // empty values.
  static Result<EdgeMetadata> parse(std::span<const std::byte> bytes);

 private:
  std::vector<Pair> pairs_;
};

}  // namespace weir::wire
