// Headers of nnstreamer-edge messages, read and written with limits
// (docs/compatibility/edge-wire.md 10.2).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/edge_header.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/wire/little_endian.hpp"
#include "core/wire/peer_error.hpp"

namespace weir::wire {
namespace {

constexpr size_t kCommandOffset = 4;
constexpr size_t kMaxTextBytes = size_t{64} << 10;

std::string bytes_text(uint64_t bytes) {
  return std::to_string(bytes) + (bytes == 1 ? " byte" : " bytes");
}

bool has_text(Command command) {
  return command == Command::HostInfo || command == Command::Capability;
}

Status check_start(const HeaderLayout& layout, std::span<const std::byte> bytes) {
  if (bytes.size() < layout.bytes)
    return peer_error("a message header is cut off", bytes_text(bytes.size()),
                      bytes_text(layout.bytes) + " (" + std::string(layout.name) + " form)");
  if (read_little<uint32_t>(bytes, 0) != kEdgeMagic)
    return peer_error("a message does not begin with the magic number",
                      std::to_string(read_little<uint32_t>(bytes, 0)), "0xfeedfeed (4276993773)");
  if (layout.version_key == 0) return ok();
  const auto key = read_little<uint64_t>(bytes, layout.version_offset);
  if (key >> 48 != kVersionTag)
    return peer_error("a message has an unknown version key",
                      std::to_string(key >> 48) + " in the top 16 bits",
                      std::to_string(kVersionTag) + " (0xefdd)");
  return ok();
}

// Peers on i386 have no padding before the sizes, so their first size is 4 bytes earlier. Only a
// text is small enough to tell them apart.
bool is_i386(const HeaderLayout& layout, std::span<const std::byte> bytes) {
  return has_text(static_cast<Command>(read_little<uint32_t>(bytes, kCommandOffset))) &&
         read_little<uint32_t>(bytes, layout.sizes_offset - 4) != 0 &&
         read_little<uint32_t>(bytes, layout.sizes_offset) == 0;
}

Status check_text(Command command, const EdgeHeader& header, const MessageLimits& limits) {
  if (header.sizes.size() != 1)
    return peer_error(to_string(command) + " does not have exactly one text",
                      std::to_string(header.sizes.size()) + " memories", "1 memory");
  if (header.sizes[0] > limits.text_bytes)
    return peer_error("the text of " + to_string(command) + " is too long",
                      bytes_text(header.sizes[0]), "at most " + bytes_text(limits.text_bytes));
  return ok();
}

Status check_sizes(const EdgeHeader& header, const MessageLimits& limits) {
  if (header.metadata_bytes > limits.metadata_bytes)
    return peer_error("the metadata of a message is too long", bytes_text(header.metadata_bytes),
                      "at most " + bytes_text(limits.metadata_bytes));
  uint64_t left = limits.message_bytes - std::min(limits.message_bytes, header.metadata_bytes);
  for (size_t i = 0; i < header.sizes.size(); ++i) {
    if (header.sizes[i] == 0)
      return peer_error("a message has a memory of 0 bytes", "memory " + std::to_string(i),
                        "at least 1 byte in each memory");
    if (header.sizes[i] > left)
      return peer_error("a message is larger than allowed",
                        bytes_text(header.sizes[i]) + " in memory " + std::to_string(i) + " of " +
                            std::to_string(header.sizes.size()),
                        "at most " + bytes_text(limits.message_bytes) + " in all");
    left -= header.sizes[i];
  }
  return has_text(header.command) ? check_text(header.command, header, limits) : ok();
}

void append(std::string_view text, std::vector<std::byte>* out) {
  const auto bytes = std::as_bytes(std::span(text));
  out->insert(out->end(), bytes.begin(), bytes.end());
  out->push_back(std::byte{0});
}

}  // namespace

std::string to_string(Command command) {
  switch (command) {
    case Command::Error:
      return "ERROR";
    case Command::TransferData:
      return "TRANSFER_DATA";
    case Command::HostInfo:
      return "HOST_INFO";
    case Command::Capability:
      return "CAPABILITY";
  }
  return "command " + std::to_string(static_cast<uint32_t>(command));
}

Result<EdgeHeader> read_header(HeaderForm form, std::span<const std::byte> bytes,
                               const MessageLimits& limits) {
  const auto& layout = get_layout(form);
  if (auto status = check_start(layout, bytes); !status) return status.error();
  if (is_i386(layout, bytes))
    return peer_error("a message has the alignment of 32-bit x86", "8-byte fields aligned to 4",
                      "8-byte fields aligned to 8",
                      "use a 64-bit build of NNStreamer on the other device");
  const auto count = read_little<uint32_t>(bytes, layout.count_offset);
  if (count > layout.entries)
    return peer_error("a message has more memories than its header has sizes",
                      std::to_string(count) + " memories",
                      "at most " + std::to_string(layout.entries) + " in the " +
                          std::string(layout.name) + " form");
  EdgeHeader header{.command = static_cast<Command>(read_little<uint32_t>(bytes, kCommandOffset)),
                    .client_id = read_little<int64_t>(bytes, layout.client_id_offset),
                    .metadata_bytes = read_little<uint64_t>(bytes, layout.metadata_offset)};
  header.sizes.reserve(count);
  for (size_t i = 0; i < count; ++i)
    header.sizes.push_back(read_little<uint64_t>(bytes, layout.sizes_offset + 8 * i));
  if (auto status = check_sizes(header, limits); !status) return status.error();
  return header;
}

Result<std::vector<std::byte>> write_header(HeaderForm form, const EdgeHeader& header) {
  const auto& layout = get_layout(form);
  if (header.sizes.size() > layout.max_memories)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "a frame has more memories than the peer can receive",
                 .offered = std::to_string(header.sizes.size()) + " memories",
                 .needed = "at most " + std::to_string(layout.max_memories) + " in the " +
                           std::string(layout.name) + " form",
                 .fix = "merge tensors with tensor_merge before the frame is sent"};
  if (const auto empty = std::find(header.sizes.begin(), header.sizes.end(), uint64_t{0});
      empty != header.sizes.end())
    return Error{.code = Code::FRAME_SIZE,
                 .what = "a frame has a memory of 0 bytes, which peers cannot receive",
                 .offered = "memory " + std::to_string(empty - header.sizes.begin()),
                 .needed = "at least 1 byte in each memory",
                 .fix = "check the element that makes the frame"};
  std::vector<std::byte> out(layout.bytes);
  write_little(std::span(out), 0, kEdgeMagic);
  write_little(std::span(out), kCommandOffset, static_cast<uint32_t>(header.command));
  if (layout.version_key != 0)
    write_little(std::span(out), layout.version_offset, layout.version_key);
  write_little(std::span(out), layout.client_id_offset, header.client_id);
  write_little(std::span(out), layout.count_offset, static_cast<uint32_t>(header.sizes.size()));
  for (size_t i = 0; i < header.sizes.size(); ++i)
    write_little(std::span(out), layout.sizes_offset + 8 * i, header.sizes[i]);
  write_little(std::span(out), layout.metadata_offset, header.metadata_bytes);
  return out;
}

Result<std::vector<std::byte>> text_message(HeaderForm form, Command command, int64_t client_id,
                                            std::string_view text) {
  if (text.find('\0') != std::string_view::npos)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "a text for " + to_string(command) + " contains a NUL",
                 .offered = quoted_text(text),
                 .needed = "a text without NUL"};
  if (text.size() >= kMaxTextBytes)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "a text for " + to_string(command) + " is too long",
                 .offered = bytes_text(text.size() + 1) + " with its NUL",
                 .needed = "at most " + bytes_text(kMaxTextBytes),
                 .fix = "shorten the caps"};
  auto out =
      write_header(form, {.command = command, .client_id = client_id, .sizes = {text.size() + 1}});
  if (out) append(text, &*out);
  return out;
}

Result<std::vector<std::byte>> greeting_for_both_forms(int64_t client_id, std::string_view text) {
  auto out = text_message(HeaderForm::Bytes2088, Command::Capability, client_id, text);
  const size_t offset = get_layout(HeaderForm::Bytes168).bytes;
  const size_t end = get_layout(HeaderForm::Bytes2088).metadata_offset;
  if (out && offset + text.size() + 1 <= end)
    std::memcpy(out->data() + offset, text.data(), text.size());
  return out;
}

std::vector<std::byte> error_message(HeaderForm form) {
  return *write_header(form, {.command = Command::Error});
}

}  // namespace weir::wire
