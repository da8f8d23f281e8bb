// Wraps the memories of messages as buffers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/edgesrc/tcp_input.hpp"

#include <utility>

#include "core/wire/peer_error.hpp"

namespace weir {
namespace {

using Bytes = std::unique_ptr<std::byte[]>;

void free_bytes(gpointer bytes) {
  const std::unique_ptr<Bytes> owned(static_cast<Bytes*>(bytes));
}

GstMemory* memory_of(wire::ByteBlock block) {
  auto owner = std::make_unique<Bytes>(std::move(block.data));
  std::byte* const data = owner->get();
  return gst_memory_new_wrapped(GstMemoryFlags(0), data, block.size, 0, block.size, owner.release(),
                                free_bytes);
}

Result<gst::Ref<GstBuffer>> buffer_of(std::vector<wire::ByteBlock> memories) {
  if (memories.size() > gst_buffer_get_max_memory())
    return wire::peer_error("a frame has more memories than a buffer",
                            std::to_string(memories.size()),
                            "at most " + std::to_string(gst_buffer_get_max_memory()));
  auto out = gst::Ref<GstBuffer>::adopt(gst_buffer_new());
  for (auto& memory : memories) gst_buffer_append_memory(out.get(), memory_of(std::move(memory)));
  GST_BUFFER_FLAG_UNSET(out.get(), GST_BUFFER_FLAG_TAG_MEMORY);  // set by appending
  return out;
}

}  // namespace

Result<std::unique_ptr<BufferInput>> TcpInput::connect(const std::string& host, uint32_t port,
                                                       uint64_t most_bytes, int interruption) {
  auto subscriber =
      edge::StreamSubscriber::connect(host, port, {.message_bytes = most_bytes}, interruption);
  if (!subscriber) return subscriber.error();
  return std::unique_ptr<BufferInput>(new TcpInput(*std::move(subscriber), interruption));
}

Result<InputEvent> TcpInput::receive() {
  if (!std::exchange(has_given_caps_, true) && !subscriber_.caps().empty()) {
    auto caps = gst::Ref<GstCaps>::adopt(gst_caps_from_string(subscriber_.caps().c_str()));
    if (!caps)
      return wire::peer_error("the caps of the edgesink are no caps",
                              wire::quoted_text(subscriber_.caps()), "caps");
    if (gst_caps_is_fixed(caps.get()))
      return InputEvent{InputEvent::Kind::Caps, std::move(caps), {}};
  }
  auto received = subscriber_.receive(interruption_);
  if (!received) return received.error();
  if (received->end)
    return InputEvent{*received->end == edge::StreamSubscriber::End::Lost
                          ? InputEvent::Kind::Lost
                          : InputEvent::Kind::Interrupted};
  auto buffer = buffer_of(std::move(received->memories));
  if (!buffer) return buffer.error();
  return InputEvent{InputEvent::Kind::Buffer, {}, *std::move(buffer)};
}

}  // namespace weir
