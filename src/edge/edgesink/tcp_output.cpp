// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/edgesink/tcp_output.hpp"

#include <utility>

#include "gstcpp/element/ref.hpp"

namespace weir {
namespace {

constexpr auto kMaxFlush = std::chrono::seconds(10);

}  // namespace

Result<std::unique_ptr<TcpOutput>> TcpOutput::open(edge::StreamPublisherOptions options) {
  auto publisher = edge::StreamPublisher::open(std::move(options));
  if (!publisher) return publisher.error();
  return std::unique_ptr<TcpOutput>(new TcpOutput(*std::move(publisher)));
}

Status TcpOutput::set_caps(GstCaps* caps) {
  mapper_.set_caps(caps);
  const gst::UniqueText text{gst_caps_to_string(caps)};
  return publisher_->set_caps(text.get());
}

Result<BufferOutput::Outcome> TcpOutput::publish(GstBuffer* buffer, Ledger*) {
  if (!publisher_->has_subscriber()) return Outcome::NoReceiver;
  auto mapped = mapper_.map(buffer);
  if (!mapped) return mapped.error();
  const auto outcome = publisher_->publish(std::move(mapped->memories), std::move(mapped->owner));
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
  publisher_->flush(io::deadline_in(kMaxFlush));
}

void TcpOutput::propose_allocation(GstQuery*) {}

void TcpOutput::add_stats(GstStructure* stats) const {
  const auto counts = publisher_->counts();
  gst_structure_set(stats, "receivers", G_TYPE_UINT, counts.subscribers, "refused", G_TYPE_UINT64,
                    counts.refused, "missed", G_TYPE_UINT64, counts.missed, nullptr);
}

}  // namespace weir
