// Reads nnstreamer-edge messages from a connection whose bytes arrive in any pieces.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/wire/edge_header.hpp"

namespace weir::wire {

struct ByteBlock {
  std::unique_ptr<std::byte[]> data;
  size_t size = 0;

  std::span<const std::byte> bytes() const noexcept { return {data.get(), size}; }
};

struct EdgeMessage {
  Command command = Command::Error;
  int64_t client_id = 0;
  std::vector<ByteBlock> memories{};
  ByteBlock metadata{};
};

// The reader of one connection. Memory grows with the bytes that arrive, not with the sizes that a
// header declares: a memory is allocated at once only up to the larger of 64 KiB and the largest
// memory that the peer has sent before. One thread at a time.
//
//   while (!reader.complete()) {
//     const auto room = reader.space();
//     if (auto status = reader.received(recv(room)); !status) ...
//   }
//   EdgeMessage message = reader.take();
class EdgeMessageReader {
 public:
  // Without `form` the first bytes decide it.
  explicit EdgeMessageReader(const MessageLimits& limits, std::optional<HeaderForm> form = {})
      : limits_(limits), form_(form) {}

  // The memory for the next bytes of the connection. Empty while a message is complete or after an
  // error. It ends where the message ends, so nothing is read beyond it.
  std::span<std::byte> space() noexcept;
  // `count` bytes were written to the start of space(). PEER_MESSAGE_INVALID for bytes that are not
  // a message within the limits; every later call returns the same error.
  Status received(size_t count);
  // Copies bytes into space() up to the end of one message, and returns how many it took.
  Result<size_t> feed(std::span<const std::byte> bytes);

  bool complete() const noexcept { return state_ == State::Complete; }
  // The message; the reader continues with the next one. Precondition: complete().
  EdgeMessage take();
  // True if the connection may end here.
  bool at_start() const noexcept { return state_ == State::Header && filled_ == 0; }
  // The peer closed the connection. PEER_MESSAGE_INVALID, with the place, if a message is
  // incomplete.
  Status end();
  // The peer has sent nothing for 200 ms. Decides a form that only silence decides.
  Status silence();
  // The form of the peer, when it is known.
  std::optional<HeaderForm> form() const noexcept { return form_; }

 private:
  enum class State : uint8_t { Header, Memory, Metadata, Complete, Failed };

  size_t header_bytes_needed() const noexcept;
  Status header_received();
  Status block_received();
  Status start_next_block();
  Status start_block(uint64_t size);
  Status grow_block();
  std::string place() const;
  Status fail(Error error);

  const MessageLimits limits_;
  std::optional<HeaderForm> form_;
  State state_ = State::Header;
  // Bytes that decide the form.
  size_t form_needs_ = 0;
  std::array<std::byte, kMaxHeaderBytes> header_bytes_{};
  EdgeHeader header_;
  EdgeMessage message_;
  ByteBlock block_;  // the memory or metadata that arrives; `size` is what it has when complete
  size_t capacity_ = 0;
  size_t filled_ = 0;  // bytes of the header or of block_
  size_t max_received_ = 0;
  Error error_;
};

}  // namespace weir::wire
