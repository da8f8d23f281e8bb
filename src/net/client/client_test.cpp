// Addresses, messages, circuits and the choice of servers, without a network.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <thread>

#include "becomes.hpp"
#include "net/client/circuit.hpp"
#include "net/client/server_set.hpp"
#include "net/protocol/oip_contents.hpp"

namespace weir::net {
namespace client_test {

using namespace std::chrono_literals;

// ---- Addresses ---------------------------------------------------------------------------------

TEST(ServerAddress, ReadsHostPortModelAndVersion) {
  const auto address = ServerAddress::parse("grpc://127.0.0.1:8001/resnet/2");
  ASSERT_TRUE(address);
  EXPECT_EQ(address->target, "127.0.0.1:8001");
  EXPECT_EQ(address->model, "resnet");
  EXPECT_EQ(address->version, "2");
  EXPECT_FALSE(address->encrypted);
  EXPECT_TRUE(address->local);
}

TEST(ServerAddress, ReadsOtherForms) {
  const auto unix_socket = ServerAddress::parse("grpc+unix:/run/a:/m");
  ASSERT_TRUE(unix_socket);
  EXPECT_EQ(unix_socket->target, "unix:/run/a");
  EXPECT_TRUE(unix_socket->local);
  const auto named = ServerAddress::parse("grpcs:dns:///farm.example:8001/m");
  ASSERT_TRUE(named);
  EXPECT_EQ(named->target, "dns:///farm.example:8001");
  EXPECT_TRUE(named->encrypted);
}

TEST(ServerAddress, DistinguishesThisMachineFromOthers) {
  for (const auto* host : {"127.0.0.1", "127.9.9.9", "localhost", "[::1]"})
    EXPECT_TRUE(ServerAddress::parse("grpc://" + std::string(host) + ":1/m")->local) << host;
  for (const auto* host :
       {"127.0.0.1.example", "127.evil.example.org", "10.0.0.1", "localhost.example", "[::2]"})
    EXPECT_FALSE(ServerAddress::parse("grpc://" + std::string(host) + ":1/m")->local) << host;
}

TEST(ServerAddress, RefusesWhatItCannotReadAndSaysWhy) {
  const struct {
    const char *text, *difference;
  } cases[] = {{"http://a:1/m", "it does not begin with grpc: or grpcs:"},
               {"", "it does not begin with grpc: or grpcs:"},
               {"grpc://a:1", "no model name"},
               {"grpc://a:1/", "no model name"},
               {"grpc://a/m", "no host and port"},
               {"grpc://:1/m", "no host and port"},
               {"grpc://a:0/m", "the port is not a number from 1 to 65535"},
               {"grpc://a:65536/m", "the port is not a number from 1 to 65535"},
               {"grpc://::1:80/m", "an IPv6 address needs brackets: [::1]:8001"},
               {"grpc://localhost@evil.example:80/m", "an IPv6 address needs brackets: [::1]:8001"},
               {"grpc://a:1/m/1/2", "more than a model and a version"},
               {"grpc+unix:/run/a", "no socket and model, as in grpc+unix:/run/weir.sock:/resnet"}};
  for (const auto& c : cases) {
    const auto address = ServerAddress::parse(c.text);
    ASSERT_FALSE(address) << c.text;
    EXPECT_EQ(address.error().difference, c.difference) << c.text;
    EXPECT_EQ(address.error().fix, "model=grpc://127.0.0.1:8001/resnet/1");
  }
}

// ---- Messages ----------------------------------------------------------------------------------

std::string joined(const Pieces& pieces) {
  std::string out;
  for (const auto& piece : pieces)
    out += piece.own.empty() ? std::string(reinterpret_cast<const char*>(piece.borrowed.data()),
                                           piece.borrowed.size())
                             : piece.own;
  return out;
}

// The same bytes in chunks of `size`.
Chunks chunked(const std::string& bytes, size_t size) {
  std::vector<Chunks::Chunk> out;
  const auto all = std::as_bytes(std::span(bytes));
  for (size_t at = 0; at < all.size(); at += size)
    out.push_back(all.subspan(at, std::min(size, all.size() - at)));
  return Chunks(std::move(out));
}

// A response of the model m with the output y = [1, 2], written by hand.
const std::string kResponse(
    "\x0a\x01m\x2a\x0d\x0a\x01y\x12\x04"
    "FP32\x1a\x02\x01\x02\x32\x08\x00\x00\x80\x3f\x00\x00\x00\x40",
    28);

TEST(InferRequest, HasTheBytesOfTheProtocolAndTheTensorInPlace) {
  const float x[] = {1, 2};
  const int64_t shape[] = {1, 2};
  const RequestTensor tensor{"x", "FP32", shape, std::as_bytes(std::span(x))};
  uint64_t copied = 0;
  const auto pieces =
      encode_infer_request("m", "1", std::span(&tensor, 1), Contents::Raw, false, &copied);
  ASSERT_TRUE(pieces);
  const std::string expected(
      "\x0a\x01m\x12\x01"
      "1\x2a\x0d\x0a\x01x\x12\x04"
      "FP32\x1a\x02\x01\x02\x3a\x08\x00\x00\x80\x3f\x00\x00\x00\x40",
      31);
  EXPECT_EQ(joined(*pieces), expected);
  EXPECT_EQ(pieces->back().borrowed.data(), std::as_bytes(std::span(x)).data());
  EXPECT_EQ(copied, 0u);
}

TEST(InferRequest, RefusesTypedContentsOfHalves) {
  const uint16_t x[] = {0};
  const int64_t shape[] = {1};
  const RequestTensor tensor{"x", "FP16", shape, std::as_bytes(std::span(x))};
  uint64_t copied = 0;
  const auto pieces =
      encode_infer_request("m", "", std::span(&tensor, 1), Contents::Typed, false, &copied);
  ASSERT_FALSE(pieces);
  EXPECT_EQ(pieces.error().offered, "x of type FP16");
  EXPECT_EQ(pieces.error().fix, "custom=contents:raw");
}

TEST(InferResponse, IsReadFromChunksOfAnySize) {
  for (size_t size = 1; size <= kResponse.size(); ++size) {
    const auto chunks = chunked(kResponse, size);
    const auto response = parse_infer_response(chunks);
    ASSERT_TRUE(response) << size;
    ASSERT_EQ(response->outputs.size(), 1u);
    EXPECT_EQ(response->outputs[0].name, "y");
    EXPECT_EQ(response->outputs[0].shape, (std::vector<int64_t>{1, 2}));
    float y[2] = {};
    ASSERT_TRUE(read_elements(chunks, response->outputs[0], std::as_writable_bytes(std::span(y)),
                              Sender::Server));
    EXPECT_EQ(y[0], 1);
    EXPECT_EQ(y[1], 2);
  }
}

TEST(InferResponse, RefusesEveryTruncatedMessage) {
  int refused = 0;
  for (size_t bytes = 1; bytes < kResponse.size(); ++bytes) {
    const std::string cut = kResponse.substr(0, bytes);
    const auto chunks = chunked(cut, 5);
    const auto response = parse_infer_response(chunks);
    float y[2] = {};
    const bool read = response && response->outputs.size() == 1 &&
                      read_elements(chunks, response->outputs[0],
                                    std::as_writable_bytes(std::span(y)), Sender::Server);
    EXPECT_FALSE(read) << bytes;
    refused += !response;
  }
  EXPECT_EQ(refused, 25);  // a cut after a whole field leaves a valid message: after m, after y
}

TEST(InferResponse, RefusesRawContentsWithoutOutputs) {
  const std::string wire_bytes("\x32\x01\x00", 3);
  const auto response = parse_infer_response(chunked(wire_bytes, 3));
  ASSERT_FALSE(response);
  EXPECT_EQ(response.error().code, Code::PEER_MESSAGE_INVALID);
  EXPECT_EQ(response.error().offered, "1 raw contents for 0 outputs");
}

// ---- Circuits ----------------------------------------------------------------------------------

void ended(Circuit* circuit, Outcome outcome) {
  const bool trial = circuit->state() == Circuit::State::HalfOpen;
  circuit->begin();
  circuit->end(outcome, trial);
}

TEST(Circuit, OpensAfterTwoLostOrThreeLateInARow) {
  Circuit lost, late;
  ended(&lost, Outcome::Lost);
  EXPECT_TRUE(lost.admits());
  ended(&lost, Outcome::Lost);
  EXPECT_FALSE(lost.admits());
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(late.admits());
    ended(&late, Outcome::Late);
  }
  EXPECT_FALSE(late.admits());
}

TEST(Circuit, StaysClosedWhenAResponseIsBetween) {
  Circuit circuit;
  for (int i = 0; i < 10; ++i) {
    ended(&circuit, Outcome::Lost);
    ended(&circuit, i % 2 ? Outcome::Answered : Outcome::Refused);
  }
  EXPECT_TRUE(circuit.admits());
}

TEST(Circuit, LetsOneTrialThroughAfterAProbe) {
  Circuit circuit;
  circuit.open();
  circuit.probe_answered();
  ASSERT_TRUE(circuit.admits());
  circuit.begin();
  EXPECT_FALSE(circuit.admits());
  circuit.end(Outcome::Late, true);
  EXPECT_EQ(circuit.state(), Circuit::State::Open);
  circuit.probe_answered();
  ended(&circuit, Outcome::Answered);
  EXPECT_EQ(circuit.state(), Circuit::State::Closed);
}

// ---- The choice of servers ----------------------------------------------------------------------

// A server whose requests the test answers.
struct FakeLink final : Link {
  explicit FakeLink(std::function<int()> status) : status_(std::move(status)) {}
  Reply call(const std::string&, const Pieces&, const std::shared_ptr<const void>&,
             Clock::time_point) override {
    ++calls;
    Reply out;
    out.status = status_();
    return out;
  }
  Reply call_when_connected(const std::string& method, const Pieces& request,
                            Clock::time_point deadline) override {
    return call(method, request, nullptr, deadline);
  }
  std::atomic<int> calls{0};
  const std::function<int()> status_;
};

class ServerSetTest : public testing::Test {
 protected:
  FakeLink* add(std::function<int()> status) {
    auto link = std::make_unique<FakeLink>(std::move(status));
    auto* out = link.get();
    servers_.push_back({*ServerAddress::parse("grpc://127.0.0.1:1/m"), std::move(link)});
    return out;
  }
  void start(ServerSet::Probe probe = [](size_t, auto) { return false; }) {
    limits_.probe = 1ms;
    set_ = std::make_unique<ServerSet>(std::move(servers_), limits_, std::move(probe));
  }
  Outcome request() {
    return set_
        ->request([](size_t) -> Result<Pieces> { return Pieces{}; }, nullptr,
                  ServerSet::Clock::time_point::max(), [](const auto&, auto*) { return ok(); })
        .outcome;
  }
  RequestLimits limits_;
  std::vector<ServerSet::Server> servers_;
  std::unique_ptr<ServerSet> set_;
};

TEST_F(ServerSetTest, SpreadsRequestsOverServers) {
  auto* a = add([] { return 0; });
  auto* b = add([] { return 0; });
  start();
  for (int i = 0; i < 10; ++i) EXPECT_EQ(request(), Outcome::Answered);
  EXPECT_EQ(a->calls, 5);
  EXPECT_EQ(b->calls, 5);
}

TEST_F(ServerSetTest, TriesAnotherServerAndLeavesTheLostOneAlone) {
  auto* dead = add([] { return 14; });
  auto* alive = add([] { return 0; });
  start();
  for (int i = 0; i < 10; ++i) EXPECT_EQ(request(), Outcome::Answered);
  EXPECT_EQ(dead->calls, 2);
  EXPECT_EQ(alive->calls, 10);
}

TEST_F(ServerSetTest, BringsAServerBackAfterAProbe) {
  std::atomic<int> status{14};
  add([&] { return status.load(); });
  start([&](size_t, auto) {
    status = 0;
    return true;
  });
  EXPECT_EQ(request(), Outcome::Lost);
  EXPECT_TRUE(
      becomes_true([&] { return request() == Outcome::Answered; }, "an answer after a probe"));
  const auto counts = set_->counts();
  EXPECT_EQ(counts.sent, counts.of(Outcome::Answered) + counts.of(Outcome::Lost));
}

TEST_F(ServerSetTest, DoesNotRepeatWhatAServerRefused) {
  auto* a = add([] { return 3; });
  auto* b = add([] { return 3; });
  start();
  EXPECT_EQ(request(), Outcome::Refused);
  EXPECT_EQ(a->calls + b->calls, 1);
}

TEST_F(ServerSetTest, SendsOnceWithOneAttempt) {
  auto* a = add([] { return 14; });
  auto* b = add([] { return 14; });
  limits_.attempts = 1;
  start();
  EXPECT_EQ(request(), Outcome::Lost);
  EXPECT_EQ(a->calls + b->calls, 1);
}

TEST_F(ServerSetTest, KeepsTheWindowOfAServer) {
  std::atomic<int> now{0}, max{0};
  add([&] {
    const int mine = ++now;
    for (int seen = max; mine > seen && !max.compare_exchange_weak(seen, mine);) {
    }
    std::this_thread::yield();
    --now;
    return 0;
  });
  limits_.in_flight = 2;
  start();
  std::vector<std::jthread> threads;
  for (int i = 0; i < 8; ++i)
    threads.emplace_back([&] {
      for (int k = 0; k < 50; ++k) EXPECT_EQ(request(), Outcome::Answered);
    });
  threads.clear();
  EXPECT_LE(max, 2);
  EXPECT_EQ(set_->counts().of(Outcome::Answered), 400u);
}

TEST_F(ServerSetTest, CountsEveryEndOnce) {
  const int statuses[] = {0, 4, 14, 3, 0, 13, 8};
  std::atomic<size_t> at{0};
  for (int i = 0; i < 3; ++i) add([&] { return statuses[at++ % std::size(statuses)]; });
  start([](size_t, auto) { return true; });
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&] {
      for (int k = 0; k < 250; ++k) request();
    });
  threads.clear();
  const auto counts = set_->counts();
  EXPECT_EQ(counts.sent, 1000u);
  EXPECT_EQ(counts.sent, counts.of(Outcome::Answered) + counts.of(Outcome::Late) +
                             counts.of(Outcome::Refused) + counts.of(Outcome::Lost));
}

}  // namespace client_test
}  // namespace weir::net
