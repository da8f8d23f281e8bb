// Bytes of docs/compatibility/edge-wire.md 10.7, as that page prints them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/wire/edge_message_reader.hpp"

namespace weir::wire::test {

using Bytes = std::vector<std::byte>;

// The bytes of hexadecimal digits in pairs; other characters are ignored.
inline Bytes from_hex(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  Bytes out;
  int high = -1;
  for (const char c : text) {
    const size_t digit = kDigits.find(c);
    if (digit == std::string_view::npos) continue;
    if (high < 0) {
      high = static_cast<int>(digit);
      continue;
    }
    out.push_back(static_cast<std::byte>(high * 16 + static_cast<int>(digit)));
    high = -1;
  }
  return out;
}

inline Bytes operator+(Bytes left, const Bytes& right) {
  left.insert(left.end(), right.begin(), right.end());
  return left;
}

inline Bytes from_text(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

// `head`, zeros up to offset `at`, `tail`.
inline Bytes with_zeros(std::string_view head, size_t at, std::string_view tail = {}) {
  Bytes out = from_hex(head);
  out.resize(at);
  return out + from_hex(tail);
}

inline constexpr int64_t kClientId = 1051064743;
inline constexpr std::string_view kCapabilityText =
    "@query_server_src_caps@A@query_server_sink_caps@B";

inline Bytes golden_capability() {
  return with_zeros(
             "ed fe ed fe 03 00 00 00 02 00 00 06 00 00 dd ef a7 f9 a5 3e 00 00 00 00 01 00 00 00 "
             "00 00 00 00 32 00 00 00 00 00 00 00",
             2080, "00 00 00 00 00 00 00 00") +
         from_text(kCapabilityText) + from_hex("00");
}

inline Bytes golden_host_info() {
  return with_zeros(
      "ed fe ed fe 02 00 00 00 02 00 00 06 00 00 dd ef a7 f9 a5 3e 00 00 00 00 01 00 00 00 "
      "00 00 00 00 0f 00 00 00 00 00 00 00",
      2088, "31 32 37 2e 30 2e 30 2e 31 3a 34 31 30 31 00");
}

inline Bytes golden_metadata() {
  return from_hex("01 00 00 00 63 6c 69 65 6e 74 5f 69 64 00 31 30 35 31 30 36 34 37 34 33 00");
}

// Memories 01 02 03 04 and "xyz".
inline Bytes golden_transfer_data() {
  return with_zeros(
             "ed fe ed fe 01 00 00 00 02 00 00 06 00 00 dd ef a7 f9 a5 3e 00 00 00 00 02 00 00 00 "
             "00 00 00 00 04 00 00 00 00 00 00 00 03 00 00 00 00 00 00 00",
             2080, "19 00 00 00 00 00 00 00 01 02 03 04 78 79 7a") +
         golden_metadata();
}

inline Bytes golden_error() {
  return with_zeros("ed fe ed fe 00 00 00 00 02 00 00 06 00 00 dd ef", 2088);
}

// The CAPABILITY of 0.2.2, with a text of 50 bytes.
inline Bytes golden_capability_of_0_2_2() {
  return with_zeros(
             "ed fe ed fe 03 00 00 00 61 64 54 42 00 00 00 00 01 00 00 00 00 00 00 00 "
             "32 00 00 00 00 00 00 00",
             160) +
         from_text(kCapabilityText) + from_hex("00");
}

// HOST_INFO "h:1" of the 168-byte form: sizes at 32, text at 168. The page prints no bytes of this
// form; they follow from its table.
inline Bytes short_host_info(std::string_view version = "02 00 00 04 00 00 dd ef") {
  return with_zeros("ed fe ed fe 02 00 00 00" + std::string(version) +
                        "07 00 00 00 00 00 00 00 01 00 00 00 00 00 00 00 04 00 00 00 00 00 00 00",
                    168, "68 3a 31 00");
}

// One memory 01 02 03 04, metadata k1=v1 and k2=v2.
inline Bytes golden_mqtt_payload() {
  return with_zeros(
      "da ed da ed 00 00 00 00 02 00 00 06 00 00 dd ef 01 00 00 00 00 00 00 00 "
      "04 00 00 00 00 00 00 00",
      2072, "10 00 00 00 00 00 00 00 01 02 03 04 02 00 00 00 6b 32 00 76 32 00 6b 31 00 76 31 00");
}

inline Bytes copy_of(std::span<const std::byte> bytes) {
  return {bytes.begin(), bytes.end()};
}

inline Bytes start_of(const Bytes& bytes, size_t size) {
  return copy_of(std::span(bytes).first(size));
}

// Replaces the bytes at `offset`.
inline Bytes with_bytes(Bytes bytes, size_t offset, std::string_view hex) {
  for (const std::byte byte : from_hex(hex)) bytes.at(offset++) = byte;
  return bytes;
}

}  // namespace weir::wire::test
