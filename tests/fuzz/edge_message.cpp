// Fuzz target: what a peer of nnstreamer-edge sends, in pieces of any size.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <vector>

#include "core/wire/edge_capability.hpp"
#include "core/wire/edge_conversation.hpp"
#include "core/wire/edge_message_reader.hpp"
#include "core/wire/edge_metadata.hpp"
#include "fuzz_input.hpp"

namespace {

using namespace weir;
using namespace weir::wire;
using fuzz::require;

constexpr MessageLimits kLimits{
    .message_bytes = 1 << 16, .text_bytes = 4096, .metadata_bytes = 512};

using Bytes = std::vector<std::byte>;

Bytes make_copy(std::span<const std::byte> bytes) {
  return {bytes.begin(), bytes.end()};
}

struct Outcome {
  std::vector<Bytes> messages;  // each as the bytes that this side would send for it
  std::optional<HeaderForm> form;
  std::string error;
};

void read_metadata(std::span<const std::byte> bytes) {
  const auto metadata = EdgeMetadata::parse(bytes);
  if (!metadata) {
    require(metadata.error().code == Code::PEER_MESSAGE_INVALID, "bad metadata is a peer's fault");
    return;
  }
  const auto written = metadata->encode();
  require(metadata->pairs().empty() || written == make_copy(bytes),
          "metadata is written as it was");
  for (const auto& [key, value] : metadata->pairs())
    require(metadata->find(key) == value, "each key has its value");
}

void read_texts(const EdgeMessage& message) {
  const auto text = text_of_memory(message.memories.at(0).bytes());
  if (!text) return;
  if (const auto caps = parse_query_capability(*text))
    require(!caps->source_caps.empty() && !caps->sink_caps.empty(), "both caps are there");
  (void)parse_publisher_capability(*text);
  const auto address = parse_host_address(*text);
  if (!address) return;
  require(address->port != 0 && !address->host.empty(), "an address has a host and a port");
  if (const auto callback = callback_address(*address, "192.0.2.1", {}))
    require(callback->host == "192.0.2.1", "answers go to the address of the connection");
}

// The message as bytes; checks its limits.
Bytes written(HeaderForm form, const EdgeMessage& message) {
  EdgeHeader header{.command = message.command,
                    .client_id = message.client_id,
                    .metadata_bytes = message.metadata.size};
  uint64_t total = message.metadata.size;
  for (const auto& memory : message.memories) {
    header.sizes.push_back(memory.size);
    total += memory.size;
  }
  require(total <= kLimits.message_bytes, "a message is within the limits");
  require(message.metadata.size <= kLimits.metadata_bytes, "metadata is within the limits");
  const auto bytes = write_header(form, header);
  if (!bytes) {
    require(header.sizes.size() == get_layout(form).entries, "only a full table cannot be sent");
    return {};
  }
  const auto again = read_header(form, *bytes, kLimits);
  require(again && again->sizes == header.sizes && again->command == header.command &&
              again->client_id == header.client_id &&
              again->metadata_bytes == header.metadata_bytes,
          "a header that is written is read again");
  auto out = *bytes;
  const auto append = [&out](std::span<const std::byte> more) {
    out.insert(out.end(), more.begin(), more.end());
  };
  for (const auto& memory : message.memories) append(memory.bytes());
  append(message.metadata.bytes());
  return out;
}

void take_messages(EdgeMessageReader* reader, Conversation* conversation, Outcome* out) {
  const auto message = reader->take();
  const bool has_text =
      message.command == Command::HostInfo || message.command == Command::Capability;
  require(!has_text || message.memories.size() == 1, "a text is one memory");
  if (has_text) read_texts(message);
  read_metadata(message.metadata.bytes());
  if (const auto action = conversation->next(message.command))
    require((*action == Action::Close) == (message.command == Command::Error), "ERROR closes");
  out->form = reader->form();
  require(out->form.has_value(), "a message has a form");
  out->messages.push_back(written(*out->form, message));
}

Outcome read_all(std::span<const std::byte> bytes, size_t piece, std::optional<HeaderForm> form,
                 Side side) {
  EdgeMessageReader reader(kLimits, form);
  Conversation conversation(side);
  Outcome out;
  while (!bytes.empty()) {
    // In memory of its own, so that a read beyond it is found.
    const Bytes part = make_copy(bytes.first(std::min(piece, bytes.size())));
    const auto taken = reader.feed(part);
    if (!taken) {
      out.error = taken.error().message();
      require(taken.error().code == Code::PEER_MESSAGE_INVALID, "bad bytes are a peer's fault");
      require(reader.space().empty(), "nothing is read after an error");
      return out;
    }
    require(*taken > 0 && *taken <= part.size(), "the reader takes bytes");
    bytes = bytes.subspan(*taken);
    if (reader.complete()) take_messages(&reader, &conversation, &out);
  }
  if (const auto status = reader.end(); !status) out.error = status.error().message();
  if (reader.complete()) take_messages(&reader, &conversation, &out);
  return out;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::FuzzInput input(data, size);
  const uint32_t form = input.below(4);
  const size_t piece = size_t{input.byte()} + 1;
  const auto side = static_cast<Side>(input.below(6));
  const auto known = form == 3 ? std::nullopt : std::optional(static_cast<HeaderForm>(form));
  const auto bytes = input.rest();
  const auto pieces = read_all(bytes, piece, known, side);
  const auto whole = read_all(bytes, bytes.size() + 1, known, side);
  require(
      pieces.messages == whole.messages && pieces.form == whole.form && pieces.error == whole.error,
      "pieces do not matter");
  return 0;
}
