// Flood: a peer that sends messages which are ignored, as fast as the socket takes them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include <atomic>
#include <cerrno>
#include <thread>

#include "becomes.hpp"
#include "core/wire/edge_capability.hpp"
#include "core/wire/wire_test_support.hpp"

namespace weir::edge::test {

// 400 times a HOST_INFO, which means nothing after the first.
inline wire::test::Bytes ignored_messages() {
  wire::test::Bytes out;
  const auto message =
      *wire::text_message(wire::HeaderForm::Bytes2088, wire::Command::HostInfo, 1, "localhost:9");
  for (int i = 0; i < 400; ++i) out.insert(out.end(), message.begin(), message.end());
  return out;
}

class Flood {
 public:
  // `socket` is borrowed and does not block.
  explicit Flood(int socket) : thread_([this, socket] { run(socket); }) {}
  Flood(const Flood&) = delete;
  Flood& operator=(const Flood&) = delete;
  ~Flood() {
    stop_ = true;
    thread_.join();
  }
  // More than any buffer of a socket holds has been sent, so the other end reads it.
  void wait_until_it_runs() const {
    EXPECT_TRUE(becomes_true([&] { return sent_ > uint64_t{16} << 20; }, "the flood"));
  }

 private:
  void run(int socket) {
    const auto bytes = ignored_messages();
    for (size_t at = 0; !stop_; at %= bytes.size()) {
      pollfd watched{socket, POLLOUT, 0};
      poll(&watched, 1, 100);
      const ssize_t sent =
          ::send(socket, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent < 0 && errno != EAGAIN) return;
      if (sent > 0) at += static_cast<size_t>(sent), sent_ += static_cast<uint64_t>(sent);
    }
  }

  std::atomic<bool> stop_{false};
  std::atomic<uint64_t> sent_{0};
  std::thread thread_;
};

}  // namespace weir::edge::test
