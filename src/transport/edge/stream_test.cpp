// Streams in NNStreamer's protocol over TCP on this machine, and peers that break its rules.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <thread>

#include "becomes.hpp"
#include "core/wire/edge_capability.hpp"
#include "core/wire/wire_test_support.hpp"
#include "says.hpp"
#include "transport/edge/flood_test_support.hpp"
#include "transport/edge/stream_publisher.hpp"
#include "transport/edge/stream_subscriber.hpp"
#include "transport/wake_event.hpp"

namespace weir::edge {
namespace stream_test {

using wire::HeaderForm;
using wire::test::Bytes;
using wire::test::from_text;
using Outcome = StreamPublisher::Outcome;

class EdgeStream : public ::testing::Test {
 protected:
  void open(HeaderForm form = HeaderForm::Bytes2088, QueueLimits queue = {},
            uint32_t max_per_address = 32) {
    auto made = StreamPublisher::open({.host = "localhost",
                                       .port = 0,
                                       .form = form,
                                       .queue = queue,
                                       .max_subscribers = 32,
                                       .max_per_address = max_per_address,
                                       .allowed = {},
                                       .refused = [this](const Error& error) {
                                         const std::lock_guard lock(mutex_);
                                         reason_ = error.message();
                                       }});
    ASSERT_TRUE(made) << made.error().message();
    publisher_ = *std::move(made);
    ASSERT_TRUE(publisher_->set_caps(""));
  }
  StreamSubscriber subscriber() {
    auto made = StreamSubscriber::connect("localhost", publisher_->port(), {});
    EXPECT_TRUE(made) << (made ? "" : made.error().message());
    if (!made) std::abort();
    return *std::move(made);
  }
  bool subscribers_become(uint32_t count) {
    return becomes_true([&] { return publisher_->counts().subscribers == count; },
                        std::to_string(count) + " subscribers");
  }
  Outcome publish(const std::vector<Bytes>& memories) {
    const auto owner = std::make_shared<std::vector<Bytes>>(memories);
    std::vector<std::span<const std::byte>> parts(owner->begin(), owner->end());
    auto outcome = publisher_->publish(std::move(parts), owner);
    EXPECT_TRUE(outcome);
    return outcome ? *outcome : Outcome::Missed;
  }
  static std::vector<Bytes> next(StreamSubscriber* subscriber) {
    auto received = subscriber->receive();
    EXPECT_TRUE(received) << (received ? "" : received.error().message());
    std::vector<Bytes> out;
    if (received)
      for (const auto& memory : received->memories)
        out.push_back(wire::test::copy_of(memory.bytes()));
    return out;
  }
  Descriptor raw() {
    auto made = connect_to("localhost", publisher_->port(), std::nullopt, -1);
    EXPECT_TRUE(made);
    return *std::move(made);
  }
  static void send_raw(const Descriptor& socket, const Bytes& bytes) {
    EXPECT_EQ(send(socket.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }
  // The publisher closes the connection, gives the reason, and serves others.
  void expect_refused(const Descriptor& socket, const char* words) {
    ASSERT_TRUE(becomes_true([&] { return publisher_->counts().refused == 1; }, "the refusal"));
    std::byte buffer[4096];
    EXPECT_TRUE(becomes_true(
        [&] { return recv(socket.get(), buffer, sizeof buffer, MSG_DONTWAIT) == 0; }, "the end"));
    ASSERT_TRUE(becomes_true(
        [&] {
          const std::lock_guard lock(mutex_);
          return !reason_.empty();
        },
        "the reason"));
    EXPECT_SAYS(reason_, words);
    auto good = subscriber();
    ASSERT_TRUE(subscribers_become(1));
    EXPECT_EQ(publish({from_text("ok")}), Outcome::Sent);
    EXPECT_EQ(next(&good), (std::vector<Bytes>{from_text("ok")}));
  }

  std::mutex mutex_;
  std::string reason_;
  std::unique_ptr<StreamPublisher> publisher_;
};

// Ends of the connections with `port` that the kernel probes while they are silent.
int probed_ends(uint16_t port) {
  std::ifstream connections("/proc/self/net/tcp");
  int out = 0;
  for (std::string line; std::getline(connections, line);) {
    unsigned local = 0, remote = 0, state = 0, timer = 0;
    // slot: address:port address:port state tx:rx timer:...
    if (std::sscanf(line.c_str(), " %*d: %*x:%x %*x:%x %x %*x:%*x %x:", &local, &remote, &state,
                    &timer) != 4)
      continue;
    const bool is_established = state == 1, is_probed = timer == 2;
    if ((local == port || remote == port) && is_established && is_probed) ++out;
  }
  return out;
}

// A machine that loses its power sends nothing that ends the connection.
TEST_F(EdgeStream, BothEndsFindOutThatTheOtherMachineHasGone) {
  open();
  const auto one = subscriber();
  EXPECT_TRUE(becomes_true([&] { return probed_ends(publisher_->port()) == 2; }, "the timers"));
}

TEST_F(EdgeStream, FramesAndCapsArriveInEachForm) {
  for (const auto form : {HeaderForm::Bytes2088, HeaderForm::Bytes168, HeaderForm::Bytes160}) {
    open(form);
    ASSERT_TRUE(publisher_->set_caps("other/tensors,format=flexible"));
    auto one = subscriber(), two = subscriber();
    EXPECT_EQ(one.caps(), "other/tensors,format=flexible");
    ASSERT_TRUE(subscribers_become(2));
    const std::vector<Bytes> frame{from_text("abcd"), from_text("xyz"), Bytes(300000)};
    EXPECT_EQ(publish(frame), Outcome::Sent);
    EXPECT_EQ(next(&one), frame);
    EXPECT_EQ(next(&two), frame);
  }
}

TEST_F(EdgeStream, CapsMayBeUnknown) {
  open();
  EXPECT_EQ(subscriber().caps(), "");
}

TEST_F(EdgeStream, AsManyMemoriesAsTheFormHas) {
  for (const auto& [form, max] :
       {std::pair(HeaderForm::Bytes2088, 255), std::pair(HeaderForm::Bytes168, 15)}) {
    open(form);
    auto one = subscriber();
    ASSERT_TRUE(subscribers_become(1));
    const std::vector<Bytes> frame(max, from_text("m"));
    EXPECT_EQ(publish(frame), Outcome::Sent);
    EXPECT_EQ(next(&one), frame);
    const Bytes byte(1);
    EXPECT_REFUSED(publisher_->publish(std::vector<std::span<const std::byte>>(max + 1, byte), {}),
                   LIMIT_EXCEEDED, std::to_string(max + 1));
  }
}

TEST_F(EdgeStream, AMemoryOfNoBytesIsNotSent) {
  open();
  EXPECT_REFUSED(publisher_->publish({std::span<const std::byte>()}, {}), FRAME_SIZE, "0 bytes");
}

TEST_F(EdgeStream, TheEndOfThePublisherIsNoticed) {
  open();
  auto one = subscriber();
  ASSERT_TRUE(subscribers_become(1));
  publish({from_text("last")});
  EXPECT_TRUE(publisher_->flush(std::nullopt));
  publisher_.reset();
  EXPECT_EQ(next(&one), (std::vector<Bytes>{from_text("last")}));
  const auto end = one.receive();
  ASSERT_TRUE(end && end->end);
  EXPECT_EQ(*end->end, StreamSubscriber::End::Lost);
}

TEST_F(EdgeStream, WithoutSubscribersFramesGoNowhere) {
  open();
  EXPECT_EQ(publish({from_text("a")}), Outcome::NoSubscriber);
}

TEST_F(EdgeStream, APublisherTakesItsPortAgainAtOnce) {
  open();
  const uint32_t port = publisher_->port();
  {
    auto one = subscriber();
    ASSERT_TRUE(subscribers_become(1));
    publisher_.reset();
  }
  EXPECT_TRUE(StreamPublisher::open(
      {.host = "localhost", .port = port, .queue = {}, .allowed = {}, .refused = {}}));
}

// docs/compatibility/edge-wire.md 10.6, class 7.
TEST_F(EdgeStream, APeerThatDoesNotReadMissesFramesAndIsRemoved) {
  open(HeaderForm::Bytes2088, {.frames = 2, .full_for = std::chrono::milliseconds(50)});
  const auto socket = raw();
  send_raw(socket, wire::test::golden_host_info());
  auto good = subscriber();
  ASSERT_TRUE(subscribers_become(2));
  const std::vector<Bytes> frame{Bytes(1 << 20)};
  ASSERT_TRUE(becomes_true(
      [&] {
        EXPECT_EQ(publish(frame), Outcome::Sent);
        EXPECT_EQ(next(&good), frame);
        return publisher_->counts().refused == 1;
      },
      "the removal"));
  EXPECT_GT(publisher_->counts().missed, 0u);
  EXPECT_TRUE(subscribers_become(1));
}

// Class 6.
TEST_F(EdgeStream, ASilentPeerStallsNoOtherAndIsRemoved) {
  open();
  const auto socket = raw();
  auto good = subscriber();
  ASSERT_TRUE(subscribers_become(1));
  publish({from_text("a")});
  EXPECT_EQ(next(&good), (std::vector<Bytes>{from_text("a")}));
  EXPECT_TRUE(becomes_true([&] { return publisher_->counts().refused == 1; }, "the removal"));
}

TEST_F(EdgeStream, AFloodOfMessagesStallsNoOtherAndNoStop) {
  open();
  const auto socket = raw();
  send_raw(socket, wire::test::golden_host_info());
  auto good = subscriber();
  ASSERT_TRUE(subscribers_become(2));
  const test::Flood flood(socket.get());
  flood.wait_until_it_runs();
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(publish({from_text("a")}), Outcome::Sent);
    EXPECT_EQ(next(&good), (std::vector<Bytes>{from_text("a")}));
  }
  EXPECT_EQ(publisher_->counts().subscribers, 2u);
  publisher_.reset();
}

TEST_F(EdgeStream, OneAddressHasALimitOfConnections) {
  open(HeaderForm::Bytes2088, {}, 1);
  const auto first = subscriber();
  EXPECT_FALSE(StreamSubscriber::connect("localhost", publisher_->port(), {}));
  EXPECT_EQ(publisher_->counts().refused, 1u);
}

// Class 1.
TEST_F(EdgeStream, AnIncompleteHandshakeEndsTheConnection) {
  open();
  auto good = subscriber();
  ASSERT_TRUE(subscribers_become(1));
  const Bytes whole = wire::test::golden_host_info();
  for (size_t size = 0; size < whole.size(); size += size < 64 ? 1 : 97) {
    const auto socket = raw();
    send_raw(socket, wire::test::start_of(whole, size));
  }
  EXPECT_EQ(publish({from_text("a")}), Outcome::Sent);
  EXPECT_EQ(next(&good).size(), 1u);
  EXPECT_EQ(publisher_->counts().subscribers, 1u);
}

// Classes 2 and 3.
TEST_F(EdgeStream, BytesThatAreNoMessageAreRefused) {
  open();
  const auto socket = raw();
  send_raw(socket, from_text("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"));
  expect_refused(socket, "127.0.0.1");
}
TEST_F(EdgeStream, AFrameInsteadOfTheHandshakeIsRefused) {
  open();
  const auto socket = raw();
  send_raw(socket, wire::test::golden_transfer_data());
  expect_refused(socket, "TRANSFER_DATA");
}
TEST_F(EdgeStream, AHostInfoOfAnotherFormIsRefusedWithTheProperty) {
  open();
  const auto socket = raw();
  send_raw(socket, wire::test::short_host_info());
  expect_refused(socket, "headers of 168 bytes, not of 2088 (property wire-version)");
}
TEST_F(EdgeStream, ASecondHostInfoMeansNothing) {
  open();
  const auto socket = raw();
  send_raw(socket, wire::test::golden_host_info());
  send_raw(socket, wire::test::golden_host_info());
  ASSERT_TRUE(subscribers_become(1));
  EXPECT_EQ(publish({from_text("a")}), Outcome::Sent);
  EXPECT_EQ(publisher_->counts().refused, 0u);
}

// A publisher that sends `bytes` to its one subscriber.
class HostilePublisher : public ::testing::Test {
 protected:
  Error error_after(const Bytes& bytes) {
    auto listener = listen_on("localhost", 0);
    EXPECT_TRUE(listener);
    std::thread publisher([&] {
      pollfd watched{listener->get(), POLLIN, 0};
      poll(&watched, 1, 60000);
      const auto socket = accept_from(listener->get());
      EXPECT_EQ(send(socket.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL),
                static_cast<ssize_t>(bytes.size()));
      shutdown(socket.get(), SHUT_WR);
      std::byte rest[4096];
      do {
        watched.fd = socket.get();
        poll(&watched, 1, 60000);
      } while (recv(socket.get(), rest, sizeof rest, MSG_DONTWAIT) > 0);
    });
    Error out{.code = Code::INTERNAL, .what = "no error"};
    {
      auto subscriber = StreamSubscriber::connect("localhost", get_port(listener->get()),
                                                  {.message_bytes = 1 << 20});
      if (!subscriber) out = subscriber.error();
      while (subscriber) {
        const auto received = subscriber->receive();
        if (!received) out = received.error();
        if (received && received->end) out.what = "lost";
        if (!received || received->end) break;
      }
    }
    publisher.join();
    return out;
  }
  static Bytes greeting(std::string_view text = "@edge_sink_caps@") {
    const auto message =
        wire::text_message(HeaderForm::Bytes2088, wire::Command::Capability, 1, text);
    EXPECT_TRUE(message);
    return message ? *message : Bytes();
  }
};

// As a connection that is reset there: the next edgesink may complete it.
TEST_F(HostilePublisher, ClosesWithinTheGreetingOrAFrame) {
  using wire::test::operator+;
  const Bytes whole = greeting() + wire::test::golden_transfer_data();
  for (const size_t size : {size_t{1}, size_t{15}, size_t{100}, greeting().size() - 1})
    EXPECT_EQ(error_after(wire::test::start_of(whole, size)).code, Code::SERVER_REFUSED);
  for (const size_t size : {greeting().size() + 1, greeting().size() + 2088, whole.size() - 1})
    EXPECT_EQ(error_after(wire::test::start_of(whole, size)).what, "lost");
  EXPECT_EQ(error_after(whole).what, "lost");
}
TEST_F(HostilePublisher, DeclaresMoreThanTheLimit) {
  using wire::test::operator+;
  const auto frame =
      wire::test::with_bytes(wire::test::golden_transfer_data(), 32, "00 00 00 00 00 00 00 10");
  EXPECT_EQ(error_after(greeting() + frame).code, Code::PEER_MESSAGE_INVALID);
}
TEST_F(HostilePublisher, GreetsWithoutTheKey) {
  EXPECT_EQ(error_after(greeting("@query_server_src_caps@a")).code, Code::PEER_MESSAGE_INVALID);
}
TEST_F(HostilePublisher, SendsAFrameFirst) {
  EXPECT_SAYS(error_after(wire::test::golden_transfer_data()).message(), "TRANSFER_DATA");
}
TEST_F(HostilePublisher, StopsInsteadOfAGreeting) {
  const auto error = error_after(wire::test::golden_error());
  EXPECT_EQ(error.code, Code::SERVER_REFUSED);
  EXPECT_SAYS(error.message(), "it has stopped");
}
TEST_F(HostilePublisher, SaysNothing) {
  EXPECT_EQ(error_after({}).code, Code::SERVER_REFUSED);
}

TEST_F(HostilePublisher, AFloodOfMessagesDoesNotHoldUpTheStop) {
  const auto listener = listen_on("localhost", 0);
  ASSERT_TRUE(listener);
  auto made = StreamSubscriber::open("localhost", get_port(listener->get()), {},
                                     std::chrono::seconds(60), -1);
  ASSERT_TRUE(made);
  pollfd watched{listener->get(), POLLIN, 0};
  poll(&watched, 1, 60000);
  const auto socket = accept_from(listener->get());
  const Bytes bytes = greeting();
  EXPECT_EQ(send(socket.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL),
            static_cast<ssize_t>(bytes.size()));
  EXPECT_TRUE(*made->greet(io::deadline_in(std::chrono::seconds(60)), -1));
  const test::Flood flood(socket.get());
  transport::WakeEvent stop;
  std::thread stopper([&] {
    flood.wait_until_it_runs();
    stop.set();
  });
  EXPECT_EQ(made->receive(stop.descriptor())->end, StreamSubscriber::End::Interrupted);
  stopper.join();
}

TEST(EdgeSocket, AddressesThatCannotBeUsed) {
  EXPECT_REFUSED(listen_on("203.0.113.1", 0), OPTION_VALUE, "203.0.113.1:0");
  const auto first = listen_on("localhost", 0);
  ASSERT_TRUE(first);
  EXPECT_REFUSED(listen_on("localhost", get_port(first->get())), OPTION_VALUE, "in use");
  EXPECT_REFUSED(StreamSubscriber::connect("no-such-host.invalid", 1, {}), SERVER_UNREACHABLE,
                 "no-such-host.invalid:1");
}

}  // namespace stream_test
}  // namespace weir::edge
