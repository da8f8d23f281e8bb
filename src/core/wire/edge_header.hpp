// Headers of nnstreamer-edge messages, read and written with limits
// (docs/compatibility/edge-wire.md 10.2).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/wire/header_form.hpp"
#include "weir/result.hpp"

namespace weir::wire {

// A header may have other numbers: later versions may have more commands.
enum class Command : uint32_t {
  Error = 0,         // "I close"
  TransferData = 1,  // a frame
  HostInfo = 2,      // one memory: `host:port` of the client's listener
  Capability = 3     // one memory: the caps of a server or publisher
};
std::string to_string(Command command);

// What a peer may send in one message.
struct MessageLimits {
  uint64_t message_bytes = uint64_t{64} << 20;  // all memories and the metadata
  uint64_t text_bytes = uint64_t{64} << 10;     // of CAPABILITY and HOST_INFO
  uint64_t metadata_bytes = uint64_t{16} << 10;
};

struct EdgeHeader {
  Command command = Command::Error;
  int64_t client_id = 0;
  std::vector<uint64_t> sizes{};  // of the memories
  uint64_t metadata_bytes = 0;
};

// Reads a header of this form. PEER_MESSAGE_INVALID for fewer bytes, another magic or version, more
// memories than the size table has, a memory of 0 bytes, sizes beyond the limits, and a CAPABILITY
// or HOST_INFO that does not have one memory. Padding and unused sizes may have any value.
Result<EdgeHeader> read_header(HeaderForm form, std::span<const std::byte> bytes,
                               const MessageLimits& limits);

// The bytes of the header; the memories and the metadata follow it on the connection.
// LIMIT_EXCEEDED for more than 255 memories (15 in the older forms), FRAME_SIZE for a memory of 0
// bytes: receivers would close the connection.
Result<std::vector<std::byte>> write_header(HeaderForm form, const EdgeHeader& header);

// A whole CAPABILITY or HOST_INFO. OPTION_VALUE if the text contains a NUL, LIMIT_EXCEEDED if it is
// longer than 64 KiB.
Result<std::vector<std::byte>> text_message(HeaderForm form, Command command, int64_t client_id,
                                            std::string_view text);

// The CAPABILITY that query clients of the 168-byte and of the 2088-byte form both understand: the
// text is also at offset 168. A text of more than 1911 characters does not fit there, and only
// clients of the 2088-byte form understand the message.
Result<std::vector<std::byte>> greeting_for_both_forms(int64_t client_id, std::string_view text);

// A whole ERROR, which a side sends before it closes a connection.
std::vector<std::byte> error_message(HeaderForm form);

}  // namespace weir::wire
