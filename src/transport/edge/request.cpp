// Counts what becomes of a request.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/edge/request.hpp"

#include <utility>

namespace weir::edge {

Request::Request(int64_t client, std::vector<wire::ByteBlock> memories, std::string sequence,
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

Request::~Request() {
  if (!ended_) (load_->gone ? counters_->expired : counters_->aborted) += 1;
  load_->bytes -= bytes_;
  load_->requests -= 1;
  wake_->set_if_wanted();
}

void Request::end(Outcome outcome) noexcept {
  if (ended_.exchange(true)) return;
  (outcome == Outcome::Answered ? counters_->answered : counters_->refused) += 1;
}

}  // namespace weir::edge
