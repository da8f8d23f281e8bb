// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/edge_message_reader.hpp"

#include <algorithm>
#include <cstring>
#include <new>
#include <string>
#include <utility>

#include "core/wire/peer_error.hpp"

namespace weir::wire {
namespace {

constexpr size_t kBlockBytesAtOnce = size_t{64} << 10;
// The bytes that every decision about the form needs.
constexpr size_t kFormBytes = 16;

}  // namespace

std::span<std::byte> EdgeMessageReader::space() noexcept {
  switch (state_) {
    case State::Header:
      return std::span(header_bytes_).subspan(filled_, header_bytes_needed() - filled_);
    case State::Memory:
    case State::Metadata:
      return {block_.data.get() + filled_, capacity_ - filled_};
    case State::Complete:
    case State::Failed:
      break;
  }
  return {};
}

Status EdgeMessageReader::received(size_t count) {
  if (state_ == State::Failed) return error_;
  if (count > space().size())
    return fail({.code = Code::INTERNAL, .what = "more bytes were received than there was space"});
  if (count == 0) return ok();
  filled_ += count;
  return state_ == State::Header ? header_received() : block_received();
}

Result<size_t> EdgeMessageReader::feed(std::span<const std::byte> bytes) {
  if (state_ == State::Failed) return error_;
  size_t taken = 0;
  while (taken < bytes.size() && !complete()) {
    const auto room = space();
    const size_t count = std::min(room.size(), bytes.size() - taken);
    std::memcpy(room.data(), bytes.data() + taken, count);
    taken += count;
    if (auto status = received(count); !status) return status.error();
  }
  return taken;
}

EdgeMessage EdgeMessageReader::take() {
  state_ = State::Header;
  filled_ = 0;
  return std::exchange(message_, {});
}

Status EdgeMessageReader::end() {
  if (state_ == State::Failed) return error_;
  if (complete() || at_start()) return ok();
  // The end is the longest silence: it completes a message that has no text.
  if (auto status = silence(); !status || complete()) return status;
  return fail(peer_error("the peer closed the connection in the middle of a message", place(),
                         "a complete message", "check the log of the peer"));
}

Status EdgeMessageReader::silence() {
  if (state_ == State::Failed) return error_;
  if (form_ || state_ != State::Header) return ok();
  form_ = form_after_silence(std::span(header_bytes_).first(filled_));
  return form_ ? header_received() : ok();
}

size_t EdgeMessageReader::header_bytes_needed() const noexcept {
  return form_ ? get_layout(*form_).bytes : std::max(form_needs_, kFormBytes);
}

Status EdgeMessageReader::header_received() {
  if (!form_) {
    const auto decision = recognise_form(std::span(header_bytes_).first(filled_));
    if (!decision) return fail(decision.error());
    form_ = decision->form;
    form_needs_ = decision->needed;
  }
  if (!form_) return ok();
  const size_t size = get_layout(*form_).bytes;
  if (filled_ < size) return ok();
  auto header = read_header(*form_, std::span(header_bytes_).first(size), limits_);
  if (!header) return fail(header.error());
  header_ = *std::move(header);
  message_ = {.command = header_.command, .client_id = header_.client_id};
  // Deciding between the forms of 0.2.5 reads a byte of the text of the shorter one.
  const size_t beyond = filled_ - size;
  if (auto status = start_next_block(); !status || beyond == 0) return status;
  if (beyond > space().size())
    return fail(peer_error("a message continues after its end",
                           std::to_string(beyond) + " more bytes", "the end of the message"));
  std::memcpy(block_.data.get(), header_bytes_.data() + size, beyond);
  return received(beyond);
}

Status EdgeMessageReader::block_received() {
  if (filled_ < capacity_) return ok();
  if (capacity_ < block_.size) return grow_block();
  max_received_ = std::max(max_received_, block_.size);
  if (state_ == State::Memory)
    message_.memories.push_back(std::move(block_));
  else
    message_.metadata = std::move(block_);
  return start_next_block();
}

Status EdgeMessageReader::start_next_block() {
  const size_t next = message_.memories.size();
  if (next < header_.sizes.size()) {
    state_ = State::Memory;
    return start_block(header_.sizes[next]);
  }
  if (header_.metadata_bytes != 0 && !message_.metadata.data) {
    state_ = State::Metadata;
    return start_block(header_.metadata_bytes);
  }
  state_ = State::Complete;
  return ok();
}

Status EdgeMessageReader::start_block(uint64_t size) {
  block_ = {.data = nullptr, .size = static_cast<size_t>(size)};
  filled_ = capacity_ = 0;
  return grow_block();
}

Status EdgeMessageReader::grow_block() {
  const size_t trusted = std::max({kBlockBytesAtOnce, max_received_, 2 * capacity_});
  const size_t capacity = std::min(block_.size, trusted);
  std::unique_ptr<std::byte[]> data(new (std::nothrow) std::byte[capacity]);
  if (!data)
    return fail({.code = Code::OUT_OF_MEMORY,
                 .what = "there is no memory for a message of a peer",
                 .needed = std::to_string(capacity) + " bytes",
                 .fix = "lower the limit of the bytes of a message"});
  if (filled_ != 0) std::memcpy(data.get(), block_.data.get(), filled_);
  block_.data = std::move(data);
  capacity_ = capacity;
  return ok();
}

std::string EdgeMessageReader::place() const {
  const std::string bytes = std::to_string(filled_);
  if (state_ == State::Header) return "the first " + bytes + " bytes of a header";
  const std::string part = state_ == State::Metadata
                               ? "the metadata"
                               : "memory " + std::to_string(message_.memories.size());
  return bytes + " of " + std::to_string(block_.size) + " bytes of " + part + " of " +
         to_string(header_.command);
}

Status EdgeMessageReader::fail(Error error) {
  state_ = State::Failed;
  error_ = std::move(error);
  message_ = {};
  block_ = {};
  return error_;
}

}  // namespace weir::wire
