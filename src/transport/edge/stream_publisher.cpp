// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/edge/stream_publisher.hpp"

#include <algorithm>
#include <utility>

#include "core/wire/edge_capability.hpp"

namespace weir::edge {
namespace {

Error refused_subscriber(const std::string& address, const std::string& reason) {
  return Error{.code = Code::PEER_MESSAGE_INVALID,
               .what = "a subscriber was refused",
               .offered = address + ": " + reason,
               .needed = "an edgesrc that speaks the protocol of nnstreamer-edge"};
}

}  // namespace

Result<std::unique_ptr<StreamPublisher>> StreamPublisher::open(StreamPublisherOptions options) {
  auto listener = listen_on(options.host, options.port);
  if (!listener) return listener.error();
  std::unique_ptr<StreamPublisher> out(new StreamPublisher(std::move(options)));
  out->listener_ = *std::move(listener);
  out->start();
  return out;
}

StreamPublisher::~StreamPublisher() {
  join();
  for (const auto& link : clients_) link->send_error();
}

Status StreamPublisher::set_caps(const std::string& caps) {
  const auto text = wire::publisher_capability_text(caps);
  if (!text) return text.error();
  auto message = wire::text_message(options_.form, wire::Command::Capability, 0, *text);
  if (!message) return message.error();
  const std::lock_guard lock(mutex_);
  greeting_ = *std::move(message);
  for (const auto& link : clients_)
    if (link->state() == SubscriberLink::State::Waiting) link->queue_greeting(greeting_);
  wake_->set();
  return ok();
}

Status StreamPublisher::set_no_caps() {
  {
    const std::lock_guard lock(mutex_);
    if (!greeting_.empty()) return ok();
  }
  return set_caps("");
}

bool StreamPublisher::has_subscriber() const {
  const std::lock_guard lock(mutex_);
  return std::any_of(clients_.begin(), clients_.end(),
                     [](const auto& link) { return link->gets_frames(); });
}

uint32_t StreamPublisher::count(SubscriberLink::State state) const {
  return static_cast<uint32_t>(
      std::count_if(clients_.begin(), clients_.end(),
                    [state](const auto& link) { return link->state() == state; }));
}

Result<StreamPublisher::Outcome> StreamPublisher::publish(
    std::vector<std::span<const std::byte>> memories, std::shared_ptr<const void> owner) {
  wire::EdgeHeader header{.command = wire::Command::TransferData};
  auto message = std::make_shared<SharedMessage>();
  for (const auto& memory : memories) {
    header.sizes.push_back(memory.size());
    message->bytes += memory.size();
  }
  auto bytes = wire::write_header(options_.form, header);
  if (!bytes) return bytes.error();
  message->bytes += bytes->size();
  message->header = *std::move(bytes);
  message->memories = std::move(memories);
  message->owner = std::move(owner);
  std::vector<Outage> outages;
  const Outcome outcome = queue(message, &outages);
  if (outcome == Outcome::Sent) wake_->set();
  if (options_.fallen_behind)
    for (const Outage& outage : outages) options_.fallen_behind(outage);
  return outcome;
}

StreamPublisher::Outcome StreamPublisher::queue(const std::shared_ptr<const SharedMessage>& message,
                                                std::vector<Outage>* outages) {
  Outcome best = Outcome::NoSubscriber;
  const std::lock_guard lock(mutex_);
  for (const auto& link : clients_) {
    if (!link->gets_frames()) continue;
    const bool queued = link->queue_frame(message, options_.queue);
    if (!queued) ++missed_;
    if (link->has_fallen_behind())
      outages->push_back({link->address(), link->queued_frames(), link->missed()});
    if (queued || best == Outcome::NoSubscriber) best = queued ? Outcome::Sent : Outcome::Missed;
  }
  return best;
}

bool StreamPublisher::flush(const io::Deadline& deadline) {
  Lock lock(mutex_);
  return wait(&lock, deadline, [this] {
    return std::none_of(clients_.begin(), clients_.end(), [](const auto& link) {
      return link->state() != SubscriberLink::State::Gone && link->has_unsent();
    });
  });
}

bool StreamPublisher::wait_for_subscriber(const io::Deadline& deadline) {
  Lock lock(mutex_);
  return wait(&lock, deadline, [this] { return count_subscribers() > 0; });
}

StreamPublisherCounts StreamPublisher::counts() const {
  const std::lock_guard lock(mutex_);
  return {count_subscribers(), refused_count_, missed_, count(SubscriberLink::State::Waiting)};
}

std::string StreamPublisher::reason_to_refuse(const std::string& address) const {
  if (options_.allowed && !options_.allowed(address))
    return "the property allow does not contain its address";
  if (clients_.size() >= options_.max_subscribers)
    return std::to_string(options_.max_subscribers) + " subscribers are already connected";
  const auto of_address = std::count_if(clients_.begin(), clients_.end(), [&](const auto& link) {
    return link->address() == address;
  });
  if (static_cast<uint32_t>(of_address) >= options_.max_per_address)
    return std::to_string(of_address) + " subscribers with its address are already connected";
  return "";
}

void StreamPublisher::add(Descriptor socket) {
  const auto link =
      std::make_shared<SubscriberLink>(std::move(socket), options_.form, new_client_id());
  if (const auto reason = reason_to_refuse(link->address()); !reason.empty())
    return refuse(link.get(), refused_subscriber(link->address(), reason));
  if (greeting_.empty())
    link->wait_for_greeting();
  else
    link->queue_greeting(greeting_);
  link->send();
  clients_.push_back(link);
}

io::Deadline StreamPublisher::watch(const Clients& links, std::vector<pollfd>* watched) {
  io::Deadline next;
  for (const auto& link : links) {
    const auto events = static_cast<short>(link->can_send() ? POLLIN | POLLOUT : POLLIN);
    watched->push_back({link->socket(), events, 0});
    next = io::earlier(next, link->removal_deadline(options_.queue));
  }
  return next;
}

void StreamPublisher::attend(const Client& link, const pollfd*, SubscriberLink::Input input) {
  link->send();
  if (link->is_gone()) return;
  auto reason = link->take(input);
  if (!reason && io::is_over(link->removal_deadline(options_.queue)))
    reason = "it does not complete the handshake, or does not read";
  if (reason) refuse(link.get(), refused_subscriber(link->address(), *reason));
}

}  // namespace weir::edge
