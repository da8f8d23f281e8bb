// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/client/server_set.hpp"

#include <algorithm>

namespace weir::net {
namespace {

constexpr int kResourceExhausted = 8;
// An attempt gets three times the usual time, at least this: shorter ones end by chance.
constexpr std::chrono::milliseconds kMinAttempt{50};
constexpr int kUsualTimes = 3;
constexpr std::chrono::milliseconds kMinProbe{200};

// Whether another server may do what this one did not.
bool may_retry(Outcome outcome, const Reply& reply) {
  return outcome == Outcome::Lost || outcome == Outcome::Late || reply.status == kResourceExhausted;
}

}  // namespace

ServerSet::ServerSet(std::vector<Server> servers, const RequestLimits& limits, Probe probe)
    : servers_(std::move(servers)),
      limits_(limits),
      probe_(std::move(probe)),
      states_(servers_.size()),
      prober_([this] { probe_open_servers(); }) {}

ServerSet::~ServerSet() {
  {
    std::lock_guard lock(mutex_);
    ends_ = true;
  }
  opened_.notify_all();
  prober_.join();
}

void ServerSet::open_circuit(size_t server) {
  std::lock_guard lock(mutex_);
  states_[server].circuit.open();
  opened_.notify_all();
}

bool ServerSet::all_open() const {
  std::lock_guard lock(mutex_);
  return std::none_of(states_.begin(), states_.end(),
                      [](const State& state) { return state.circuit.admits(); });
}

RequestCounts ServerSet::counts() const {
  std::lock_guard lock(mutex_);
  return counts_;
}

ServerStatistics ServerSet::statistics(size_t server) const {
  std::lock_guard lock(mutex_);
  const State& state = states_[server];
  ServerStatistics out{.ended = state.ended,
                       .bytes_sent = state.bytes_sent,
                       .bytes_received = state.bytes_received,
                       .in_flight = state.in_flight,
                       .circuit = state.circuit.state(),
                       .p50 = state.latencies.percentile(50),
                       .p95 = state.latencies.percentile(95),
                       .p99 = state.latencies.percentile(99),
                       .clock = state.clock.estimate(),
                       .queue_us = {},
                       .compute_us = {}};
  if (state.timed > 0) {
    out.queue_us = static_cast<int64_t>(state.queue_us / state.timed);
    out.compute_us = static_cast<int64_t>(state.compute_us / state.timed);
  }
  return out;
}

// Prefers a half-open server, whose trial decides whether it comes back, to the least loaded one.
// `full`: a server would be chosen if it had fewer requests.
std::optional<size_t> ServerSet::choose(const std::vector<bool>& tried, bool* full) {
  std::optional<size_t> best;
  *full = false;
  for (size_t i = 0; i < states_.size(); ++i) {
    const size_t at = (next_ + i) % states_.size();
    const State& state = states_[at];
    if (tried[at] || !state.circuit.admits()) continue;
    if (state.circuit.state() == Circuit::State::HalfOpen) return at;
    if (state.in_flight >= limits_.in_flight)
      *full = true;
    else if (!best || state.in_flight < states_[*best].in_flight)
      best = at;
  }
  return best;
}

std::optional<ServerSet::Taken> ServerSet::take(const std::vector<bool>& tried, int attempts_left,
                                                Clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  for (;;) {
    bool full = false, again_full = false;
    auto server = choose(tried, &full);
    if (!server && !full) server = choose(std::vector<bool>(tried.size()), &again_full);
    if (server) {
      State& state = states_[*server];
      const bool trial = state.circuit.state() == Circuit::State::HalfOpen;
      state.circuit.begin();
      ++state.in_flight;
      ++counts_.attempts;
      next_ = (*server + 1) % states_.size();
      return Taken{*server, trial, attempt_deadline(*server, tried, attempts_left, deadline)};
    }
    if (!full && !again_full) return std::nullopt;
    if (freed_.wait_until(lock, deadline) == std::cv_status::timeout) return std::nullopt;
  }
}

// Leaves time for another server, if one could take over. mutex_ is held.
ServerSet::Clock::time_point ServerSet::attempt_deadline(size_t server,
                                                         const std::vector<bool>& tried,
                                                         int attempts_left,
                                                         Clock::time_point deadline) const {
  if (attempts_left <= 1) return deadline;
  bool another = false;
  for (size_t i = 0; i < states_.size(); ++i)
    another = another || (i != server && !tried[i] && states_[i].circuit.admits());
  if (!another) return deadline;
  const auto now = Clock::now();
  const auto usual = states_[server].latencies.percentile(95);
  const auto half = (deadline - now) / 2;
  const auto limit = usual ? std::max<Clock::duration>(kUsualTimes * *usual, kMinAttempt) : half;
  return now + std::min(limit, half);
}

void ServerSet::give_back(const Taken& taken, const Attempt& ended) {
  std::lock_guard lock(mutex_);
  State& state = states_[taken.server];
  --state.in_flight;
  ++state.ended[static_cast<size_t>(ended.outcome)];
  state.bytes_sent += ended.bytes_sent;
  state.bytes_received += ended.bytes_received;
  if (ended.outcome == Outcome::Answered) state.latencies.add(ended.took);
  if (ended.times) {
    ++state.timed;
    state.queue_us += static_cast<uint64_t>(ended.times->queue_us);
    state.compute_us += static_cast<uint64_t>(ended.times->compute_us);
    state.clock.add(ended.sent_ns, ended.times->received_ns, ended.times->answered_ns,
                    ended.sent_ns + std::chrono::nanoseconds(ended.took).count());
  }
  state.circuit.end(ended.outcome, taken.trial);
  if (state.circuit.state() == Circuit::State::Open) opened_.notify_all();
  freed_.notify_all();
}

ServerSet::Attempt ServerSet::attempt(const Taken& taken, const MakeRequest& make,
                                      const std::shared_ptr<const void>& memory,
                                      const Accept& accept, Ended* out) {
  Attempt ended;
  const auto refuse = [out, &ended](const Error& error) {
    ended.outcome = out->outcome = Outcome::Refused;
    out->reply.message = error.message();
    return ended;
  };
  const auto pieces = make(taken.server);
  if (!pieces) return refuse(pieces.error());
  for (const auto& piece : *pieces)
    ended.bytes_sent += piece.own.empty() ? piece.borrowed.size() : piece.own.size();
  ended.sent_ns =
      std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count();
  const auto begin = Clock::now();
  out->reply = link(taken.server).call("ModelInfer", *pieces, memory, taken.deadline);
  ended.took = Clock::now() - begin;
  ended.bytes_received = out->reply.chunks.size();
  ended.outcome = out->outcome = to_outcome(out->reply.status);
  if (out->outcome != Outcome::Answered) return ended;
  if (const auto status = accept(*out, &ended.times); !status) return refuse(status.error());
  return ended;
}

ServerSet::Ended ServerSet::request(const MakeRequest& make,
                                    const std::shared_ptr<const void>& memory,
                                    Clock::time_point expires, const Accept& accept) {
  const auto deadline = std::min(expires, Clock::now() + limits_.timeout);
  {
    std::lock_guard lock(mutex_);
    ++counts_.sent;
  }
  Ended out;
  std::vector<bool> tried(servers_.size());
  for (int left = limits_.attempts; left > 0 && Clock::now() < deadline; --left) {
    const auto taken = take(tried, left, deadline);
    if (!taken) break;
    out.tried = tried[taken->server] = true;
    out.server = taken->server;
    give_back(*taken, attempt(*taken, make, memory, accept, &out));
    if (!may_retry(out.outcome, out.reply)) break;
  }
  const bool answered = out.outcome == Outcome::Answered || out.outcome == Outcome::Refused;
  if (!answered && Clock::now() >= deadline) out.outcome = Outcome::Late;
  std::lock_guard lock(mutex_);
  ++counts_.ended[static_cast<size_t>(out.outcome)];
  return out;
}

std::vector<size_t> ServerSet::open_circuits() const {
  std::vector<size_t> open;
  for (size_t i = 0; i < states_.size(); ++i)
    if (states_[i].circuit.state() == Circuit::State::Open) open.push_back(i);
  return open;
}

void ServerSet::probe_open_servers() {
  std::unique_lock lock(mutex_);
  while (!ends_) {
    const auto open = open_circuits();
    if (open.empty()) {
      opened_.wait(lock);
      continue;
    }
    // Not until the pause is over, whatever wakes the thread in between.
    if (opened_.wait_for(lock, limits_.probe, [this] { return ends_; })) return;
    for (const size_t server : open) {
      lock.unlock();
      const bool ready = probe_(server, Clock::now() + std::max(limits_.probe, kMinProbe));
      lock.lock();
      if (ends_) return;
      if (ready) states_[server].circuit.probe_answered();
    }
  }
}

}  // namespace weir::net
