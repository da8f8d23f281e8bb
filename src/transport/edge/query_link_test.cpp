// The client's two connections with a query server, and servers that break the rules
// (docs/compatibility/edge-wire.md 10.6).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/edge/query_link.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <ctime>

#include "becomes.hpp"
#include "says.hpp"
#include "transport/edge/flood_test_support.hpp"
#include "transport/edge/query_server_test_support.hpp"

namespace weir::edge {
namespace query_link_test {

using namespace std::chrono_literals;
using test::ScriptedServer;
using wire::Command;
using wire::HeaderForm;
using wire::test::Bytes;
using wire::test::from_hex;
using wire::test::from_text;
using wire::test::operator+;
using wire::test::with_bytes;

class EdgeQuery : public ::testing::Test {
 protected:
  QueryOptions options(const ScriptedServer& server) const {
    return {.server_host = "127.0.0.1",
            .server_port = server.port(),
            .limits = {.message_bytes = 1 << 20},
            .cancel = stop_.descriptor()};
  }
  // A link whose handshake is complete.
  std::unique_ptr<QueryLink> linked(const ScriptedServer& server) {
    return linked(options(server));
  }
  static std::unique_ptr<QueryLink> linked(const QueryOptions& options) {
    auto link = QueryLink::connect(options);
    EXPECT_TRUE(link) << (link ? "" : link.error().message());
    if (!link) return nullptr;
    const auto status = (*link)->confirm(io::deadline_in(60s));
    EXPECT_TRUE(status) << (status ? "" : status.error().message());
    return *std::move(link);
  }
  static void send(QueryLink* link, const std::vector<Bytes>& memories, uint64_t number = 0) {
    auto request = link->make_request({memories.begin(), memories.end()}, number);
    ASSERT_TRUE(request);
    const auto ended = link->send(*request);
    ASSERT_TRUE(ended);
    EXPECT_FALSE(*ended);
  }
  static Result<QueryLink::Received> receive(QueryLink* link) {
    return link->receive(io::deadline_in(60s));
  }
  static std::vector<Bytes> get_bytes(const QueryResponse& response) {
    std::vector<Bytes> out;
    for (const auto& memory : response.memories) out.push_back(wire::test::copy_of(memory.bytes()));
    return out;
  }
  // The error of a server that sends `greeting` and then closes.
  std::string greeting_error(const Bytes& greeting) {
    ScriptedServer server([&](auto& s) {
      s.accept();
      s.send(s.requests, greeting);
      s.close();
    });
    const auto link = QueryLink::connect(options(server));
    return link ? "" : link.error().message();
  }
  // The error of receive() after the server answered a frame with `bytes`; "lost", "refused" if
  // the connection ended.
  std::string response_error(const Bytes& bytes, HeaderForm form = HeaderForm::Bytes2088) {
    ScriptedServer server([&](auto& s) {
      s.handshake("A", "B", form);
      s.read();
      s.send(s.responses, bytes);
      s.close();
    });
    const auto link = linked(server);
    if (!link) return "no link";
    send(link.get(), {from_text("x")});
    auto received = receive(link.get());
    if (!received) return received.error().message();
    if (received->response) return "an answer";
    return *received->end == LinkEnd::Lost ? "lost" : "refused";
  }

  transport::WakeEvent stop_;
};

TEST_F(EdgeQuery, FramesGoOutAndResponsesComeBackInEachForm) {
  for (const auto form : {HeaderForm::Bytes2088, HeaderForm::Bytes168, HeaderForm::Bytes160}) {
    ScriptedServer server([form](auto& s) {
      s.handshake("A", "B", form);
      for (;;) s.echo(s.read());
    });
    const auto link = linked(server);
    ASSERT_TRUE(link);
    EXPECT_EQ(link->capability().source_caps, "A");
    EXPECT_EQ(link->capability().sink_caps, "B");
    for (int i = 0; i < 3; ++i) {
      const std::vector<Bytes> frame{from_text("abcd"), from_text("xyz"), Bytes(300000)};
      send(link.get(), frame, i);
      const auto received = receive(link.get());
      ASSERT_TRUE(received && received->response);
      EXPECT_EQ(get_bytes(*received->response), frame);
      EXPECT_FALSE(received->response->number);
    }
  }
}

// docs/compatibility/edge-wire.md 10.7, but for weir.seq.
TEST_F(EdgeQuery, TheBytesOfTheHandshakeAreThoseOfNNStreamer) {
  Bytes host_info;
  ScriptedServer server([&](auto& s) {
    s.accept();
    s.send(s.requests, wire::test::golden_capability());
    host_info.resize(2088);
    size_t got = 0;
    while (got < host_info.size()) {
      const ssize_t step =
          recv(s.requests.get(), host_info.data() + got, host_info.size() - got, 0);
      if (step > 0) got += static_cast<size_t>(step);
      if (step == 0) return;
    }
  });
  auto link = QueryLink::connect(options(server));
  ASSERT_TRUE(link) << link.error().message();
  std::thread confirming([&] { EXPECT_FALSE((*link)->confirm(std::nullopt)); });
  ASSERT_TRUE(becomes_true([&] { return server.has_ended(); }, "the HOST_INFO"));
  stop_.set();
  confirming.join();
  // The text is "localhost:PORT" and its NUL.
  Bytes expected = wire::test::golden_host_info();
  expected.resize(2088);
  const auto length = std::to_integer<int>(host_info[32]);
  EXPECT_GE(length, 12);
  EXPECT_LE(length, 16);
  expected[32] = host_info[32];
  EXPECT_EQ(host_info, expected);
}

TEST_F(EdgeQuery, TheServerSeesTheAddressOfTheListener) {
  for (const std::string host : {"localhost", "127.0.0.1", "0.0.0.0", ""}) {
    ScriptedServer server([](auto& s) { s.handshake("A", "B"); });
    auto wanted = options(server);
    wanted.host = host;
    ASSERT_TRUE(linked(wanted)) << host;
    ASSERT_TRUE(becomes_true([&] { return server.has_ended(); }, "the handshake"));
    const std::string expected = host == "localhost" ? "localhost:" : "127.0.0.1:";
    EXPECT_EQ(server.announced().substr(0, expected.size()), expected) << host;
  }
}

TEST_F(EdgeQuery, NumbersOfResponsesAreRead) {
  ScriptedServer server([](auto& s) {
    s.handshake("A", "B");
    const auto a = s.read(), b = s.read();
    s.echo(b, true);
    s.echo(a, true);
    s.ignore_all();
  });
  const auto link = linked(server);
  ASSERT_TRUE(link);
  send(link.get(), {from_text("a")}, 5);
  send(link.get(), {from_text("b")}, 6);
  EXPECT_EQ(receive(link.get())->response->number, 6u);
  EXPECT_EQ(receive(link.get())->response->number, 5u);
}

TEST_F(EdgeQuery, AsManyMemoriesAsTheFormHas) {
  for (const auto& [form, max] :
       {std::pair(HeaderForm::Bytes2088, 255), std::pair(HeaderForm::Bytes168, 15),
        std::pair(HeaderForm::Bytes160, 15)}) {
    ScriptedServer server([form = form](auto& s) {
      s.handshake("A", "B", form);
      for (;;) s.echo(s.read());
    });
    const auto link = linked(server);
    ASSERT_TRUE(link);
    const std::vector<Bytes> frame(max, from_text("m"));
    send(link.get(), frame);
    EXPECT_EQ(get_bytes(*receive(link.get())->response), frame);
    const Bytes byte(1);
    EXPECT_REFUSED(link->make_request(std::vector<std::span<const std::byte>>(max + 1, byte), 1),
                   LIMIT_EXCEEDED, std::to_string(max + 1));
    EXPECT_REFUSED(link->make_request({std::span<const std::byte>()}, 1), FRAME_SIZE, "0 bytes");
  }
}

// Each side writes before it reads, more than the sockets hold.
TEST_F(EdgeQuery, AServerThatWritesBeforeItReadsDoesNotBlock) {
  constexpr size_t kLarge = 16 << 20;
  ScriptedServer server([](auto& s) {
    s.handshake("A", "B");
    const auto first = s.read();
    s.respond({Bytes(kLarge)});
    s.echo(s.read());
    s.ignore_all();
  });
  auto wanted = options(server);
  wanted.limits.message_bytes = 2 * kLarge;
  const auto link = linked(wanted);
  ASSERT_TRUE(link);
  send(link.get(), {from_text("a")});
  send(link.get(), {Bytes(kLarge)}, 1);
  for (int i = 0; i < 2; ++i)
    EXPECT_EQ(get_bytes(*receive(link.get())->response).at(0).size(), kLarge) << i;
}

// Class 1.
TEST_F(EdgeQuery, GreetingsThatEndAtAnyByteAreRefused) {
  const Bytes whole = wire::test::golden_capability();
  for (const size_t size : {0, 1, 4, 15, 16, 31, 32, 168, 169, 2087, 2088, 2100, 2138}) {
    if (size >= whole.size()) continue;
    EXPECT_SAYS(greeting_error(wire::test::start_of(whole, size)), "closed the connection") << size;
  }
}
TEST_F(EdgeQuery, ResponsesThatEndAtAnyByteAreLost) {
  const Bytes whole = wire::test::golden_transfer_data();
  for (const size_t size : {0, 1, 4, 15, 16, 31, 32, 2087, 2088, 2090, 2095, 2110})
    EXPECT_EQ(response_error(wire::test::start_of(whole, size)), "lost") << size;
  EXPECT_EQ(response_error(whole), "an answer");
}

// Class 2.
TEST_F(EdgeQuery, ResponsesWithImpossibleSizesAreRefused) {
  const Bytes good = wire::test::golden_transfer_data();
  EXPECT_SAYS(response_error(with_bytes(good, 24, "01 01 00 00")), "257 memories");
  EXPECT_SAYS(response_error(with_bytes(good, 32, "ff ff ff ff ff ff ff ff")),
              "larger than allowed");
  EXPECT_SAYS(response_error(with_bytes(good, 32, "ff ff ff ff ff ff ff 7f")),
              "larger than allowed");
  EXPECT_SAYS(response_error(with_bytes(good, 32, "00")), "0 bytes");
  EXPECT_SAYS(response_error(with_bytes(good, 2080, "ff ff ff")), "metadata");
}

// Class 3.
TEST_F(EdgeQuery, GreetingsWithoutUsableTextsAreRefused) {
  const Bytes good = wire::test::golden_capability();
  EXPECT_SAYS(greeting_error(with_bytes(good, 2137, "41")), "NUL");
  EXPECT_SAYS(greeting_error(with_bytes(good, 24, "00")), "exactly one text");
  EXPECT_SAYS(greeting_error(with_bytes(good, 2088, "00")), "does not announce its caps");
  EXPECT_SAYS(greeting_error(with_bytes(good, 4, "02")), "HOST_INFO");
  EXPECT_SAYS(greeting_error(wire::test::golden_transfer_data()), "TRANSFER_DATA");
  EXPECT_SAYS(greeting_error(from_text("GET / HTTP/1.1\r\n\r\n")), "magic");
  EXPECT_SAYS(greeting_error(*wire::text_message(HeaderForm::Bytes2088, Command::Capability, 1,
                                                 "@query_server_src_caps@A")),
              "does not announce its caps");
}
TEST_F(EdgeQuery, AServerThatRefusesAtOnceIsNamed) {
  EXPECT_SAYS(greeting_error(wire::test::golden_error()), "does not start the handshake");
}
TEST_F(EdgeQuery, OtherCommandsAfterTheHandshakeAreIgnored) {
  ScriptedServer server([](auto& s) {
    s.handshake("A", "B");
    const auto message = s.read();
    s.send(s.requests, wire::test::golden_capability() + wire::test::golden_host_info());
    s.send(s.responses, wire::test::golden_capability() + wire::test::golden_host_info());
    s.echo(message);
    s.ignore_all();
  });
  const auto link = linked(server);
  ASSERT_TRUE(link);
  send(link.get(), {from_text("x")});
  const auto received = receive(link.get());
  ASSERT_TRUE(received && received->response);
  EXPECT_EQ(get_bytes(*received->response), std::vector<Bytes>{from_text("x")});
}

// Class 4.
TEST_F(EdgeQuery, ResponsesWithDamagedMetadataAreRefused) {
  const Bytes good = wire::test::golden_transfer_data();
  EXPECT_SAYS(response_error(with_bytes(good, 2095, "02")), "metadata");
  EXPECT_SAYS(response_error(with_bytes(good, 2095, "00")), "metadata");
  EXPECT_SAYS(response_error(with_bytes(good, 2099, "00")), "metadata");
  EXPECT_SAYS(response_error(with_bytes(good, 2119, "41")), "metadata");
}
TEST_F(EdgeQuery, ANumberThatIsNoNumberIsRefused) {
  ScriptedServer server([](auto& s) {
    s.handshake("A", "B");
    s.read();
    s.respond({from_text("x")}, {{"weir.seq", "one"}});
    s.ignore_all();
  });
  const auto link = linked(server);
  ASSERT_TRUE(link);
  send(link.get(), {from_text("x")});
  EXPECT_REFUSED(receive(link.get()), PEER_MESSAGE_INVALID, "\"one\"");
}
TEST_F(EdgeQuery, AResponseWithoutARequestIsRefused) {
  ScriptedServer server([](auto& s) {
    s.handshake("A", "B");
    s.respond({from_text("x")});
    s.ignore_all();
  });
  const auto link = linked(server);
  ASSERT_TRUE(link);
  EXPECT_REFUSED(receive(link.get()), PEER_MESSAGE_INVALID, "does not belong to a request");
}

// Class 5. All of 127.0.0.0/8 is this machine.
TEST_F(EdgeQuery, ResponsesComeOnlyFromTheAddressOfTheServer) {
  std::atomic<bool> closed{false};
  ScriptedServer server([&](auto& s) {
    s.accept();
    s.greet("A", "B");
    const auto stranger = s.connect_from("127.0.0.2", s.read_address());
    std::byte byte{};
    closed = recv(stranger.get(), &byte, 1, 0) == 0;
    s.responses = s.connect_from("127.0.0.1", s.announced());
    s.echo(s.read());
    s.ignore_all();
  });
  auto wanted = options(server);
  wanted.host = "0.0.0.0";
  const auto link = linked(wanted);
  ASSERT_TRUE(link);
  send(link.get(), {from_text("x")});
  EXPECT_TRUE(receive(link.get())->response);
  EXPECT_TRUE(closed);
}
TEST_F(EdgeQuery, TheListenerClosesAfterTheHandshake) {
  std::string announced;
  ScriptedServer server([&](auto& s) {
    s.handshake("A", "B");
    announced = s.announced();
    s.read();
    s.echo(s.read());
    s.ignore_all();
  });
  const auto link = linked(server);
  ASSERT_TRUE(link);
  send(link.get(), {from_text("x")});  // the script has written `announced` when it reads the next
  send(link.get(), {from_text("x")}, 1);
  ASSERT_TRUE(receive(link.get())->response);
  const auto address = wire::parse_host_address(announced);
  EXPECT_REFUSED(connect_to("127.0.0.1", address->port, std::nullopt, -1), SERVER_UNREACHABLE,
                 "refused");
}

// Class 6.
TEST_F(EdgeQuery, AServerThatDoesNotGreetIsAnErrorInTime) {
  ScriptedServer server([](auto& s) {
    s.accept();
    s.ignore_all();
  });
  auto wanted = options(server);
  wanted.handshake_time = 50ms;
  EXPECT_REFUSED(QueryLink::connect(wanted), SERVER_UNREACHABLE, "does not start the handshake");
}
TEST_F(EdgeQuery, AServerThatSendsHalfAGreetingIsAnErrorInTime) {
  for (const size_t size : {3, 16, 100, 2088}) {
    ScriptedServer server([size = size](auto& s) {
      s.accept();
      s.send(s.requests, wire::test::start_of(wire::test::golden_capability(), size));
      s.ignore_all();
    });
    auto wanted = options(server);
    wanted.handshake_time = 50ms;
    EXPECT_REFUSED(QueryLink::connect(wanted), SERVER_UNREACHABLE, "does not start the handshake");
  }
}
TEST_F(EdgeQuery, AServerThatDoesNotConnectBackIsAnErrorInTime) {
  ScriptedServer server([](auto& s) {
    s.accept();
    s.greet("A", "B");
    s.ignore_all();
  });
  const auto link = QueryLink::connect(options(server));
  ASSERT_TRUE(link);
  const auto status = (*link)->confirm(io::deadline_in(50ms));
  EXPECT_REFUSED(status, SERVER_UNREACHABLE, "did not connect to the client");
  EXPECT_SAYS(status.error().message(), "set host to an address");
}
TEST_F(EdgeQuery, AServerThatCannotConnectBackIsNamed) {
  ScriptedServer server([](auto& s) {
    s.accept();
    s.greet("A", "B");
    s.read();
    s.send(s.requests, wire::test::golden_error());
    s.ignore_all();
  });
  const auto link = QueryLink::connect(options(server));
  ASSERT_TRUE(link);
  const auto status = (*link)->confirm(io::deadline_in(60s));
  EXPECT_REFUSED(status, SERVER_REFUSED, "ended the handshake");
  EXPECT_SAYS(status.error().message(), "localhost:");
}

// The connection of the server makes the listener readable all the time.
TEST_F(EdgeQuery, PausesWhileThereIsNoDescriptorForTheServer) {
  rlimit before{};
  getrlimit(RLIMIT_NOFILE, &before);
  ScriptedServer server([&](auto& s) {
    s.accept();
    s.greet("A", "B");
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(wire::parse_host_address(s.read_address())->port);
    inet_pton(AF_INET, "127.0.0.1", &address.sin_addr);
    s.responses = io::Descriptor(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    const rlimit none{4, before.rlim_max};  // enough for the sockets that a poll() waits for
    setrlimit(RLIMIT_NOFILE, &none);
    const auto* const generic = reinterpret_cast<const sockaddr*>(&address);
    EXPECT_EQ(connect(s.responses.get(), generic, sizeof address), 0);
    s.wait_for_the_end_of_the_test();
  });
  const auto link = QueryLink::connect(options(server));
  ASSERT_TRUE(link);
  const auto get_time = [](clockid_t clock) {
    timespec time{};
    clock_gettime(clock, &time);
    return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
  };
  const auto began = get_time(CLOCK_MONOTONIC), worked = get_time(CLOCK_THREAD_CPUTIME_ID);
  const auto status = (*link)->confirm(io::deadline_in(350ms));
  EXPECT_LT(get_time(CLOCK_THREAD_CPUTIME_ID) - worked, (get_time(CLOCK_MONOTONIC) - began) / 2);
  setrlimit(RLIMIT_NOFILE, &before);
  EXPECT_REFUSED(status, SERVER_UNREACHABLE, "in time: Too many open files");
  EXPECT_SAYS(status.error().message(), "fix: ulimit -n");
  EXPECT_TRUE((*link)->confirm(io::deadline_in(60s))) << "the connection still waits";
}

// Class 7.
TEST_F(EdgeQuery, AServerThatDoesNotReadIsLostAfterAWhile) {
  ScriptedServer server([](auto& s) {
    s.handshake("A", "B");
    s.wait_for_the_end_of_the_test();
  });
  auto wanted = options(server);
  wanted.stall_time = 50ms;
  const auto link = linked(wanted);
  ASSERT_TRUE(link);
  const Bytes large(64 << 20);
  const auto request = link->make_request({large}, 0);
  const auto ended = link->send(*request);
  ASSERT_TRUE(ended);
  EXPECT_EQ(*ended, LinkEnd::Lost);
}

// Class 10.
TEST_F(EdgeQuery, EveryWaitCanBeInterrupted) {
  ScriptedServer silent([](auto& s) {
    s.accept();
    s.wait_for_the_end_of_the_test();
  });
  stop_.set();
  EXPECT_REFUSED(QueryLink::connect(options(silent)), CANCELLED, "cancelled");
  stop_.clear();
  ScriptedServer server([](auto& s) {
    s.handshake("A", "B");
    s.wait_for_the_end_of_the_test();
  });
  const auto link = linked(server);
  ASSERT_TRUE(link);
  stop_.set();
  EXPECT_EQ(receive(link.get())->end, LinkEnd::Interrupted);
  const Bytes large(64 << 20);
  const auto request = link->make_request({large}, 0);
  EXPECT_EQ(*link->send(*request), LinkEnd::Interrupted);
}
TEST_F(EdgeQuery, AFloodOfMessagesHoldsUpNeitherTheTimeNorAStop) {
  for (const bool on_requests : {true, false}) {
    ScriptedServer server([&](auto& s) {
      s.handshake("A", "B");
      const auto bytes = test::ignored_messages();
      s.until_closed([&] {
        for (;;) s.send(on_requests ? s.requests : s.responses, bytes);
      });
    });
    const auto link = linked(server);
    ASSERT_TRUE(link);
    EXPECT_EQ(link->receive(io::deadline_in(300ms))->end, LinkEnd::Late);
    stop_.set();
    EXPECT_EQ(receive(link.get())->end, LinkEnd::Interrupted);
    stop_.clear();
  }
}
TEST_F(EdgeQuery, ResponsesThatCameBeforeTheEndAreNotLost) {
  ScriptedServer server([](auto& s) {
    s.handshake("A", "B");
    const auto a = s.read(), b = s.read();
    s.echo(a);
    s.echo(b);
    s.send(s.responses, wire::test::golden_error());
  });
  const auto link = linked(server);
  ASSERT_TRUE(link);
  send(link.get(), {from_text("a")});
  send(link.get(), {from_text("b")}, 1);
  EXPECT_EQ(get_bytes(*receive(link.get())->response), std::vector<Bytes>{from_text("a")});
  EXPECT_EQ(get_bytes(*receive(link.get())->response), std::vector<Bytes>{from_text("b")});
  EXPECT_EQ(receive(link.get())->end, LinkEnd::Refused);
}
TEST_F(EdgeQuery, TheServerGetsErrorAtTheEnd) {
  std::atomic<int> last{-1};
  ScriptedServer server([&](auto& s) {
    s.handshake("A", "B");
    s.read();
    last = static_cast<int>(s.read().command);
    s.ignore_all();
  });
  {
    const auto link = linked(server);
    ASSERT_TRUE(link);
    send(link.get(), {from_text("x")});
  }
  ASSERT_TRUE(becomes_true([&] { return server.has_ended(); }, "the end"));
  EXPECT_EQ(last, static_cast<int>(Command::Error));
}
TEST_F(EdgeQuery, AnAddressThatIsTakenIsNamed) {
  const ScriptedServer other([](auto&) {});
  ScriptedServer server([](auto& s) { s.accept(); });
  auto wanted = options(server);
  wanted.port = other.port();
  wanted.host = "127.0.0.1";
  EXPECT_REFUSED(QueryLink::connect(wanted), OPTION_VALUE, "in use");
}

}  // namespace query_link_test
}  // namespace weir::edge
