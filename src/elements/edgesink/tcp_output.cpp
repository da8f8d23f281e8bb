// One memory of a message for each tensor, or for each memory of other media.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/edgesink/tcp_output.hpp"

#include <utility>
#include <vector>

#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir {
namespace {

constexpr auto kLongestFlush = std::chrono::seconds(10);

// What a message keeps until it is sent.
struct Owner {
  gst::Ref<GstBuffer> buffer;
  std::vector<gst::MappedMemory> maps;  // unmapped before the buffer is released
};

// The bytes of a part of the buffer; empty if it does not lie in one memory.
std::span<const std::byte> find_part(const std::vector<gst::MappedMemory>& maps,
                                     const gst::FramePart& part) {
  size_t start = 0;
  for (const auto& map : maps) {
    const size_t size = map.bytes().size();
    if (part.offset >= start && part.offset < start + size)
      return part.size <= start + size - part.offset
                 ? map.bytes().subspan(part.offset - start, part.size)
                 : std::span<std::byte>();
    start += size;
  }
  return {};
}

Error not_in_one_memory() {
  return Error{.code = Code::FRAME_SIZE,
               .what = "a tensor of the buffer lies in several memories",
               .needed = "tensors that lie in one memory each",
               .fix = "put an element of tensors upstream of edgesink: tensor_transform"};
}

}  // namespace

Result<std::unique_ptr<TcpOutput>> TcpOutput::open(edge::PublisherOptions options) {
  auto publisher = edge::StreamPublisher::open(std::move(options));
  if (!publisher) return publisher.error();
  return std::unique_ptr<TcpOutput>(new TcpOutput(*std::move(publisher)));
}

Status TcpOutput::set_caps(GstCaps* caps) {
  const auto spec = gst::spec_from_caps(caps);
  has_tensors_ = spec.has_value();
  if (spec) parts_.configure(*spec);
  const gst::UniqueText text{gst_caps_to_string(caps)};
  return publisher_->set_caps(text.get());
}

Result<BufferOutput::Outcome> TcpOutput::publish(GstBuffer* buffer, Ledger*) {
  if (publisher_->counts().subscribers == 0) return Outcome::NoReceiver;
  auto owner = std::make_shared<Owner>();
  owner->buffer = gst::Ref<GstBuffer>::share(buffer);
  std::vector<std::span<const std::byte>> memories;
  for (guint i = 0; i < gst_buffer_n_memory(buffer); ++i) {
    owner->maps.emplace_back(gst_buffer_peek_memory(buffer, i), GST_MAP_READ);
    if (!owner->maps.back())
      return Error{.code = Code::MAPPING_FAILED,
                   .what = "a memory of the buffer cannot be mapped for reading",
                   .needed = "memory that the CPU can read"};
    memories.emplace_back(owner->maps.back().bytes());
  }
  if (has_tensors_) {
    if (auto status = parts_.read(buffer); !status) return status.error();
    memories.clear();
    for (const auto& part : parts_.parts()) {
      memories.push_back(find_part(owner->maps, part));
      if (memories.back().size() != part.size) return not_in_one_memory();
    }
  }
  const auto outcome = publisher_->publish(std::move(memories), std::move(owner));
  if (!outcome) return outcome.error();
  switch (*outcome) {
    case edge::StreamPublisher::Outcome::Sent:
      return Outcome::Sent;
    case edge::StreamPublisher::Outcome::NoSubscriber:
      return Outcome::NoReceiver;
    case edge::StreamPublisher::Outcome::Missed:
      break;
  }
  return Outcome::Missed;
}

void TcpOutput::end() {
  publisher_->flush(isolate::deadline_in(kLongestFlush));
}

void TcpOutput::propose_allocation(GstQuery*) {}

void TcpOutput::add_stats(GstStructure* stats) const {
  const auto counts = publisher_->counts();
  gst_structure_set(stats, "receivers", G_TYPE_UINT, counts.subscribers, "refused", G_TYPE_UINT64,
                    counts.refused, "missed", G_TYPE_UINT64, counts.missed, nullptr);
}

}  // namespace weir
