// Servers without resources: they report it, and serve again when there are some.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/poll_server.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <new>
#include <string>
#include <vector>

#include "becomes.hpp"

namespace weir::transport {
namespace poll_server_test {

using Clock = std::chrono::steady_clock;

struct SilentPeer {
  static constexpr size_t kSockets = 1;
  struct Input {};
  Input read(const pollfd*) { return {}; }
  bool is_gone() const { return gone; }
  void set_gone() { gone = true; }
  bool gone = false;
};

// A server with a peer that always waits.
class TestServer : public PollServer<SilentPeer> {
 public:
  TestServer() : PollServer([this](const Error& error) { report(error); }) {}
  ~TestServer() override { join(); }
  using PollServer::start;

  // What accept() does: the reason why it fails, 0 = it does not, once.
  void set_accept_error(int error) {
    accept_error_ = error;
    readable_.set();
  }
  // Memory runs out in each of the next turns.
  void set_failing_turns(int turns) {
    failing_turns_ = turns;
    wake_->set();
  }
  size_t clients() const {
    const std::lock_guard lock(mutex_);
    return clients_.size();
  }
  std::vector<Clock::time_point> attempts() const {
    const std::lock_guard lock(mutex_);
    return attempts_;
  }
  // Peers that have been removed.
  size_t released() const {
    const std::lock_guard lock(mutex_);
    return released_;
  }
  std::string reports() const {
    const std::lock_guard lock(reports_mutex_);
    return reports_;
  }

 private:
  int listening() const override { return readable_.descriptor(); }
  io::Descriptor accept() override {
    attempts_.push_back(Clock::now());
    errno = accept_error_;
    return errno ? io::Descriptor() : io::Descriptor(dup(wake_->descriptor()));
  }
  void add(io::Descriptor) override {
    clients_.push_back(std::make_shared<SilentPeer>());
    readable_.clear();
    accept_error_ = EAGAIN;
  }
  io::Deadline watch(const Clients& clients, std::vector<pollfd>* watched) override {
    if (failing_turns_ > 0 && failing_turns_-- > 0) throw std::bad_alloc();
    for (size_t i = 0; i < clients.size(); ++i) watched->push_back({-1, 0, 0});
    return std::nullopt;
  }
  void attend(const Client&, const pollfd*, SilentPeer::Input) override {}
  void end_turn() override {
    for (const auto& client : clients_)
      if (client->is_gone()) ++gone_;
  }
  void release() override {
    const std::lock_guard lock(mutex_);
    released_ += std::exchange(gone_, 0);
  }
  void report(const Error& error) {
    const std::lock_guard lock(reports_mutex_);
    reports_ += error.message() + "\n";
  }

  WakeEvent readable_;
  std::atomic<int> accept_error_{0}, failing_turns_{0};
  size_t gone_ = 0, released_ = 0;           // guarded by the server's mutex
  std::vector<Clock::time_point> attempts_;  // the same
  mutable std::mutex reports_mutex_;         // guards the rest
  std::string reports_;
};

size_t count(const std::string& text, const std::string& words) {
  size_t out = 0;
  for (size_t at = text.find(words); at != text.npos; at = text.find(words, at + 1)) ++out;
  return out;
}

TEST(PollServer, PausesWhileNoDescriptorIsFreeAndAcceptsLater) {
  for (const int error : {EMFILE, ENFILE, ENOBUFS, ENOMEM}) {
    TestServer server;
    server.set_accept_error(error);
    server.start();
    ASSERT_TRUE(becomes_true([&] { return server.attempts().size() >= 4; }, "four attempts"));
    const auto attempts = server.attempts();
    EXPECT_GE(attempts[3] - attempts[0], std::chrono::milliseconds(300)) << error;
    EXPECT_EQ(count(server.reports(), "no peer can be accepted"), 1u) << server.reports();
    EXPECT_EQ(count(server.reports(), std::strerror(error)), 1u) << server.reports();
    server.set_accept_error(0);
    EXPECT_TRUE(becomes_true([&] { return server.clients() == 1; }, "the client"));
  }
}

TEST(PollServer, ReportsTheNextTimeThatNoDescriptorIsFree) {
  TestServer server;
  const auto reports = [&](size_t number) {
    return becomes_true(
        [&] { return count(server.reports(), "no peer can be accepted") == number; },
        [&] { return std::to_string(number) + " reports"; });
  };
  server.set_accept_error(EMFILE);
  server.start();
  ASSERT_TRUE(reports(1));
  server.set_accept_error(EAGAIN);  // the peer has left
  const size_t before = server.attempts().size();
  ASSERT_TRUE(becomes_true([&] { return server.attempts().size() > before + 1; }, "attempts"));
  server.set_accept_error(EMFILE);
  EXPECT_TRUE(reports(2));
}

TEST(PollServer, ReportsThatMemoryRanOutAndServesAgain) {
  TestServer server;
  server.set_accept_error(0);
  server.start();
  ASSERT_TRUE(becomes_true([&] { return server.clients() == 1; }, "a client"));
  server.set_failing_turns(2);
  ASSERT_TRUE(becomes_true([&] { return count(server.reports(), "connections") == 2; },
                           [&] { return "two reports in " + server.reports(); }));
  EXPECT_EQ(count(server.reports(), "all connections of a server were closed"), 2u);
  EXPECT_EQ(server.clients(), 0u);
  EXPECT_EQ(server.released(), 1u) << "as at the end of other turns";
  server.set_accept_error(0);
  EXPECT_TRUE(becomes_true([&] { return server.clients() == 1; }, "another client"));
}

TEST(WakeEvent, FailsWithoutADescriptor) {
  rlimit before{};
  getrlimit(RLIMIT_NOFILE, &before);
  const rlimit none{0, before.rlim_max};
  setrlimit(RLIMIT_NOFILE, &none);
  std::string reason;
  try {
    WakeEvent();
  } catch (const std::exception& error) {
    reason = error.what();
  }
  setrlimit(RLIMIT_NOFILE, &before);
  EXPECT_EQ(reason, "no file descriptor to wake a thread with (ulimit -n): Too many open files");
}

}  // namespace poll_server_test
}  // namespace weir::transport
