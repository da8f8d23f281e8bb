// MqttOutput: buffers of edgesink as messages of an MQTT broker (connect-type=MQTT,
// docs/compatibility/edge-wire.md 10.5).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/wire/mqtt_frame.hpp"
#include "edge/edgesink/buffer_output.hpp"
#include "edge/message_memories.hpp"
#include "transport/mqtt/broker_client.hpp"

namespace weir {

class MqttOutput : public BufferOutput {
 public:
  struct Options {
    transport::BrokerOptions broker;
    std::string id, topic;  // see wire::announcement_topic()
    wire::MqttForm form = wire::MqttForm::Bytes2080;
    std::function<void(const Error&)> outage;  // called when the broker begins to be unreachable
  };
  // Connects. Errors: those of BrokerClient::open() and wire::announcement_topic().
  static Result<std::unique_ptr<BufferOutput>> open(Options options);
  // Removes the last frame from the broker, which otherwise keeps it.
  ~MqttOutput() override;

  Status set_caps(GstCaps* caps) override;
  // Missed = the broker took nothing for a second.
  Result<Outcome> publish(GstBuffer* buffer, Ledger* ledger) override;
  void end() override;
  // The receiver is the broker, which is connected.
  bool wait_for_receiver(const io::Deadline&) override { return true; }
  void interrupt() override { client_->interrupt(true); }
  void resume() override { client_->interrupt(false); }
  void propose_allocation(GstQuery*) override {}
  void add_stats(GstStructure* stats) const override;

 private:
  MqttOutput(std::unique_ptr<transport::BrokerClient> client, std::string topic,
             wire::MqttForm form, std::function<void(const Error&)> outage)
      : client_(std::move(client)),
        topic_(std::move(topic)),
        form_(form),
        outage_(std::move(outage)) {}
  Status make_payload(const MessageMemories& message);

  const std::unique_ptr<transport::BrokerClient> client_;
  const std::string topic_;
  const wire::MqttForm form_;
  const std::function<void(const Error&)> outage_;
  MemoryMapper mapper_;
  std::vector<std::byte> payload_;
  bool has_outage_ = false;
};

}  // namespace weir
