// Request: a frame that a query client sent, until its response has been sent.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/wire/edge_message_reader.hpp"
#include "transport/query_request.hpp"
#include "transport/wake_event.hpp"

namespace weir::edge {

// Counters of all requests of a server: received = answered + refused + expired + aborted + in
// progress.
struct RequestCounters {
  std::atomic<uint64_t> received{0};
  std::atomic<uint64_t> answered{0};
  std::atomic<uint64_t> refused{0};  // they do not match the caps
  std::atomic<uint64_t> expired{0};  // the client left before they were answered
  std::atomic<uint64_t> aborted{0};  // the pipeline dropped them
};

// The requests of one client that are in progress. Thread-safe.
struct ClientLoad {
  std::atomic<uint32_t> requests{0};
  std::atomic<uint64_t> bytes{0};
  std::atomic<bool> gone{false};  // the client has left
};

// Thread-safe, but memories() are one thread's. May outlive the server.
class Request : public QueryRequest {
 public:
  enum class Outcome { Answered, Refused };

  Request(int64_t client, std::vector<wire::ByteBlock> memories, std::string sequence,
          std::shared_ptr<ClientLoad> load, std::shared_ptr<RequestCounters> counters,
          std::shared_ptr<transport::WakeEvent> wake)
      : client_(client),
        memories_(std::move(memories)),
        sequence_(std::move(sequence)),
        load_(std::move(load)),
        counters_(std::move(counters)),
        wake_(std::move(wake)) {
    for (const auto& memory : memories_) bytes_ += memory.size;
    load_->requests += 1;
    load_->bytes += bytes_;
    counters_->received += 1;
  }
  // Counts as expired or aborted unless it has ended. Wakes the server if it waits for that.
  ~Request() override {
    if (!ended_) (load_->gone ? counters_->expired : counters_->aborted) += 1;
    load_->bytes -= bytes_;
    load_->requests -= 1;
    wake_->set_if_wanted();
  }

  int64_t client() const override { return client_; }
  bool end_if_expired() override { return load_->gone; }
  void entered(const char*) noexcept override {}
  void pushed() noexcept override {}
  std::vector<wire::ByteBlock>& memories() noexcept { return memories_; }
  // What a client of Weir numbers it with; "" from others.
  const std::string& sequence() const noexcept { return sequence_; }
  // The first call counts.
  void end(Outcome outcome) noexcept {
    if (ended_.exchange(true)) return;
    (outcome == Outcome::Answered ? counters_->answered : counters_->refused) += 1;
  }

 private:
  const int64_t client_;
  std::vector<wire::ByteBlock> memories_;
  const std::string sequence_;
  uint64_t bytes_ = 0;
  const std::shared_ptr<ClientLoad> load_;
  const std::shared_ptr<RequestCounters> counters_;
  const std::shared_ptr<transport::WakeEvent> wake_;
  std::atomic<bool> ended_{false};
};

}  // namespace weir::edge
