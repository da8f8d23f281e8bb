// LocalOutput: buffers of edgesink to other processes in shared memory. Finds where their memories
// lie in it, and copies those that do not.
// SPDX-License-Identifier: LGPL-2.1-or-later

#include <gst/video/gstvideometa.h>

#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "edge/buffer_metas.hpp"
#include "edge/edgesink/buffer_output.hpp"
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/element/ref.hpp"
#include "transport/local/publisher.hpp"

namespace weir {

class LocalOutput : public BufferOutput {
 public:
  explicit LocalOutput(std::unique_ptr<local::Publisher> publisher);
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
namespace {

constexpr size_t kAlignment = 64;

size_t aligned(size_t bytes) {
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

local::FrameTimes get_times(GstBuffer* buffer) {
  return {.pts = GST_BUFFER_PTS(buffer),
          .dts = GST_BUFFER_DTS(buffer),
          .duration = GST_BUFFER_DURATION(buffer),
          .offset = GST_BUFFER_OFFSET(buffer),
          .offset_end = GST_BUFFER_OFFSET_END(buffer),
          .flags = GST_BUFFER_FLAGS(buffer)};
}

// What a frame keeps until every reader released it.
struct Owner {
  gst::Ref<GstBuffer> buffer;  // if its memory is read in place
  std::shared_ptr<isolate::SharedBlock> copy;
};

Error not_readable() {
  return Error{.code = Code::MAPPING_FAILED,
               .what = "a memory of the buffer cannot be mapped for reading",
               .needed = "memory that the CPU can read"};
}

}  // namespace

LocalOutput::LocalOutput(std::unique_ptr<local::Publisher> publisher)
    : publisher_(std::move(publisher)), allocator_(gst::shared_allocator(publisher_->arena())) {}

Result<std::unique_ptr<BufferOutput>> open_local_output(local::LocalPublisherOptions options) {
  auto publisher = local::Publisher::open(std::move(options));
  if (!publisher) return publisher.error();
  return std::unique_ptr<BufferOutput>(new LocalOutput(*std::move(publisher)));
}

Status LocalOutput::set_caps(GstCaps* caps) {
  const gst::UniqueText text{gst_caps_to_string(caps)};
  return publisher_->set_caps(text.get());
}

Result<LocalOutput::Block> LocalOutput::allocate(size_t bytes) {
  using Release = local::Publisher::Release;
  for (;;) {
    const uint64_t releases = publisher_->releases();
    if (Block block = publisher_->arena()->allocate(bytes)) return block;
    switch (publisher_->wait_for_release(releases)) {
      case Release::Released:
        continue;
      case Release::Interrupted:
        return Block();
      case Release::NoneHeld:
        return Error{.code = Code::OUT_OF_MEMORY,
                     .what = "no shared memory for a frame",
                     .offered = std::to_string(bytes) + " bytes",
                     .needed = "free memory and file descriptors"};
    }
  }
}

// Appends one memory for each part, in one block.
Result<LocalOutput::Made> LocalOutput::copy(const std::vector<std::span<const std::byte>>& parts,
                                            Block* owner) {
  size_t total = 0;
  for (const auto& part : parts) total += aligned(part.size());
  auto block = allocate(total);
  if (!block) return block.error();
  if (!*block) return Made::Interrupted;
  const auto place = publisher_->arena()->find((*block)->data(), total);
  size_t offset = 0;
  for (const auto& part : parts) {
    if (!part.empty()) std::memcpy((*block)->data() + offset, part.data(), part.size());
    frame_.memories.push_back({place->block, offset, part.size()});
    offset += aligned(part.size());
  }
  *owner = *std::move(block);
  return Made::Frame;
}

Result<LocalOutput::Made> LocalOutput::make_frame(GstBuffer* buffer, Ledger* ledger) {
  frame_ = {};
  frame_.times = get_times(buffer);
  frame_.metas = encode_metas(buffer);
  std::vector<gst::MappedMemory> maps;  // until everything is found or copied
  std::vector<std::span<const std::byte>> foreign;
  std::vector<std::optional<isolate::SharedArena::Place>> places;
  for (guint i = 0; i < gst_buffer_n_memory(buffer); ++i) {
    maps.emplace_back(gst_buffer_peek_memory(buffer, i), GST_MAP_READ);
    if (!maps.back()) return not_readable();
    const auto bytes = maps.back().bytes();
    places.push_back(publisher_->arena()->find(bytes.data(), bytes.size()));
    if (places.back()) continue;
    foreign.emplace_back(bytes);
    ledger->copied(bytes.size());
  }
  const bool long_metas = frame_.metas.size() > local::kMaxMetasInMessage;
  if (long_metas) foreign.emplace_back(frame_.metas);
  auto owner = std::make_shared<Owner>();
  if (!foreign.empty()) {
    auto made = copy(foreign, &owner->copy);
    if (!made || *made == Made::Interrupted) return made;
  }
  // The copies are in the order of the memories: put those in place between them.
  std::vector<local::LocalFrame::Memory> memories;
  size_t copied = 0;
  for (size_t i = 0; i < places.size(); ++i)
    memories.push_back(places[i] ? local::LocalFrame::Memory{places[i]->block, places[i]->offset,
                                                             maps[i].bytes().size()}
                                 : frame_.memories[copied++]);
  if (long_metas) {
    memories.push_back(frame_.memories[copied]);
    frame_.metas.clear();
    frame_.metas_are_memory = true;
  }
  if (copied < places.size()) owner->buffer = gst::Ref<GstBuffer>::share(buffer);
  frame_.memories = std::move(memories);
  frame_.owner = std::move(owner);
  return Made::Frame;
}

Result<BufferOutput::Outcome> LocalOutput::publish(GstBuffer* buffer, Ledger* ledger) {
  if (interrupted_.get() != buffer) {
    if (publisher_->counts().readers == 0) return Outcome::NoReceiver;
    const auto made = make_frame(buffer, ledger);
    if (!made) return made.error();
    if (*made == Made::Interrupted) return Outcome::Interrupted;
  }
  interrupted_ = {};
  switch (publisher_->publish(&frame_)) {
    case local::Publisher::Outcome::Sent:
      frame_ = {};
      return Outcome::Sent;
    case local::Publisher::Outcome::NoReader:
      frame_ = {};
      return Outcome::NoReceiver;
    case local::Publisher::Outcome::Missed:
      frame_ = {};
      return Outcome::Missed;
    case local::Publisher::Outcome::Interrupted:
      break;
  }
  interrupted_ = gst::Ref<GstBuffer>::share(buffer);
  return Outcome::Interrupted;
}

void LocalOutput::propose_allocation(GstQuery* query) {
  GstAllocationParams params;
  gst_allocation_params_init(&params);
  params.align = kAlignment - 1;
  gst_query_add_allocation_param(query, allocator_.get(), &params);
  gst_query_add_allocation_meta(query, GST_VIDEO_META_API_TYPE, nullptr);
}

void LocalOutput::add_stats(GstStructure* stats) const {
  const auto counts = publisher_->counts();
  gst_structure_set(stats, "receivers", G_TYPE_UINT, counts.readers, "refused", G_TYPE_UINT64,
                    counts.refused, "missed", G_TYPE_UINT64, counts.missed, nullptr);
}

}  // namespace weir
