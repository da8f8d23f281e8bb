// Clients that break the protocol, or use it against the server: the classes of
// docs/compatibility/edge-wire.md 10.6, by their numbers there.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include <set>
#include <thread>

#include "transport/edge/flood_test_support.hpp"
#include "transport/edge/query_client_test_support.hpp"

namespace weir::edge::test {
namespace hostile_client_test {

using Sent = QueryListener::Sent;
using std::chrono::milliseconds;
using wire::test::start_of;
using wire::test::with_bytes;

class HostileClient : public EdgeQuery {
 protected:
  // The server closes the connection, with these words in the log, and serves others.
  void expect_refused(const RawClient& peer, const std::string& words) {
    peer.a.rest();
    EXPECT_TRUE(is_refused(words));
    expect_service();
  }
  void expect_handshake_refused(const Bytes& bytes, const std::string& words) {
    if (!listener_) open();
    auto peer = client();
    peer.greeting();
    peer.a.try_to_send(bytes);
    expect_refused(peer, words);
  }
  void expect_request_refused(const Bytes& bytes, const std::string& words) {
    if (!listener_) open();
    auto peer = connected();
    peer.a.try_to_send(bytes);
    expect_refused(peer, words);
  }
  // The clients keep their places for twice their timeout while others come.
  void expect_places_kept(size_t clients) {
    const auto end = std::chrono::steady_clock::now() + 2 * kTimeout;
    while (std::chrono::steady_clock::now() < end) client().a.rest();
    EXPECT_TRUE(is_refused(std::to_string(clients) +
                           " clients are already connected (property max-connections)"));
    EXPECT_EQ(listener_->counts().clients, clients);
  }
  static constexpr milliseconds kTimeout{100};
  static Bytes host_info(const std::string& text, HeaderForm form = HeaderForm::Bytes2088) {
    return *wire::text_message(form, wire::Command::HostInfo, 1, text);
  }
  // A frame "ab" with these bytes as its metadata.
  Bytes with_metadata(const Bytes& metadata) {
    if (!listener_) open();
    auto peer = client();
    return peer.request_bytes({from_text("ab")}, "", metadata);
  }
};

TEST_F(HostileClient, Class1HandshakesOfEveryLength) {
  open({.max_clients = 0});
  for (const auto form : {HeaderForm::Bytes2088, HeaderForm::Bytes168}) {
    const Bytes whole = host_info("localhost:1", form);
    for (size_t size = 0; size < whole.size(); size += size < 200 || size > 2070 ? 1 : 64) {
      auto peer = client(form);
      peer.greeting();
      peer.a.send(start_of(whole, size));
      peer.close();
    }
  }
  expect_service();
  EXPECT_TRUE(clients_become(0));
}

TEST_F(HostileClient, Class1RequestsOfEveryLength) {
  open({.max_clients = 0});
  auto first = connected();
  const Bytes whole = first.request_bytes({from_text("abcd"), from_text("xyz")});
  for (size_t size = 1; size < whole.size(); size += size < 60 || size > 2070 ? 1 : 64) {
    auto peer = connected();
    peer.a.send(start_of(whole, size));
    peer.close();
  }
  expect_service();
  EXPECT_EQ(listener_->requests().received, 1u);
}

TEST_F(HostileClient, Class2MoreMemoriesThanTheTable) {
  const Bytes frame = with_bytes(wire::test::golden_transfer_data(), 24, "01 01 00 00");
  expect_request_refused(frame, "257");
}

TEST_F(HostileClient, Class2SizesWhoseSumWraps) {
  const Bytes frame = with_bytes(wire::test::golden_transfer_data(), 32,
                                 "00 00 00 00 00 00 00 80 04 00 00 00 00 00 00 80");
  expect_request_refused(frame, "a message is larger than allowed");
}

TEST_F(HostileClient, Class2SizesThatAreNeverSent) {
  open({.client = {.max_message_bytes = 64 << 20, .timeout = milliseconds(300)}});
  auto peer = connected();
  peer.a.send(start_of(with_bytes(wire::test::golden_transfer_data(), 32, "00 00 00 02"), 2088));
  expect_refused(peer, "it paused within a message for 300 ms (property timeout)");
}

TEST_F(HostileClient, Class2MessagesBeyondTheLimit) {
  open({.client = {.max_message_bytes = 1000}});
  auto peer = connected();
  peer.a.try_to_send(peer.request_bytes({Bytes(1001)}));
  expect_refused(peer, "a message is larger than allowed");
}

TEST_F(HostileClient, Class3TextsThatAreNoAddress) {
  expect_handshake_refused(with_bytes(host_info("localhost:1"), 2099, "41"),
                           "a text of a peer has no end");
  expect_handshake_refused(host_info("localhost"), "has no port");
  expect_handshake_refused(host_info("localhost:0"), "no usable port");
  expect_handshake_refused(host_info("localhost:65536"), "no usable port");
  expect_handshake_refused(host_info(":1"), "no usable host");
  expect_handshake_refused(host_info("a/b:1"), "no usable host");
}

TEST_F(HostileClient, Class3HostInfoWithoutAMemory) {
  expect_handshake_refused(with_bytes(host_info("localhost:1"), 24, "00"), "memor");
}

TEST_F(HostileClient, Class3CommandsInTheWrongState) {
  expect_handshake_refused(wire::test::golden_transfer_data(),
                           "does not complete the handshake: TRANSFER_DATA");
  expect_handshake_refused(wire::test::golden_capability(),
                           "does not complete the handshake: CAPABILITY");
  expect_handshake_refused(from_text("GET / HTTP/1.1\r\n\r\n"), "nnstreamer-edge message");
}

TEST_F(HostileClient, Class3ASecondHostInfoOpensNoConnection) {
  open();
  auto peer = connected(), other = client();
  peer.host_info("localhost:" + std::to_string(other.port()));
  peer.request({from_text("a")});
  respond_once();
  EXPECT_EQ(peer.response(), (std::vector<Bytes>{from_text("a")}));
  EXPECT_FALSE(other.is_called());
}

TEST_F(HostileClient, Class3AnswersBeforeTheGreeting) {
  auto made = QueryListener::open({.host = "localhost", .refused = [this](const Error& error) {
                                     const std::lock_guard lock(mutex_);
                                     reasons_ += error.message();
                                   }});
  ASSERT_TRUE(made);
  listener_ = *std::move(made);
  listener_->set_accepting(true);
  auto peer = client();
  peer.host_info();
  peer.a.rest();
  EXPECT_TRUE(is_refused("it sent HOST_INFO before the server sent CAPABILITY"));
}

TEST_F(HostileClient, Class4MetadataThatIsNotItsPairs) {
  expect_request_refused(with_metadata(from_hex("02 00 00 00 61 00 62 00")), "metadata");
  expect_request_refused(with_metadata(from_hex("00 00 00 00 61 00 62 00")), "metadata");
  expect_request_refused(with_metadata(from_hex("ff ff ff ff 61 00 62 00")), "metadata");
  expect_request_refused(with_metadata(from_hex("01 00 00 00 61 00 62")), "metadata");
  expect_request_refused(with_metadata(from_hex("01 00 00")), "metadata");
}

TEST_F(HostileClient, Class4RepeatedAndEmptyKeys) {
  expect_request_refused(with_metadata(from_hex("02 00 00 00 61 00 62 00 41 00 63 00")),
                         "metadata");
  expect_request_refused(with_metadata(from_hex("01 00 00 00 00 62 00")), "metadata");
  expect_request_refused(with_metadata(from_hex("01 00 00 00 61 00 00")), "metadata");
}

TEST_F(HostileClient, Class5ResponsesForAnotherMachineAreRefused) {
  expect_handshake_refused(host_info("192.0.2.1:80"),
                           "a client requests its answers at another machine");
  EXPECT_SAYS(reasons(), "192.0.2.1:80 from a connection of 127.0.0.1");
}

TEST_F(HostileClient, Class5NamesAreNotLookedUp) {
  open();
  auto peer = client();
  peer.greeting();
  peer.host_info("some.other.machine:" + std::to_string(peer.port()));
  peer.accept();
  peer.request({from_text("a")});
  respond_once();
  EXPECT_EQ(peer.response(), (std::vector<Bytes>{from_text("a")}));
}

TEST_F(HostileClient, Class5OtherAddressesThatAreAllowedAreUsed) {
  std::atomic<int> asked{0};
  open({.client = {.allows_callback = [&](const std::string& address) {
          ++asked;
          return address == "192.0.2.1";
        }}});
  auto peer = client();
  peer.greeting();
  peer.host_info("192.0.2.1:80");  // an address of no machine
  peer.a.rest();
  EXPECT_TRUE(is_refused("listener cannot be reached"));
  EXPECT_EQ(asked, 1);
}

TEST_F(HostileClient, Class5APortWithoutAListenerIsRefused) {
  open();
  auto peer = client();
  peer.greeting();
  const auto text = "localhost:" + std::to_string(peer.port());
  peer.stop_listening();
  peer.host_info(text);
  EXPECT_EQ(peer.a.rest(), wire::test::golden_error());
  EXPECT_TRUE(is_refused("its own listener cannot be reached: Connection refused"));
  expect_service();
}

TEST_F(HostileClient, Class6ASilentPeerStallsNoOtherAndIsClosedAfter2Seconds) {
  std::vector<RawClient> silent;
  std::chrono::steady_clock::time_point began;
  const auto connect_silent = [&] {
    silent.clear();
    open({.max_clients = 8});
    began = std::chrono::steady_clock::now();
    for (int i = 0; i < 7; ++i) silent.push_back(client());
  };
  EXPECT_TRUE(is_quick(
      connect_silent, [this] { expect_service(); }, milliseconds(1500)));
  for (auto& peer : silent) peer.a.rest();
  EXPECT_GE(std::chrono::steady_clock::now() - began, milliseconds(1500));
  EXPECT_TRUE(is_refused("it does not complete the handshake within 2 s"));
}

TEST_F(HostileClient, Class6APeerThatSendsSlowlyIsClosedToo) {
  open();
  auto peer = client();
  peer.greeting();
  peer.a.send(start_of(host_info("localhost:1"), 40));
  expect_refused(peer, "it does not complete the handshake within 2 s");
}

TEST_F(HostileClient, Class6AFloodOfMessagesStallsNoOtherAndNoStop) {
  open();
  const auto peer = connected();
  ASSERT_TRUE(clients_become(1));
  const Flood requests(peer.a.get()), responses(peer.b.get());
  requests.wait_until_it_runs();
  responses.wait_until_it_runs();
  for (int i = 0; i < 3; ++i) expect_service();
  listener_->stop();
}

// Clients that are silent after the handshake keep their places only while no other wants them.
TEST_F(HostileClient, Class6SilentClientsDoNotHoldAllPlaces) {
  open({.client = {.timeout = milliseconds(1500)}, .max_clients = 3});
  auto honest = connected(), silent = connected(), busy = connected();
  ASSERT_TRUE(clients_become(3));
  honest.request({from_text("a")});  // the silent one is silent for longer
  respond_once();
  honest.response();
  busy.request({from_text("b")});
  const auto request = listener_->take();
  const auto is_served = [&] {
    const Bytes refused = wire::test::golden_error();
    const Bytes first = client().a.receive(refused.size());
    return first.size() == refused.size() && first != refused;
  };
  ASSERT_TRUE(becomes_true(is_served, "a place for another client"));
  silent.a.rest();
  EXPECT_TRUE(is_refused("it was silent for 1500 ms (property timeout), and another client came"));
  EXPECT_EQ(respond(request), Sent::Queued);
  EXPECT_EQ(busy.response(), (std::vector<Bytes>{from_text("b")}));
  honest.request({from_text("a")});
  respond_once();
  honest.response();
}

TEST_F(HostileClient, Class6ClientsThatAskKeepTheirPlaces) {
  open({.client = {.timeout = kTimeout}, .max_clients = 1});
  auto first = connected();
  first.request({from_text("a")});
  const auto request = listener_->take();
  expect_places_kept(1);
  EXPECT_EQ(respond(request), Sent::Queued);
  EXPECT_EQ(first.response(), (std::vector<Bytes>{from_text("a")}));
}

// An address of this machine that others reach, which the limit for one address holds for.
std::string find_own_address() {
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return "";
  std::string out;
  for (const ifaddrs* at = all; at; at = at->ifa_next) {
    if (!at->ifa_addr || at->ifa_addr->sa_family != AF_INET || (at->ifa_flags & IFF_LOOPBACK))
      continue;
    char text[INET_ADDRSTRLEN] = "";
    inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(at->ifa_addr)->sin_addr, text,
              sizeof text);
    out = text;
  }
  freeifaddrs(all);
  return out;
}

// One that comes and finds no place for its address takes none from a client of another one.
TEST_F(HostileClient, Class6OneThatIsRefusedSendsNoSilentClientAway) {
  const std::string host = find_own_address();
  if (host.empty()) GTEST_SKIP() << "this machine has only loopback addresses";
  open(
      {.host = "0.0.0.0", .client = {.timeout = kTimeout}, .max_clients = 3, .max_per_address = 2});
  const auto connect = [&] { return RawClient(listener_->port(), HeaderForm::Bytes2088, host); };
  auto silent = connected();
  std::vector<RawClient> busy;
  std::vector<std::shared_ptr<Request>> requests;
  for (int i = 0; i < 2; ++i) {
    busy.push_back(connect());
    busy.back().connect();
    busy.back().request({from_text("a")});
    requests.push_back(listener_->take());
  }
  ASSERT_TRUE(clients_become(3));
  const auto end = std::chrono::steady_clock::now() + 3 * kTimeout;
  while (std::chrono::steady_clock::now() < end) connect().a.rest();
  EXPECT_TRUE(is_refused("3 clients are already connected (property max-connections)"));
  EXPECT_EQ(listener_->counts().clients, 3u);
  silent.request({from_text("b")});
  respond_once();
  EXPECT_EQ(silent.response(), (std::vector<Bytes>{from_text("b")}));
}

// Because the requests of its address have too many bytes.
TEST_F(HostileClient, Class6AClientThatIsNotReadKeepsItsPlace) {
  open({.client = {.timeout = kTimeout}, .max_address_bytes = 1000, .max_clients = 2});
  auto first = connected();
  first.request({Bytes(2000)});
  auto request = listener_->take();
  auto second = connected();
  ASSERT_TRUE(clients_become(2));
  second.request({from_text("b")});
  expect_places_kept(2);
  EXPECT_EQ(respond(request), Sent::Queued);
  EXPECT_EQ(first.response()[0].size(), 2000u);
  request = nullptr;  // its bytes are free
  respond_once();
  EXPECT_EQ(second.response(), (std::vector<Bytes>{from_text("b")}));
}

TEST_F(HostileClient, Class6ClientsWaitForTheCapsOnlySoLong) {
  auto made = QueryListener::open({.host = "localhost",
                                   .client = {.timeout = milliseconds(100)},
                                   .refused = [this](const Error& error) {
                                     const std::lock_guard lock(mutex_);
                                     reasons_ += error.message();
                                   }});
  ASSERT_TRUE(made);
  listener_ = *std::move(made);
  listener_->set_accepting(true);
  auto peer = client();
  peer.a.rest();
  EXPECT_TRUE(is_refused("the caps of the answers are not known within 100 ms (property timeout)"));
}

TEST_F(HostileClient, Class7APeerThatDoesNotReadStallsNoOtherAndIsRemoved) {
  open({.client = {.timeout = milliseconds(2000)}});
  auto slow = connected();
  slow.request({from_text("a")});
  const auto owner = std::make_shared<Bytes>(32 << 20);
  EXPECT_EQ(listener_->respond(listener_->take()->client(), {*owner}, owner, ""), Sent::Queued);
  expect_service();
  slow.request({from_text("more")});
  respond_once();  // waits in the queue
  expect_service();
  EXPECT_TRUE(is_refused("it did not read its answers for 2000 ms (property timeout)"));
  EXPECT_TRUE(clients_become(0));
}

TEST_F(HostileClient, Class7AQueueThatIsFullLosesResponses) {
  open({.client = {.responses = {.frames = 1}}, .max_requests = 0});
  auto slow = connected();
  slow.request({Bytes(32 << 20)});
  respond_once();
  slow.request({from_text("more")});
  EXPECT_EQ(respond(listener_->take()), Sent::Full);
  EXPECT_EQ(listener_->counts().answers_lost, 1u);
  EXPECT_EQ(slow.response()[0].size(), size_t{32} << 20);
}

TEST_F(HostileClient, Class8IdsAreRandomAndUnique) {
  open({.max_clients = 0});
  std::set<int64_t> ids;
  int64_t bits = 0;
  for (int i = 0; i < 64; ++i) {
    auto peer = client();
    peer.greeting();
    EXPECT_GE(peer.id, 0);
    EXPECT_LT(peer.id, int64_t{1} << 62);
    ids.insert(peer.id);
    bits |= peer.id;
  }
  EXPECT_EQ(ids.size(), 64u);
  EXPECT_EQ(bits, (int64_t{1} << 62) - 1);  // each bit is set in one of them
}

// The id in a frame is a copy that a client can change.
TEST_F(HostileClient, Class8TheIdInAFrameIsIgnored) {
  open();
  auto victim = connected(), thief = connected();
  const int64_t own = thief.id;
  thief.id = victim.id;
  thief.request({from_text("a")});
  const auto request = listener_->take();
  EXPECT_EQ(request->client(), own);
  EXPECT_EQ(respond(request), Sent::Queued);
  EXPECT_EQ(thief.response(), (std::vector<Bytes>{from_text("a")}));
}

TEST_F(HostileClient, Class10ClientsLeaveWhileResponsesAreSent) {
  open();
  for (int i = 0; i < 20; ++i) {
    auto peer = connected();
    peer.request({Bytes(4 << 20)});
    const auto request = listener_->take();
    std::thread leaver([&] { peer.close(); });
    respond(request);
    leaver.join();
  }
  EXPECT_TRUE(clients_become(0));
  expect_service();
}

TEST_F(HostileClient, Class10StopsWhileResponsesAreSent) {
  for (int i = 0; i < 10; ++i) {
    open();
    auto peer = connected();
    peer.request({Bytes(4 << 20)});
    respond_once();
    listener_->stop();
    peer.b.rest();
  }
}

TEST_F(HostileClient, Class12AResponseWithAnEmptyMemoryIsNotSent) {
  open();
  auto peer = connected();
  peer.request({from_text("a")});
  const auto request = listener_->take();
  EXPECT_EQ(listener_->respond(request->client(), {std::span<const std::byte>()}, nullptr, ""),
            Sent::NoClient);
  EXPECT_EQ(peer.b.rest(), wire::test::golden_error());
  EXPECT_TRUE(is_refused("a memory of 0 bytes"));
  expect_service();
}

// An older client cannot receive what the newer ones can: only its connection ends.
TEST_F(HostileClient, Class12MoreMemoriesThanAFormHas) {
  open();
  auto newer = connected(), older = connected(HeaderForm::Bytes168);
  ASSERT_TRUE(clients_become(2));
  const Bytes byte(1);
  const std::vector<std::span<const std::byte>> memories(16, byte);
  EXPECT_EQ(listener_->respond(newer.id, memories, nullptr, ""), Sent::Queued);
  EXPECT_EQ(newer.response().size(), 16u);
  EXPECT_EQ(listener_->respond(older.id, memories, nullptr, ""), Sent::NoClient);
  EXPECT_TRUE(is_refused("more memories than the peer can receive: 16 memories"));
  EXPECT_EQ(listener_->counts().answers_lost, 1u);
}

}  // namespace hostile_client_test
}  // namespace weir::edge::test
