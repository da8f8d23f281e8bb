// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/batch/batch_collector.hpp"

#include <algorithm>

namespace weir::infer {
namespace {

class MachineClock final : public BatchClock {
 public:
  Time now() override { return std::chrono::steady_clock::now(); }
  void wait_until(std::condition_variable& changed, std::unique_lock<std::mutex>& lock,
                  Time until) override {
    if (until == Time::max())
      changed.wait(lock);
    else
      changed.wait_until(lock, until);
  }
};

}  // namespace

BatchClock& BatchClock::machine() {
  static MachineClock clock;
  return clock;
}

BatchCollector::BatchCollector(size_t batch_size, Run run, BatchClock& clock)
    : run_(std::move(run)),
      clock_(clock),
      queue_(std::max<size_t>(1, batch_size)),
      thread_([this] { gather(); }) {}

BatchCollector::~BatchCollector() {
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
    changed_.notify_all();
  }
  thread_.join();
}

std::unique_ptr<BatchCollector::Stream> BatchCollector::join(
    std::shared_ptr<BatchCollector> collector, std::chrono::nanoseconds timeout) {
  std::unique_lock lock(collector->mutex_);
  const auto id = collector->queue_.join(timeout);
  lock.unlock();
  return std::unique_ptr<Stream>(new Stream(std::move(collector), id));
}

void BatchCollector::between_batches(const std::function<void()>& change) {
  {
    std::unique_lock lock(mutex_);
    ++held_;
    ended_.wait(lock, [this] { return !busy_; });
  }
  struct Release {
    BatchCollector* self;
    ~Release() {
      std::lock_guard lock(self->mutex_);
      --self->held_;
      self->changed_.notify_all();
    }
  } const release{this};
  change();
}

size_t BatchCollector::streams() const {
  std::lock_guard lock(mutex_);
  return queue_.streams();
}

bool BatchCollector::runs(BatchQueue::StreamId stream) const {
  return std::find(running_.begin(), running_.end(), stream) != running_.end();
}

void BatchCollector::gather() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    if (held_ > 0 || queue_.empty()) {
      changed_.wait(lock);
      continue;
    }
    if (!queue_.due(clock_.now())) {
      clock_.wait_until(changed_, lock, *queue_.deadline());
      continue;
    }
    BatchJobs jobs;
    for (auto& taken : queue_.take()) {
      running_.push_back(taken.stream);
      jobs.push_back(std::move(taken.job));
    }
    busy_ = true;
    lock.unlock();
    run_(jobs);
    jobs.clear();
    lock.lock();
    running_.clear();
    busy_ = false;
    ended_.notify_all();
  }
}

BatchCollector::Stream::~Stream() {
  BatchJobs left;  // freed after the lock
  {
    std::unique_lock lock(collector_->mutex_);
    left = collector_->queue_.leave(id_);
    collector_->changed_.notify_all();  // the others no longer wait for this stream
    collector_->ended_.wait(lock, [this] { return !collector_->runs(id_); });
  }
}

void BatchCollector::Stream::add(std::unique_ptr<BatchJob> job) {
  auto& g = *collector_;
  std::lock_guard lock(g.mutex_);
  const auto before = g.queue_.deadline();
  const auto now = g.clock_.now();
  g.queue_.add(id_, std::move(job), now);
  // Wakes the thread only if its next deadline changes.
  if (g.queue_.deadline() != before || g.queue_.due(now)) g.changed_.notify_all();
}

BatchJobs BatchCollector::Stream::flush() {
  std::lock_guard lock(collector_->mutex_);
  return collector_->queue_.clear(id_);
}

std::unique_ptr<BatchJob> BatchCollector::Stream::take_oldest() {
  std::lock_guard lock(collector_->mutex_);
  return collector_->queue_.take_oldest(id_);
}

void BatchCollector::Stream::pause_if_empty() {
  std::lock_guard lock(collector_->mutex_);
  collector_->queue_.pause_if_empty(id_);
  collector_->changed_.notify_all();
}

void BatchCollector::Stream::pause() {
  std::lock_guard lock(collector_->mutex_);
  collector_->queue_.pause(id_);
  collector_->changed_.notify_all();
}

}  // namespace weir::infer
