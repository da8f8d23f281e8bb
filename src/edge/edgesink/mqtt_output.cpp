// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/edgesink/mqtt_output.hpp"

#include <utility>

namespace weir {
namespace {

using namespace std::chrono_literals;
constexpr int kQos = 1;
constexpr auto kPublishTime = 1s, kFlushTime = 10s, kWithdrawTime = 1s;

}  // namespace

Result<std::unique_ptr<BufferOutput>> MqttOutput::open(Options options) {
  auto topic = wire::announcement_topic(options.id, options.topic);
  if (!topic) return topic.error();
  options.broker.will =
      transport::MqttWill{.topic = *topic, .payload = {}, .qos = kQos, .retain = true};
  auto client = transport::BrokerClient::open(std::move(options.broker));
  if (!client) return client.error();
  return std::unique_ptr<BufferOutput>(new MqttOutput(*std::move(client), *std::move(topic),
                                                      options.form, std::move(options.outage)));
}

MqttOutput::~MqttOutput() {
  client_->remove_retained(topic_, kQos, kWithdrawTime);
}

Status MqttOutput::set_caps(GstCaps* caps) {
  mapper_.set_caps(caps);
  return ok();
}

Status MqttOutput::make_payload(const MessageMemories& message) {
  std::vector<uint64_t> sizes;
  size_t total = 0;
  for (const auto& memory : message.memories) {
    sizes.push_back(memory.size());
    total += memory.size();
  }
  auto header = wire::write_mqtt_frame_header(form_, sizes, 0);
  if (!header) return header.error();
  payload_ = *std::move(header);
  payload_.reserve(payload_.size() + total);
  for (const auto& memory : message.memories)
    payload_.insert(payload_.end(), memory.begin(), memory.end());
  return ok();
}

Result<BufferOutput::Outcome> MqttOutput::publish(GstBuffer* buffer, Ledger* ledger) {
  const auto message = mapper_.map(buffer);
  if (!message) return message.error();
  if (auto status = make_payload(*message); !status) return status.error();
  const auto status = client_->publish(
      {.topic = topic_, .payload = payload_, .qos = kQos, .retain = true, .properties = {}},
      kPublishTime);
  if (status) {
    has_outage_ = false;
    for (const auto& memory : message->memories) ledger->copied(memory.size());
    return Outcome::Sent;
  }
  if (status.error().code == Code::CANCELLED) return Outcome::Interrupted;
  if (status.error().code != Code::BROKER_UNREACHABLE) return status.error();
  if (!std::exchange(has_outage_, true)) outage_(status.error());
  return Outcome::Missed;
}

void MqttOutput::end() {
  client_->flush(kFlushTime);
}

void MqttOutput::add_stats(GstStructure* stats) const {
  const auto counts = client_->counts();
  gst_structure_set(stats, "connections", G_TYPE_UINT64, counts.connections, "messages-published",
                    G_TYPE_UINT64, counts.published, "messages-refused", G_TYPE_UINT64,
                    counts.refused, nullptr);
}

}  // namespace weir
