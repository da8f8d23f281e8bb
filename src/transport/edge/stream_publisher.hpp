// StreamPublisher: the sending end of a stream in NNStreamer's protocol over TCP
// (docs/compatibility/edge-wire.md 10.1, 10.4).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <poll.h>

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "core/io/deadline.hpp"
#include "core/wire/edge_header.hpp"
#include "transport/edge/stream_socket.hpp"
#include "transport/edge/subscriber_link.hpp"
#include "transport/wake_event.hpp"

namespace weir::edge {

// A subscriber whose queue has no room for a frame.
struct Outage {
  std::string address;
  size_t queued = 0;    // frames
  uint64_t missed = 0;  // frames since it connected
};

struct PublisherOptions {
  std::string host;
  uint32_t port = 0;  // 0 = a free one
  wire::HeaderForm form = wire::HeaderForm::Bytes2088;
  QueueLimits queue;
  uint32_t most_subscribers = 32, most_of_one_address = 32;
  std::function<bool(const std::string& address)> allowed;  // empty: every address
  std::function<void(const Error&)> refused;  // called for each peer that is refused; any thread
  // Called by publish() when a subscriber misses the first frame of an outage.
  std::function<void(const Outage&)> fallen_behind{};
};

struct PublisherCounts {
  uint32_t subscribers = 0;
  uint64_t refused = 0;  // connections that were closed because of what they are or sent
  uint64_t missed = 0;   // frames that were not sent to a subscriber, over all of them
  uint32_t waiting = 0;  // for the caps
};

// publish(), set_caps() and flush() are called by one thread; everything else by any. A subscriber
// that does not read stalls no other: each has a queue, and misses frames when it is full.
class StreamPublisher {
 public:
  // Listens. Errors: those of listen_on().
  static Result<std::unique_ptr<StreamPublisher>> open(PublisherOptions options);
  StreamPublisher(const StreamPublisher&) = delete;
  StreamPublisher& operator=(const StreamPublisher&) = delete;
  ~StreamPublisher();

  uint16_t port() const noexcept { return port_of(listener_.get()); }
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
  void interrupt();
  void resume();
  PublisherCounts counts() const;

 private:
  using Links = std::vector<std::shared_ptr<SubscriberLink>>;

  explicit StreamPublisher(PublisherOptions options) : options_(std::move(options)) {}
  Outcome queue(const std::shared_ptr<const SharedMessage>& message, std::vector<Outage>* outages);
  template <class Ready>
  bool wait(const io::Deadline& deadline, const Ready& ready);
  uint32_t count(SubscriberLink::State state) const;
  uint32_t count_subscribers() const { return count(SubscriberLink::State::Subscribed); }
  void serve() noexcept;
  bool serve_once();  // false: it was stopped
  io::Deadline watch(const Links& links, std::vector<pollfd>* watched) const;
  void attend(SubscriberLink* link, bool has_input, std::vector<Error>* refusals);
  void accept_new(std::vector<Error>* refusals);
  std::string reason_to_refuse(const std::string& address) const;
  void refuse(SubscriberLink* link, const std::string& reason, std::vector<Error>* refusals);

  const PublisherOptions options_;
  Descriptor listener_;
  transport::WakeEvent wake_;
  mutable std::mutex mutex_;  // guards the rest
  std::condition_variable changed_;
  Links links_;
  std::vector<std::byte> greeting_;
  uint64_t refused_ = 0, missed_ = 0;
  bool interrupted_ = false, stopping_ = false;
  std::thread thread_;
};

}  // namespace weir::edge
