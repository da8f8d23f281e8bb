// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/edgesrc/mqtt_input.hpp"

#include <poll.h>

#include <utility>

#include "core/wire/mqtt_frame.hpp"

namespace weir {
namespace {

using Payload = std::vector<std::byte>;
constexpr int kInputQos = 1;

}  // namespace

Result<std::unique_ptr<BufferInput>> MqttInput::connect(Options options) {
  const auto filter = wire::announcement_filter(options.topic);
  if (!filter) return filter.error();
  auto client = transport::BrokerClient::open(options.broker);
  if (!client) return client.error();
  if (auto status = (*client)->subscribe(*filter, kInputQos); !status) return status.error();
  return std::unique_ptr<BufferInput>(new MqttInput(*std::move(client), std::move(options)));
}

Result<InputEvent> MqttInput::read(transport::MqttMessage message) const {
  auto owned = std::make_unique<Payload>(std::move(message.payload));
  const auto frame = wire::parse_mqtt_frame(*owned, {.message_bytes = options_.max_bytes});
  if (!frame) return frame.error();
  std::byte* const bytes = owned->data();
  const size_t size = owned->size();
  const auto whole = gst::Ref<GstMemory>::adopt(gst_memory_new_wrapped(
      GST_MEMORY_FLAG_READONLY, bytes, size, 0, size, owned.release(), [](gpointer payload) {
        const std::unique_ptr<Payload> ended(static_cast<Payload*>(payload));
      }));
  std::vector<gst::Ref<GstMemory>> memories;
  for (const auto& memory : frame->memories)
    memories.push_back(gst::Ref<GstMemory>::adopt(
        gst_memory_share(whole.get(), memory.data() - bytes, static_cast<gssize>(memory.size()))));
  InputEvent out{InputEvent::Kind::Buffer};
  auto buffer = buffers_.make(std::move(memories), &out.copied);
  if (!buffer) return buffer.error();
  out.buffer = *std::move(buffer);
  return out;
}

Result<InputEvent> MqttInput::receive() {
  for (;;) {
    pollfd watched{options_.interruption, POLLIN, 0};
    if (poll(&watched, 1, 0) > 0) return InputEvent{InputEvent::Kind::Interrupted};
    auto message = client_->receive(std::chrono::hours(1));
    // A publisher that ends empties the message that the broker keeps.
    if (!message || message->payload.empty()) continue;
    auto event = read(*std::move(message));
    if (event) return event;
    if (event.error().code == Code::OUT_OF_MEMORY) return event;
    options_.refused(event.error());
  }
}

void MqttInput::add_stats(GstStructure* stats) const {
  const auto counts = client_->counts();
  gst_structure_set(stats, "connections", G_TYPE_UINT64, counts.connections, "missed",
                    G_TYPE_UINT64, counts.dropped, nullptr);
}

}  // namespace weir
