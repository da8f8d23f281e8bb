// TcpInput: buffers of an edgesink in NNStreamer's protocol over TCP.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>

#include "elements/edgesrc/buffer_input.hpp"
#include "elements/edgesrc/message_buffer.hpp"
#include "transport/edge/stream_subscriber.hpp"

namespace weir {

class TcpInput : public BufferInput {
 public:
  using Times = edge::StreamSubscriber::Times;
  // Connects. `interruption` is borrowed. Errors: those of edge::StreamSubscriber::connect().
  static Result<std::unique_ptr<BufferInput>> connect(const std::string& host, uint32_t port,
                                                      uint64_t most_bytes, const Times& times,
                                                      int interruption);
  Result<InputEvent> receive() override;
  void set_caps(const GstCaps* caps) override { buffers_.set_caps(caps); }

 private:
  TcpInput(edge::StreamSubscriber subscriber, int interruption)
      : subscriber_(std::move(subscriber)), interruption_(interruption) {}

  edge::StreamSubscriber subscriber_;
  const int interruption_;
  bool has_given_caps_ = false;
  MessageBuffers buffers_;
};

}  // namespace weir
