// MqttInput: frames that an edgesink publishes to an MQTT broker (connect-type=MQTT,
// docs/compatibility/edge-wire.md 10.5).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "edge/edgesrc/buffer_input.hpp"
#include "edge/message_buffer.hpp"
#include "transport/mqtt/broker_client.hpp"

namespace weir {

class MqttInput : public BufferInput {
 public:
  struct Options {
    transport::BrokerOptions broker;
    std::string topic;
    uint64_t max_bytes = 0;                     // of a message
    int interruption = -1;                      // borrowed
    std::function<void(const Error&)> refused;  // a message that is no frame of the stream
  };
  // Connects and subscribes. Errors: those of BrokerClient::open(), subscribe() and
  // wire::announcement_filter().
  static Result<std::unique_ptr<BufferInput>> connect(Options options);
  // The stream has no end and is never lost: the client connects again.
  Result<InputEvent> receive() override;
  void set_caps(const GstCaps* caps) override { buffers_.set_caps(caps); }
  void interrupt(bool interrupted) override { client_->interrupt(interrupted); }
  void add_stats(GstStructure* stats) const override;

 private:
  MqttInput(std::unique_ptr<transport::BrokerClient> client, Options options)
      : client_(std::move(client)), options_(std::move(options)) {}
  Result<InputEvent> read(transport::MqttMessage message) const;

  const std::unique_ptr<transport::BrokerClient> client_;
  const Options options_;
  MessageBuffers buffers_;
};

}  // namespace weir
