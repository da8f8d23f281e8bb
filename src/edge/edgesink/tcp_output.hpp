// TcpOutput: buffers of edgesink in NNStreamer's protocol over TCP.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "edge/edgesink/buffer_output.hpp"
#include "edge/message_memories.hpp"
#include "transport/edge/stream_publisher.hpp"

namespace weir {

class TcpOutput : public BufferOutput {
 public:
  // Listens. Errors: those of edge::StreamPublisher::open().
  static Result<std::unique_ptr<TcpOutput>> open(edge::StreamPublisherOptions options);

  uint16_t port() const noexcept { return publisher_->port(); }
  Status set_caps(GstCaps* caps) override;
  Status set_no_caps() override { return publisher_->set_no_caps(); }
  Result<Outcome> publish(GstBuffer* buffer, Ledger* ledger) override;
  // The protocol has no end of stream: waits until the last frame has been sent.
  void end() override;
  bool wait_for_receiver(const io::Deadline& deadline) override {
    return publisher_->wait_for_subscriber(deadline);
  }
  void interrupt() override { publisher_->interrupt(); }
  void resume() override { publisher_->resume(); }
  void propose_allocation(GstQuery* query) override;
  void add_stats(GstStructure* stats) const override;

 private:
  explicit TcpOutput(std::unique_ptr<edge::StreamPublisher> publisher)
      : publisher_(std::move(publisher)) {}

  const std::unique_ptr<edge::StreamPublisher> publisher_;
  MemoryMapper mapper_;
};

}  // namespace weir
