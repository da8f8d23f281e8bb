// ServerSet: the servers of one model. It chooses one for each request, tries again where that is
// safe, and counts how every request ended.
//
// A request goes to the server with the fewest requests in flight, among those whose circuit lets
// it through. A thread probes the servers whose circuit is open.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "net/client/circuit.hpp"
#include "net/client/clock_offset.hpp"
#include "net/client/latencies.hpp"
#include "net/client/link.hpp"

namespace weir::net {

struct RequestLimits {
  size_t in_flight = 4;  // requests that one server has at a time
  int attempts = 2;      // of one request, each on another server if there is one
  std::chrono::milliseconds timeout{10000}, probe{500};
};

// What the requests to one server came to. Attempts that have ended are counted by their outcome.
struct ServerStatistics {
  std::array<uint64_t, 4> ended{};  // by Outcome
  uint64_t bytes_sent = 0, bytes_received = 0;
  size_t in_flight = 0;
  Circuit::State circuit = Circuit::State::Closed;
  std::optional<Latencies::Duration> p50, p95, p99;  // of the last 256 responses
  // The server's clock, and the mean microseconds that a request waited and ran there, of responses
  // with times.
  std::optional<ClockOffset::Estimate> clock;
  std::optional<int64_t> queue_us, compute_us;
};

// How requests ended: sent = answered + late + refused + lost, once none is in progress.
struct RequestCounts {
  uint64_t sent = 0, attempts = 0;
  std::array<uint64_t, 4> ended{};  // by Outcome
  uint64_t of(Outcome outcome) const noexcept { return ended[static_cast<size_t>(outcome)]; }
};

// Thread-safe.
class ServerSet {
 public:
  using Clock = Link::Clock;
  struct Server {
    ServerAddress address;
    std::unique_ptr<Link> link;
  };
  // Whether the server can take requests: called for each probe of a server, on the probing thread.
  using Probe = std::function<bool(size_t server, Clock::time_point deadline)>;

  ServerSet(std::vector<Server> servers, const RequestLimits& limits, Probe probe);
  ~ServerSet();
  ServerSet(const ServerSet&) = delete;
  ServerSet& operator=(const ServerSet&) = delete;

  size_t size() const noexcept { return servers_.size(); }
  const ServerAddress& address(size_t server) const { return servers_[server].address; }
  Link& link(size_t server) const { return *servers_[server].link; }
  // Sends nothing to the server until a probe has found it ready.
  void open_circuit(size_t server);
  bool all_open() const;

  struct Ended {
    Outcome outcome = Outcome::Lost;
    Reply reply;
    size_t server = 0;   // of the last attempt
    bool tried = false;  // false: no server could be tried
  };
  // Makes the request for a server; an error ends it as refused.
  using MakeRequest = std::function<Result<Pieces>(size_t server)>;
  // `times` gets those of the response, if it has any.
  using Accept = std::function<Status(const Ended&, std::optional<ServerTimes>* times)>;
  // Sends a ModelInfer request. `expires`: when its response becomes useless. `accept` checks a
  // response, and stores it: an error makes the request a refused one. Never throws away an error:
  // it is in `reply.message`.
  Ended request(const MakeRequest& make, const std::shared_ptr<const void>& memory,
                Clock::time_point expires, const Accept& accept);
  RequestCounts counts() const;
  ServerStatistics statistics(size_t server) const;

 private:
  struct State {
    Circuit circuit;
    size_t in_flight = 0;
    Latencies latencies;
    ClockOffset clock;
    std::array<uint64_t, 4> ended{};  // attempts by Outcome
    uint64_t bytes_sent = 0, bytes_received = 0;
    uint64_t timed = 0, queue_us = 0, compute_us = 0;  // sums over responses with times
  };
  // What an attempt came to.
  struct Attempt {
    Outcome outcome = Outcome::Lost;
    uint64_t bytes_sent = 0, bytes_received = 0;
    int64_t sent_ns = 0;  // by the wall clock
    Clock::duration took{};
    std::optional<ServerTimes> times;
  };
  struct Taken {
    size_t server;
    bool trial;                  // of a half-open circuit
    Clock::time_point deadline;  // of the attempt
  };
  std::optional<Taken> take(const std::vector<bool>& tried, int attempts_left,
                            Clock::time_point deadline);
  std::optional<size_t> choose(const std::vector<bool>& tried, bool* full);
  Clock::time_point attempt_deadline(size_t server, const std::vector<bool>& tried,
                                     int attempts_left, Clock::time_point deadline) const;
  Attempt attempt(const Taken& taken, const MakeRequest& make,
                  const std::shared_ptr<const void>& memory, const Accept& accept, Ended* out);
  void give_back(const Taken& taken, const Attempt& ended);
  std::vector<size_t> open_circuits() const;  // mutex_ is held
  void probe_open_servers();

  const std::vector<Server> servers_;
  const RequestLimits limits_;
  const Probe probe_;
  mutable std::mutex mutex_;  // guards the rest
  std::condition_variable freed_, opened_;
  std::vector<State> states_;
  size_t next_ = 0;  // where the search begins, so that equal servers take turns
  RequestCounts counts_;
  bool ends_ = false;
  std::thread prober_;  // last member: it uses the others
};

}  // namespace weir::net
