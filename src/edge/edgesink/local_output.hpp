// LocalOutput: buffers of edgesink to other processes in shared memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "edge/edgesink/buffer_output.hpp"
#include "gstcpp/element/ref.hpp"
#include "transport/local/publisher.hpp"

namespace weir {

class LocalOutput : public BufferOutput {
 public:
  // Listens. Errors: those of local::Publisher::open().
  static Result<std::unique_ptr<BufferOutput>> open(local::PublisherOptions options);

  Status set_caps(GstCaps* caps) override;
  Result<Outcome> publish(GstBuffer* buffer, Ledger* ledger) override;
  void end() override { publisher_->end(); }
  bool wait_for_receiver(const io::Deadline& deadline) override {
    return publisher_->wait_for_reader(deadline);
  }
  void interrupt() override { publisher_->interrupt(); }
  void resume() override { publisher_->resume(); }
  void propose_allocation(GstQuery* query) override;
  void add_stats(GstStructure* stats) const override;

 private:
  explicit LocalOutput(std::unique_ptr<local::Publisher> publisher);
  using Block = std::shared_ptr<isolate::SharedBlock>;
  enum class Made { Frame, Interrupted };

  Result<Made> make_frame(GstBuffer* buffer, Ledger* ledger);
  // Shared memory for `bytes`; null when interrupted.
  Result<Block> allocate(size_t bytes);
  Result<Made> copy(const std::vector<std::span<const std::byte>>& parts, Block* owner);

  const std::unique_ptr<local::Publisher> publisher_;
  const gst::Ref<GstAllocator> allocator_;  // of the publisher's memory
  local::LocalFrame frame_;                 // that was interrupted, or empty
  gst::Ref<GstBuffer> interrupted_;         // its buffer, so that no other has its address
};

}  // namespace weir
