// Query clients at a listener: handshake, requests and responses, limits, and clients that leave.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <set>
#include <thread>

#include "transport/edge/query_client_test_support.hpp"

namespace weir::edge::test {
namespace query_listener_test {

using Sent = QueryListener::Sent;

// docs/compatibility/edge-wire.md 10.7, with the text at offset 168 too, and the id of the client.
TEST_F(EdgeQuery, GreetsWithTheBytesOfTheProtocol) {
  open();
  auto peer = client();
  Bytes expected = wire::test::golden_capability();
  const Bytes text = from_text(wire::test::kCapabilityText);
  std::copy(text.begin(), text.end(), expected.begin() + 168);
  const Bytes greeting = peer.a.receive(expected.size());
  ASSERT_EQ(greeting.size(), expected.size());
  std::copy(greeting.begin() + 16, greeting.begin() + 24, expected.begin() + 16);
  EXPECT_EQ(greeting, expected);
}

TEST_F(EdgeQuery, AnswersWithTheBytesOfTheProtocol) {
  open();
  auto peer = connected();
  peer.request({from_text("xyz"), from_hex("01 02 03 04")});
  respond_once();
  Bytes expected = wire::test::golden_transfer_data();
  expected.resize(2088 + 7);
  const std::string id = std::to_string(peer.id);
  expected = expected + from_hex("01 00 00 00") + from_text("client_id") + from_hex("00") +
             from_text(id) + from_hex("00");
  expected[2080] = static_cast<std::byte>(4 + 10 + id.size() + 1);
  const Bytes sent = peer.b.receive(expected.size());
  ASSERT_EQ(sent.size(), expected.size());
  std::copy(sent.begin() + 16, sent.begin() + 24, expected.begin() + 16);
  EXPECT_EQ(sent, expected);
}

TEST_F(EdgeQuery, ServesBothNewerFormsAtOnce) {
  open();
  auto newer = connected(HeaderForm::Bytes2088), older = connected(HeaderForm::Bytes168);
  for (auto* peer : {&older, &newer}) {
    peer->request({from_text("ab"), Bytes(300'000)});
    respond_once();
    EXPECT_EQ(peer->response(), (std::vector<Bytes>{Bytes(300'000), from_text("ab")}));
  }
}

TEST_F(EdgeQuery, ServesTheOldestFormWhenAsked) {
  open({.client = {.form = HeaderForm::Bytes160}});
  auto peer = client(HeaderForm::Bytes160);
  EXPECT_EQ(peer.greeting(), wire::test::kCapabilityText);
  peer.host_info();
  peer.accept();
  peer.request({from_text("ab"), from_text("c")});
  respond_once();
  EXPECT_EQ(peer.response(), (std::vector<Bytes>{from_text("c"), from_text("ab")}));
}

TEST_F(EdgeQuery, NamesThePropertyForTheOldestForm) {
  open();
  auto peer = client();
  peer.greeting();
  const auto text = wire::text_message(HeaderForm::Bytes160, wire::Command::HostInfo, 0, "h:1");
  peer.a.send(*text);
  EXPECT_TRUE(is_refused("wire-version=0.2.2"));
}

TEST_F(EdgeQuery, TheNumberOfARequestOfWeirComesBack) {
  open();
  auto peer = connected();
  peer.request({from_text("a")}, "41");
  respond_once();
  peer.response();
  const auto metadata = wire::EdgeMetadata::parse(peer.last_response.metadata.bytes());
  ASSERT_TRUE(metadata);
  EXPECT_EQ(metadata->find("weir.seq"), "41");
  EXPECT_EQ(metadata->find("client_id"), std::to_string(peer.id));
}

TEST_F(EdgeQuery, EachClientGetsItsOwnResponses) {
  open();
  auto one = connected(), two = connected();
  EXPECT_NE(one.id, two.id);
  EXPECT_GT(std::min(one.id, two.id), 0);
  one.request({from_text("first")});
  const auto first = listener_->take();
  two.request({from_text("second")});
  const auto second = listener_->take();
  EXPECT_EQ(first->client(), one.id);
  EXPECT_EQ(second->client(), two.id);
  EXPECT_EQ(respond(second), Sent::Queued);
  EXPECT_EQ(respond(first), Sent::Queued);
  EXPECT_EQ(one.response(), (std::vector<Bytes>{from_text("first")}));
  EXPECT_EQ(two.response(), (std::vector<Bytes>{from_text("second")}));
}

TEST_F(EdgeQuery, GreetsWhenBothCapsAreKnown) {
  auto made = QueryListener::open({.host = "localhost"});
  ASSERT_TRUE(made);
  listener_ = *std::move(made);
  listener_->set_accepting(true);
  auto early = client();
  ASSERT_TRUE(listener_->set_response_caps("B"));
  pollfd watched{early.a.get(), POLLIN, 0};
  EXPECT_EQ(poll(&watched, 1, 0), 0);
  ASSERT_TRUE(listener_->set_request_caps("A"));
  EXPECT_EQ(early.greeting(), wire::test::kCapabilityText);
}

TEST_F(EdgeQuery, GreetsWithExpectedCapsUntilOthersAreKnown) {
  auto made = QueryListener::open({.host = "localhost"});
  ASSERT_TRUE(made);
  listener_ = *std::move(made);
  listener_->set_accepting(true);
  ASSERT_TRUE(listener_->set_request_caps("A"));
  ASSERT_TRUE(listener_->expect_response_caps("B"));
  EXPECT_EQ(client().greeting(), wire::test::kCapabilityText);
  ASSERT_TRUE(listener_->set_response_caps("C"));
  ASSERT_TRUE(listener_->expect_response_caps("B"));
  EXPECT_NE(client().greeting(), wire::test::kCapabilityText);
}

TEST_F(EdgeQuery, CapsThatThePeerCouldNotSeparateAreAnError) {
  open();
  const auto status = listener_->set_response_caps("a@b");
  ASSERT_FALSE(status);
  EXPECT_SAYS(status.error().message(), "@");
  const auto long_status = listener_->set_response_caps(std::string(70'000, 'x'));
  ASSERT_FALSE(long_status);
  EXPECT_EQ(long_status.error().code, Code::LIMIT_EXCEEDED);
}

TEST_F(EdgeQuery, ClientsWaitUntilTheyAreAccepted) {
  open();
  listener_->set_accepting(false);
  auto early = client();
  EXPECT_EQ(listener_->counts().clients, 0u);
  listener_->set_accepting(true);
  early.connect();
  EXPECT_TRUE(clients_become(1));
}

TEST_F(EdgeQuery, ClosesItsClientsWithAnErrorWhenItPauses) {
  open();
  auto peer = connected();
  ASSERT_TRUE(clients_become(1));
  listener_->set_accepting(false);
  EXPECT_EQ(peer.b.rest(), wire::test::golden_error());
  EXPECT_EQ(peer.a.rest(), wire::test::golden_error());
  listener_->set_accepting(true);
  expect_service();
}

TEST_F(EdgeQuery, SendsWhatIsQueuedBeforeItStops) {
  open();
  auto peer = connected();
  peer.request({Bytes(8 << 20)});
  respond_once();
  std::thread reader([&] { EXPECT_EQ(peer.response()[0].size(), size_t{8} << 20); });
  EXPECT_TRUE(listener_->flush(io::deadline_in(kTestTime)));
  listener_->stop();
  reader.join();
  EXPECT_EQ(listener_->requests().answered, 1u);
}

TEST_F(EdgeQuery, StopsInEveryState) {
  open();
  auto waiting = client(), greeted = client(), ready = connected();
  greeted.greeting();
  ready.request({from_text("a")});
  auto request = listener_->take();
  listener_->stop();
  listener_->stop();
  ready.a.rest();
  greeted.a.rest();
  waiting.a.rest();
  EXPECT_EQ(respond(request), Sent::NoClient);
  request.reset();
  EXPECT_EQ(listener_->requests().expired, 1u);
  EXPECT_FALSE(connect_to("localhost", listener_->port(), io::deadline_in(kTestTime), -1));
}

TEST_F(EdgeQuery, TakingEndsWhenInterrupted) {
  open();
  std::thread taker([&] { EXPECT_FALSE(listener_->take()); });
  listener_->interrupt();
  taker.join();
  EXPECT_FALSE(listener_->take());
  listener_->resume();
  expect_service();
}

TEST_F(EdgeQuery, CountsWhatThePipelineDropped) {
  open();
  auto peer = connected();
  peer.request({from_text("a")});
  listener_->take().reset();
  EXPECT_EQ(listener_->requests().received, 1u);
  EXPECT_EQ(listener_->requests().aborted, 1u);
}

// A client that is killed closes its sockets.
TEST_F(EdgeQuery, TheResponseForAClientThatLeftIsDroppedAndCounted) {
  open();
  auto peer = connected();
  peer.request({from_text("a")});
  auto request = listener_->take();
  peer.request({from_text("waits")});
  peer.close();
  ASSERT_TRUE(clients_become(0));
  EXPECT_TRUE(request->end_if_expired());
  EXPECT_EQ(respond(request), Sent::NoClient);
  request.reset();
  EXPECT_EQ(listener_->counts().answers_lost, 1u);
  expect_service();
  const auto& counts = listener_->requests();
  EXPECT_EQ(counts.received, counts.expired + counts.answered);
  EXPECT_EQ(counts.answered, 1u);
}

TEST_F(EdgeQuery, AClientThatSaysThatItClosesIsGone) {
  open();
  auto one = connected(), two = connected();
  one.a.send(wire::test::golden_error());
  ASSERT_TRUE(clients_become(1));
  two.b.send(wire::test::golden_error());
  ASSERT_TRUE(clients_become(0));
  EXPECT_EQ(listener_->counts().clients_refused, 0u);
}

TEST_F(EdgeQuery, AClientWithManyRequestsIsNotReadOn) {
  open({.max_requests = 3});
  auto eager = connected(), other = connected();
  for (int i = 0; i < 5; ++i) eager.request({from_text(std::to_string(i))});
  std::vector<std::shared_ptr<Request>> taken;
  for (int i = 0; i < 3; ++i) taken.push_back(listener_->take());
  other.request({from_text("other")});
  const auto next = listener_->take();
  EXPECT_EQ(next->client(), other.id);
  EXPECT_EQ(respond(next), Sent::Queued);
  EXPECT_EQ(other.response(), (std::vector<Bytes>{from_text("other")}));
  EXPECT_EQ(listener_->counts().requests_waiting, 0u);
  EXPECT_EQ(listener_->requests().received, 4u);
  for (const auto& request : taken) EXPECT_EQ(respond(request), Sent::Queued);
  taken.clear();
  respond_once();
  respond_once();
  for (int i = 0; i < 5; ++i)
    EXPECT_EQ(eager.response(), (std::vector<Bytes>{from_text(std::to_string(i))}));
}

TEST_F(EdgeQuery, AnAddressWithManyBytesIsNotReadOn) {
  open({.max_requests = 0, .max_address_bytes = 3000});
  auto one = connected(), two = connected();
  one.request({Bytes(2000)});
  two.request({Bytes(2000)});
  auto first = listener_->take(), second = listener_->take();
  one.request({Bytes(2000)});
  two.request({Bytes(2000)});
  std::this_thread::yield();
  EXPECT_EQ(listener_->requests().received, 2u);
  EXPECT_EQ(respond(first), Sent::Queued);
  first.reset();
  second.reset();
  respond_once();
  respond_once();
  EXPECT_EQ(one.response()[0].size(), 2000u);
}

TEST_F(EdgeQuery, MoreClientsThanAllowedAreRefused) {
  open({.max_clients = 2});
  auto one = connected(), two = connected();
  auto three = client();
  EXPECT_EQ(three.a.rest(), wire::test::golden_error());
  EXPECT_TRUE(is_refused("2 clients are already connected (property max-connections)"));
  one.close();
  ASSERT_TRUE(clients_become(1));
  expect_service();
}

TEST_F(EdgeQuery, AddressesThatAreNotAllowedAreRefused) {
  open({.allowed = [](const std::string& address) { return address != "127.0.0.1"; }});
  auto peer = client();
  peer.a.rest();
  EXPECT_TRUE(is_refused("127.0.0.1: the property allow does not contain its address"));
}

TEST_F(EdgeQuery, AStormOf100ClientsIsServed) {
  open({.max_clients = 100});
  std::vector<std::thread> threads;
  std::atomic<int> right{0};
  std::thread server([&] {
    while (const auto request = listener_->take()) respond(request);
  });
  for (int i = 0; i < 100; ++i)
    threads.emplace_back([&, i] {
      auto peer = connected();
      for (int k = 0; k < 10; ++k) {
        const Bytes sent = from_text(std::to_string(i) + "." + std::to_string(k));
        peer.request({sent});
        right += peer.response() == std::vector<Bytes>{sent};
      }
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(right, 1000);
  EXPECT_TRUE(clients_become(0));
  listener_->interrupt();
  server.join();
  EXPECT_EQ(listener_->requests().answered, 1000u);
}

TEST_F(EdgeQuery, AnAddressThatIsTakenIsNamed) {
  open();
  const auto second = QueryListener::open({.host = "localhost", .port = listener_->port()});
  ASSERT_FALSE(second);
  EXPECT_SAYS(second.error().message(), "localhost:" + std::to_string(listener_->port()));
  EXPECT_SAYS(second.error().message(), "in use");
}

}  // namespace query_listener_test
}  // namespace weir::edge::test
