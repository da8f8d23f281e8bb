// Metadata of nnstreamer-edge messages: pairs of key and value
// (docs/compatibility/edge-wire.md 10.3).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/edge_metadata.hpp"

#include <algorithm>
#include <cstdint>

#include "core/text/text.hpp"
#include "core/wire/little_endian.hpp"
#include "core/wire/peer_error.hpp"

namespace weir::wire {
namespace {

constexpr size_t kCountBytes = sizeof(uint32_t);
// A key and a value of one character, each with its NUL.
constexpr size_t kMinPairBytes = 4;

auto find_pair(const std::vector<EdgeMetadata::Pair>& pairs, std::string_view key) {
  return std::find_if(pairs.begin(), pairs.end(), [key](const EdgeMetadata::Pair& pair) {
    return equal_ignoring_case(pair.first, key);
  });
}

bool is_usable(std::string_view text) {
  return !text.empty() && text.find('\0') == std::string_view::npos;
}

// Removes the text up to the next NUL, and the NUL, from `rest`.
std::optional<std::string_view> take_text(std::string_view* rest) {
  const size_t end = rest->find('\0');
  if (end == std::string_view::npos) return std::nullopt;
  const auto text = rest->substr(0, end);
  rest->remove_prefix(end + 1);
  return text;
}

Error metadata_error(std::string what, std::string offered, std::string needed) {
  return peer_error("the metadata of a message " + std::move(what), std::move(offered),
                    std::move(needed));
}

Result<EdgeMetadata::Pair> take_pair(size_t index, std::string_view* rest) {
  const auto key = take_text(rest);
  const auto value = key ? take_text(rest) : std::nullopt;
  const std::string place = "pair " + std::to_string(index);
  if (!key || !value)
    return metadata_error("ends inside a pair", place, "a key and a value, each with a NUL");
  if (key->empty() || value->empty())
    return metadata_error("has an empty key or value",
                          place + ", " + quoted_text(*key) + " = " + quoted_text(*value),
                          "at least one character in each");
  return EdgeMetadata::Pair{*key, *value};
}

}  // namespace

Status EdgeMetadata::set(std::string_view key, std::string_view value) {
  if (!is_usable(key) || !is_usable(value))
    return Error{.code = Code::OPTION_VALUE,
                 .what = "a key or value of metadata cannot be sent",
                 .offered = quoted_text(key) + " = " + quoted_text(value),
                 .needed = "at least one character in each, none of them NUL"};
  if (const auto old = find_pair(pairs_, key); old != pairs_.end()) pairs_.erase(old);
  pairs_.insert(pairs_.begin(), Pair{key, value});
  return ok();
}

std::optional<std::string_view> EdgeMetadata::find(std::string_view key) const {
  const auto pair = find_pair(pairs_, key);
  if (pair == pairs_.end()) return std::nullopt;
  return pair->second;
}

std::vector<std::byte> EdgeMetadata::encode() const {
  if (pairs_.empty()) return {};
  std::vector<std::byte> out(kCountBytes);
  write_little(std::span(out), 0, static_cast<uint32_t>(pairs_.size()));
  const auto append = [&out](const std::string& text) {
    // With the NUL at its end.
    const auto bytes = std::as_bytes(std::span(text.c_str(), text.size() + 1));
    out.insert(out.end(), bytes.begin(), bytes.end());
  };
  for (const auto& [key, value] : pairs_) {
    append(key);
    append(value);
  }
  return out;
}

Result<EdgeMetadata> EdgeMetadata::parse(std::span<const std::byte> bytes) {
  EdgeMetadata out;
  if (bytes.empty()) return out;
  if (bytes.size() < kCountBytes)
    return metadata_error("is cut off", std::to_string(bytes.size()) + " bytes",
                          "at least 4 bytes, the number of pairs");
  const auto count = read_little<uint32_t>(bytes, 0);
  const auto texts = bytes.subspan(kCountBytes);
  if (count > texts.size() / kMinPairBytes)
    return metadata_error("is too short for its pairs", std::to_string(bytes.size()) + " bytes",
                          "at least 4 bytes for each of " + std::to_string(count) + " pairs");
  std::string_view rest(reinterpret_cast<const char*>(texts.data()), texts.size());
  for (uint32_t i = 0; i < count; ++i) {
    auto pair = take_pair(i, &rest);
    if (!pair) return pair.error();
    if (out.find(pair->first))
      return metadata_error("has a key twice", quoted_text(pair->first), "each key once");
    out.pairs_.push_back(*std::move(pair));
  }
  if (!rest.empty())
    return metadata_error("has more than its pairs",
                          std::to_string(rest.size()) + " bytes after the last one",
                          "the end after " + std::to_string(count) + " pairs");
  return out;
}

}  // namespace weir::wire
