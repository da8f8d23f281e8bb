// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/supervisor.hpp"

#include <poll.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <cerrno>
#include <iterator>

namespace weir::isolate {

Supervisor::Supervisor(WorkerSettings settings, OnCrash on_crash, std::shared_ptr<Monitor> monitor,
                       io::Descriptor cancel)
    : settings_(std::move(settings)),
      on_crash_(on_crash),
      monitor_(std::move(monitor)),
      cancel_(std::move(cancel)) {}

Result<std::unique_ptr<Supervisor>> Supervisor::start(WorkerSettings settings, OnCrash on_crash,
                                                      std::shared_ptr<Monitor> monitor) {
  io::Descriptor cancel(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!cancel) return not_started("eventfd", errno);
  // Nothing could end a wait for this worker.
  if (monitor->stop_descriptor() < 0) return not_started("eventfd", monitor->stop_error());
  std::unique_ptr<Supervisor> made(
      new Supervisor(std::move(settings), on_crash, std::move(monitor), std::move(cancel)));
  made->thread_ = std::thread([self = made.get()] { self->run(); });
  std::unique_lock lock(made->mutex_);
  made->changed_.wait(lock, [&] { return made->state_ != State::Starting; });
  if (made->state_ == State::Ready) return made;
  return made->first_error_;
}

Supervisor::~Supervisor() {
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  eventfd_write(cancel_.get(), 1);
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

Worker* Supervisor::ready() {
  std::lock_guard lock(mutex_);
  return state_ == State::Ready ? worker_.get() : nullptr;
}

Worker* Supervisor::wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return state_ != State::Starting; });
  return state_ == State::Ready ? worker_.get() : nullptr;
}

void Supervisor::ended() {
  {
    std::lock_guard lock(mutex_);
    leave(std::move(worker_));
  }
  changed_.notify_all();
}

void Supervisor::remember(int op, const weir_option& option) {
  if (op != WEIR_SET_OPTION || !option.key) return;
  std::lock_guard lock(mutex_);
  std::erase_if(orders_, [&](const auto& order) { return order.first == option.key; });
  orders_.emplace_back(option.key, option.value ? option.value : "");
}

// Handles the end of a worker. Call it with the mutex held.
void Supervisor::leave(std::unique_ptr<Worker> worker) {
  ended_ = std::move(worker);
  state_ = restarts(on_crash_) ? State::Starting : State::Gone;
  const auto now = RestartBackoff::Clock::now();
  start_at_ = now + backoff_.ended(now);
}

void Supervisor::run() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    if (ended_) {
      auto buried = std::move(ended_);
      lock.unlock();
      buried.reset();
      lock.lock();
    } else if (state_ != State::Starting) {
      changed_.wait(lock);
    } else if (RestartBackoff::Clock::now() < start_at_) {
      wait_for_start(&lock);
    } else {
      lock.unlock();
      start_one();
      lock.lock();
    }
  }
  // On this thread, since workers end with the thread that started them.
  auto last = std::move(worker_);
  auto buried = std::move(ended_);
  lock.unlock();
}

// Ends on a stop or when the time is over. ended() and remember() do not change the time meanwhile.
void Supervisor::wait_for_start(std::unique_lock<std::mutex>* lock) {
  const io::Deadline until = start_at_;
  lock->unlock();
  pollfd watched[] = {{cancel_.get(), POLLIN, 0}, {settings_.stop, POLLIN, 0}};
  poll(watched, std::size(watched), io::poll_timeout(until));  // run() checks the time again
  lock->lock();
  if (!watched[1].revents) return;
  state_ = State::Gone;
  changed_.notify_all();
}

void Supervisor::start_one() {
  auto worker = Worker::start(settings_, cancel_.get());
  Status status = worker ? take_over(worker->get()) : Status(worker.error());
  if (!status) return fail(status.error());
  monitor_->set_confinement((*worker)->confinement());
  {
    std::lock_guard lock(mutex_);
    if (!first_) monitor_->add(&MonitorCounts::restarted);
    first_ = false;
    backoff_.started(RestartBackoff::Clock::now());
    worker_ = *std::move(worker);
    state_ = State::Ready;
  }
  changed_.notify_all();
}

// A replacement must have the same model and gets the stored orders.
Status Supervisor::take_over(Worker* worker) {
  std::vector<std::pair<std::string, std::string>> orders;
  {
    std::lock_guard lock(mutex_);
    if (first_) {
      facts_ = worker->facts();
      return ok();
    }
    orders = orders_;
  }
  if (!same_tensors(*facts_, *worker->facts()))
    return Error{.code = Code::MODEL_DIFFERS,
                 .what = "the model's tensors have changed since it was opened",
                 .offered = "a worker process that was started again",
                 .needed = "unchanged model files"};
  for (const auto& [key, value] : orders) {
    const weir_option option{key.c_str(), value.c_str()};
    if (auto status = worker->control(WEIR_SET_OPTION, &option); !status) return status;
  }
  return ok();
}

void Supervisor::fail(const Error& error) {
  bool first = false;
  {
    std::lock_guard lock(mutex_);
    first = first_;
    if (first) {
      first_error_ = error;
      state_ = State::Gone;
    } else if (error.code == Code::CANCELLED) {
      state_ = State::Gone;
    } else {
      leave(nullptr);
    }
  }
  changed_.notify_all();
  if (first || error.code == Code::CANCELLED) return;
  monitor_->add(&MonitorCounts::not_started);
  monitor_->report(error);
}

}  // namespace weir::isolate
