// StreamPublisher: the sending end of a stream in NNStreamer's protocol over TCP
// (docs/compatibility/edge-wire.md 10.1, 10.4).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/io/deadline.hpp"
#include "core/wire/edge_header.hpp"
#include "transport/edge/stream_socket.hpp"
#include "transport/edge/subscriber_link.hpp"
#include "transport/poll_server.hpp"

namespace weir::edge {

// A subscriber whose queue has no room for a frame.
struct Outage {
  std::string address;
  size_t queued = 0;    // frames
  uint64_t missed = 0;  // frames since it connected
};

struct StreamPublisherOptions {
  std::string host;
  uint32_t port = 0;  // 0 = a free one
  wire::HeaderForm form = wire::HeaderForm::Bytes2088;
  QueueLimits queue;
  uint32_t max_subscribers = 32, max_per_address = 32;
  std::function<bool(const std::string& address)> allowed;  // empty: every address
  std::function<void(const Error&)> refused;  // called for each peer that is refused; any thread
  // Called by publish() when a subscriber misses the first frame of an outage.
  std::function<void(const Outage&)> fallen_behind{};
};

struct StreamPublisherCounts {
  uint32_t subscribers = 0;
  uint64_t refused = 0;  // connections that were closed because of what they are or sent
  uint64_t missed = 0;   // frames that were not sent to a subscriber, over all of them
  uint32_t waiting = 0;  // for the caps
};

// publish(), set_caps() and flush() are called by one thread; everything else by any. A subscriber
// that does not read stalls no other: each has a queue, and misses frames when it is full.
class StreamPublisher : public transport::PollServer<SubscriberLink> {
 public:
  // Listens. Errors: those of listen_on().
  static Result<std::unique_ptr<StreamPublisher>> open(StreamPublisherOptions options);
  ~StreamPublisher() override;

  uint16_t port() const noexcept { return get_port(listener_.get()); }
  // Announces the caps to the subscribers that wait for them, and to later ones. Until then, a
  // subscriber that connects gets no CAPABILITY. OPTION_VALUE, LIMIT_EXCEEDED: no text of the
  // protocol.
  Status set_caps(const std::string& caps);
  // For a stream without caps: announces none unless set_caps() was called. Call it before the
  // first frame.
  Status set_no_caps();
  // Whether publish() has a subscriber to queue a frame for.
  bool has_subscriber() const;
  enum class Outcome { Sent, NoSubscriber, Missed };
  // Queues a frame for every subscriber. `owner` keeps the memories until all have been sent.
  // Errors: those of wire::write_header().
  Result<Outcome> publish(std::vector<std::span<const std::byte>> memories,
                          std::shared_ptr<const void> owner);
  // Waits until all queues are empty; false after the deadline or an interruption.
  bool flush(const io::Deadline& deadline);

  bool wait_for_subscriber(const io::Deadline& deadline);
  StreamPublisherCounts counts() const;

 private:
  explicit StreamPublisher(StreamPublisherOptions options)
      : PollServer(options.refused), options_(std::move(options)) {}
  Outcome queue(const std::shared_ptr<const SharedMessage>& message, std::vector<Outage>* outages);
  uint32_t count(SubscriberLink::State state) const;
  uint32_t count_subscribers() const { return count(SubscriberLink::State::Subscribed); }
  std::string reason_to_refuse(const std::string& address) const;
  int listening() const override { return listener_.get(); }
  Descriptor accept() override { return accept_from(listener_.get()); }
  void add(Descriptor socket) override;
  io::Deadline watch(const Clients& links, std::vector<pollfd>* watched) override;
  void attend(const Client& link, const pollfd* events, SubscriberLink::Input input) override;

  const StreamPublisherOptions options_;
  Descriptor listener_;
  // Guarded by the mutex.
  std::vector<std::byte> greeting_;
  uint64_t missed_ = 0;
};

}  // namespace weir::edge
