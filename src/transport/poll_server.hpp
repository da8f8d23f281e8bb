// PollServer: one thread that accepts peers, polls their sockets and attends to each in turn.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "core/io/deadline.hpp"
#include "machine/descriptor.hpp"
#include "transport/accept_pause.hpp"
#include "transport/wake_event.hpp"
#include "weir/result.hpp"

namespace weir::transport {

// What a peer sends is read without the lock, and in bounded turns: a flood from one keeps neither
// the other peers waiting nor the threads that need the lock.
//
// `Peer` has kSockets, a type Input, `Input read(const pollfd* events)` for what has arrived,
// called by the server's thread without the lock, `is_gone()` and `set_gone()`.
template <class Peer>
class PollServer {
 public:
  PollServer(const PollServer&) = delete;
  PollServer& operator=(const PollServer&) = delete;

  // Ends waiting calls, and those that would wait until resume().
  void interrupt() {
    const std::lock_guard lock(mutex_);
    interrupted_ = true;
    changed_.notify_all();
  }
  void resume() {
    const std::lock_guard lock(mutex_);
    interrupted_ = false;
  }

 protected:
  using Client = std::shared_ptr<Peer>;
  using Clients = std::vector<Client>;
  using Lock = std::unique_lock<std::mutex>;

  // `refused` is called, without the lock, for each peer that is refused; it may be empty.
  explicit PollServer(std::function<void(const Error&)> refused) : refused_(std::move(refused)) {}
  virtual ~PollServer() = default;
  void start() {
    thread_ = std::thread([this] { serve(); });
  }
  // Ends the thread. The destructor of a derived class calls it.
  void join() {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    wake_->set();
    if (thread_.joinable()) thread_.join();
  }

  // Waits with the lock until `ready`; false after the deadline or an interruption.
  template <class Ready>
  bool wait(Lock* lock, const io::Deadline& deadline, const Ready& ready) {
    const auto ended = [&] { return interrupted_ || ready(); };
    if (!deadline)
      changed_.wait(*lock, ended);
    else
      changed_.wait_until(*lock, *deadline, ended);
    return !interrupted_ && ready();
  }
  void refuse(Peer* peer, Error error) {
    refusals_.push_back(std::move(error));
    ++refused_count_;
    if (peer) peer->set_gone();
  }

  // What the server's thread calls: with the lock, unless it says otherwise. The socket that
  // listens; -1: no peer is accepted now.
  virtual int listening() const = 0;
  // No descriptor if no peer waits, or for the reason in errno. Does not block.
  virtual io::Descriptor accept() = 0;
  virtual void add(io::Descriptor socket) = 0;
  // Adds kSockets of each client, and returns when one is to be attended to anyway.
  virtual io::Deadline watch(const Clients& clients, std::vector<pollfd>* watched) = 0;
  virtual void attend(const Client& client, const pollfd* events, typename Peer::Input input) = 0;
  // All have been attended to; those that are gone are still in clients_.
  virtual void end_turn() {}
  // The same, without the lock.
  virtual void release() {}

  const std::shared_ptr<WakeEvent> wake_ = std::make_shared<WakeEvent>();
  mutable std::mutex mutex_;  // guards the rest
  std::condition_variable changed_;
  Clients clients_;
  uint64_t refused_count_ = 0;
  bool interrupted_ = false;

 private:
  static constexpr int kMaxAccepted = 64;  // in one turn

  static Error out_of_resources(std::string what, std::string reason) {
    return Error{.code = Code::OUT_OF_MEMORY,
                 .what = std::move(what),
                 .offered = std::move(reason),
                 .needed = "free memory and file descriptors",
                 .fix = kOutOfResourcesFix};
  }
  void accept_peers() {
    for (int i = 0; listening() >= 0 && i < kMaxAccepted; ++i) {
      errno = 0;
      io::Descriptor socket = accept();
      const int reason = errno;
      if (socket) {
        accepts_at_ = std::nullopt;
        add(std::move(socket));
        continue;
      }
      if (!is_out_of_resources(reason)) {
        accepts_at_ = std::nullopt;
        return;
      }
      if (!accepts_at_)
        refusals_.push_back(out_of_resources("no peer can be accepted", std::strerror(reason)));
      accepts_at_ = io::deadline_in(kAcceptPause);
      return;
    }
  }

  bool serve_once() {  // false: it was stopped
    Clients clients;
    std::vector<pollfd> watched{{wake_->descriptor(), POLLIN, 0}};
    io::Deadline next;
    {
      const std::lock_guard lock(mutex_);
      if (stopping_) return false;
      clients = clients_;
      const bool waits = accepts_at_ && !io::is_over(accepts_at_);
      watched.push_back({waits ? -1 : listening(), POLLIN, 0});
      next = watch(clients, &watched);
      if (waits) next = io::earlier(next, accepts_at_);
    }
    poll(watched.data(), watched.size(), io::poll_timeout(next));
    if (watched[0].revents) wake_->clear();
    std::vector<typename Peer::Input> inputs;
    const auto events = [&](size_t i) { return &watched[2 + i * Peer::kSockets]; };
    for (size_t i = 0; i < clients.size(); ++i) inputs.push_back(clients[i]->read(events(i)));
    std::vector<Error> refusals;
    {
      const std::lock_guard lock(mutex_);
      for (size_t i = 0; i < clients.size(); ++i)
        if (!clients[i]->is_gone()) attend(clients[i], events(i), std::move(inputs[i]));
      if (watched[1].revents) accept_peers();
      end_turn();
      std::erase_if(clients_, [](const auto& client) { return client->is_gone(); });
      refusals.swap(refusals_);
      changed_.notify_all();
    }
    clients.clear();  // closes the sockets of those that are gone
    release();
    if (refused_)
      for (const Error& error : refusals) refused_(error);
    return true;
  }
  // Returns true when it was stopped; false when memory ran out, and then all peers are gone.
  bool serve_many() noexcept {
    try {
      while (serve_once()) {
      }
      return true;
    } catch (const std::exception& e) {
      end_all();
      report_end_of_all(e.what());
      return false;
    }
  }
  void end_all() noexcept {
    Clients clients;
    {
      const std::lock_guard lock(mutex_);
      for (const auto& client : clients_) client->set_gone();
      try {
        end_turn();
      } catch (const std::exception&) {  // what it would take is released with the clients
      }
      clients.swap(clients_);
    }
    clients.clear();
    release();
    const std::lock_guard lock(mutex_);
    changed_.notify_all();
  }
  void report_end_of_all(const char* reason) noexcept {
    try {
      if (refused_) refused_(out_of_resources("all connections of a server were closed", reason));
    } catch (const std::exception&) {  // there is no memory for the report either
    }
  }
  bool is_stopping() const {
    const std::lock_guard lock(mutex_);
    return stopping_;
  }
  // The thread entry. Peers that come later are served again.
  void serve() noexcept {
    while (!is_stopping() && !serve_many()) {
      pollfd stopped{wake_->descriptor(), POLLIN, 0};
      poll(&stopped, 1, io::poll_timeout(io::deadline_in(kAcceptPause)));
      wake_->clear();
    }
  }

  const std::function<void(const Error&)> refused_;
  std::vector<Error> refusals_;  // to be reported
  io::Deadline accepts_at_;      // after accept() failed
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace weir::transport
