// TcpInput: buffers of an edgesink in NNStreamer's protocol over TCP.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <optional>
#include <string>

#include "edge/edgesrc/buffer_input.hpp"
#include "edge/message_buffer.hpp"
#include "transport/edge/stream_subscriber.hpp"

namespace weir {

class TcpInput : public BufferInput {
 public:
  using Times = edge::StreamSubscriber::Times;
  // Connects; receive() waits for the handshake, and reports after `times.greet` that it has not
  // begun. `interruption` is borrowed. Errors: those of
  // edge::StreamSubscriber::open().
  static Result<std::unique_ptr<BufferInput>> open(const std::string& host, uint32_t port,
                                                   uint64_t max_bytes, const Times& times,
                                                   int interruption);
  // Connects and completes the handshake. Errors: those of edge::StreamSubscriber::connect().
  static Result<std::unique_ptr<BufferInput>> connect(const std::string& host, uint32_t port,
                                                      uint64_t max_bytes, const Times& times,
                                                      int interruption);
  Result<InputEvent> receive() override;
  void set_caps(const GstCaps* caps) override { buffers_.set_caps(caps); }

 private:
  TcpInput(edge::StreamSubscriber subscriber, const Times& times, int interruption, bool is_greeted)
      : subscriber_(std::move(subscriber)),
        times_(times),
        interruption_(interruption),
        is_greeted_(is_greeted) {}
  // Nullopt: the handshake is complete.
  Result<std::optional<InputEvent>> greet();
  // Nullopt: the edgesink has announced none, or none that are fixed.
  Result<std::optional<InputEvent>> announced_caps() const;

  edge::StreamSubscriber subscriber_;
  const Times times_;
  const int interruption_;
  bool is_greeted_, was_silent_ = false, has_given_caps_ = false;
  MessageBuffers buffers_;
};

}  // namespace weir
