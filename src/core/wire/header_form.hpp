// The three forms of the nnstreamer-edge message header, and how to recognise the form of a peer
// (docs/compatibility/edge-wire.md 10.2).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "weir/result.hpp"

namespace weir::wire {

inline constexpr uint32_t kEdgeMagic = 0xfeedfeed;
// The top 16 bits of every version key.
inline constexpr uint16_t kVersionTag = 0xefdd;
inline constexpr size_t kMaxHeaderBytes = 2088;

// Named by the bytes of the header.
enum class HeaderForm : uint8_t {
  Bytes160,  // up to 0.2.3
  Bytes168,  // 0.2.4 and early 0.2.5
  Bytes2088  // 0.2.5 and later
};

// Offsets of the fields. All numbers are little-endian.
struct HeaderLayout {
  std::string_view name;
  size_t bytes;
  size_t entries;         // of the size table
  size_t max_memories;    // that a message may have when it is sent
  uint64_t version_key;   // that is sent; 0: the form has none
  size_t version_offset;  // u64
  size_t client_id_offset;
  size_t count_offset;  // u32
  size_t sizes_offset;
  size_t metadata_offset;  // u64, size of the metadata
};
const HeaderLayout& get_layout(HeaderForm form) noexcept;

// Whether a library of the version in `key` may use this form, which has a version key. 0.2.5 may
// use both.
bool version_may_have(uint64_t key, HeaderForm form) noexcept;

struct FormDecision {
  std::optional<HeaderForm> form{};
  size_t needed = 0;  // bytes from the start of the connection that decide, if `form` is not set
};
// Decides the form by the first bytes that a peer sent. PEER_MESSAGE_INVALID if they are not the
// start of a message.
Result<FormDecision> recognise_form(std::span<const std::byte> start);

// The form of a peer that has sent `start` and nothing else for 200 ms: decides what
// recognise_form() cannot decide without more bytes. Nullopt if a message is incomplete in any
// form.
std::optional<HeaderForm> form_after_silence(std::span<const std::byte> start);

}  // namespace weir::wire
