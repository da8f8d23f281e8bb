// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/queue/batch_queue.hpp"

#include <algorithm>

namespace weir::infer {

BatchQueue::StreamId BatchQueue::join(std::chrono::nanoseconds timeout) {
  streams_[++last_id_].timeout = timeout;
  return last_id_;
}

BatchJobs BatchQueue::clear(StreamId id) {
  BatchJobs out;
  const auto found = streams_.find(id);
  if (found == streams_.end()) return out;
  for (auto& waiting : found->second.frames) out.push_back(std::move(waiting.job));
  waiting_ -= found->second.frames.size();
  found->second.frames.clear();
  return out;
}

BatchJobs BatchQueue::leave(StreamId id) {
  auto out = clear(id);
  streams_.erase(id);
  return out;
}

std::unique_ptr<BatchJob> BatchQueue::take_oldest(StreamId id) {
  const auto found = streams_.find(id);
  if (found == streams_.end() || found->second.frames.empty()) return nullptr;
  auto oldest = std::move(found->second.frames.front().job);
  found->second.frames.pop_front();
  --waiting_;
  return oldest;
}

void BatchQueue::add(StreamId id, std::unique_ptr<BatchJob> job, Time now) {
  Stream& stream = streams_.at(id);
  // Prevents overflow for very long time-outs.
  const auto longest = Time::max() - now;
  const Time deadline = stream.timeout >= longest ? Time::max() : now + stream.timeout;
  stream.frames.push_back({arrivals_++, deadline, std::move(job)});
  stream.expected = true;
  ++waiting_;
}

void BatchQueue::pause(StreamId id) {
  if (const auto found = streams_.find(id); found != streams_.end()) found->second.expected = false;
}

void BatchQueue::pause_if_empty(StreamId id) {
  if (const auto found = streams_.find(id); found != streams_.end() && found->second.frames.empty())
    found->second.expected = false;
}

bool BatchQueue::every_share_is_there() const {
  size_t active = 0;
  for (const auto& [id, stream] : streams_)
    if (stream.expected || !stream.frames.empty()) ++active;
  const size_t share = std::max<size_t>(1, batch_size_ / std::max<size_t>(1, active));
  return std::all_of(streams_.begin(), streams_.end(), [share](const auto& entry) {
    return !entry.second.expected || entry.second.frames.size() >= share;
  });
}

bool BatchQueue::due(Time now) const {
  if (waiting_ == 0) return false;
  return waiting_ >= batch_size_ || *deadline() <= now || every_share_is_there();
}

std::optional<BatchQueue::Time> BatchQueue::deadline() const {
  std::optional<Time> out;
  for (const auto& [id, stream] : streams_)
    if (!stream.frames.empty())
      out = std::min(out.value_or(Time::max()), stream.frames.front().deadline);
  return out;
}

std::vector<BatchQueue::Taken> BatchQueue::take() {
  std::vector<Taken> out;
  out.reserve(std::min(batch_size_, waiting_));
  std::vector<std::pair<const StreamId, Stream>*> heads;
  while (out.size() < batch_size_ && waiting_ > 0) {
    heads.clear();
    for (auto& entry : streams_)
      if (!entry.second.frames.empty()) heads.push_back(&entry);
    std::sort(heads.begin(), heads.end(), [](const auto* a, const auto* b) {
      return a->second.frames.front().arrival < b->second.frames.front().arrival;
    });
    heads.resize(std::min(heads.size(), batch_size_ - out.size()));
    for (auto* head : heads) {
      out.push_back({head->first, std::move(head->second.frames.front().job)});
      head->second.frames.pop_front();
      --waiting_;
    }
  }
  for (auto& [id, stream] : streams_) {
    const bool gave =
        std::any_of(out.begin(), out.end(), [id = id](const Taken& t) { return t.stream == id; });
    if (!gave && stream.frames.empty()) stream.expected = false;
  }
  return out;
}

}  // namespace weir::infer
