// What a server does with calls, without a network: messages, checks, queues, the end of every
// call.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <cstring>
#include <thread>

#include "becomes.hpp"
#include "net/protocol/oip_contents.hpp"
#include "net/protocol/oip_service_messages.hpp"
#include "net/server/served_model.hpp"
#include "net/server/server_security.hpp"
#include "net/server/test_call.hpp"
#include "says.hpp"

namespace weir::net {
namespace server_test {

using namespace std::chrono_literals;

// A request for the model m with the input x of two FP32.
std::string message(const std::string& raw = std::string(8, 'a'), const std::string& type = "FP32",
                    const std::string& shape = std::string("\1\2", 2)) {
  std::string tensor, out;
  put_bytes(&tensor, 1, "x");
  put_bytes(&tensor, 2, type);
  put_bytes(&tensor, 3, shape);
  put_bytes(&out, 1, "m");
  put_bytes(&out, 3, "seven");
  put_bytes(&out, 5, tensor);
  put_bytes(&out, 7, raw);
  return out;
}

// Returns the message with a second input, z.
std::string message_with_z() {
  std::string tensor, out = message();
  put_bytes(&tensor, 1, "z");
  put_bytes(&tensor, 2, "FP32");
  put_bytes(&tensor, 3, "\1");
  put_bytes(&out, 5, tensor);
  put_bytes(&out, 7, "bbbb");
  return out;
}

class Serving : public ::testing::Test {
 protected:
  Serving() { describe(); }
  void describe() {
    model_->set_inputs({{"x", "FP32", {1, 2}}});
    model_->set_outputs({{"y", "FP32", {1, 2}}});
  }
  std::shared_ptr<TestCall> receive(Ended* ended, const std::string& text = message()) {
    auto call = std::make_shared<TestCall>(ended, text);
    auto request = parse_infer_request(call->request());
    EXPECT_TRUE(request);
    if (request) model_->receive(call, *request);
    return call;
  }
  void expect_counts(const ServedCounts& wanted) {
    const auto counts = model_->counts();
    EXPECT_EQ(counts.received, wanted.received);
    EXPECT_EQ(counts.answered, wanted.answered);
    EXPECT_EQ(counts.refused, wanted.refused);
    EXPECT_EQ(counts.expired, wanted.expired);
    EXPECT_EQ(counts.aborted, wanted.aborted);
    EXPECT_EQ(counts.in_flight, wanted.in_flight);
  }
  static bool respond(const std::shared_ptr<ServedRequest>& request) {
    static const int64_t shape[] = {1, 2};
    static const float values[] = {3, 4};
    return request->respond({{"y", "FP32", shape, std::as_bytes(std::span(values))}}, nullptr);
  }

  std::shared_ptr<ServedModel> model_ =
      std::make_shared<ServedModel>(ModelRequest{"m", "1"}, "weir", 2);
};

TEST_F(Serving, AnswersWithTheIdAndTheBytes) {
  Ended ended;
  receive(&ended);
  const auto request = model_->take();
  ASSERT_TRUE(request);
  std::array<std::byte, 8> elements{};
  EXPECT_TRUE(request->read_input(0, elements));
  EXPECT_EQ(std::memcmp(elements.data(), "aaaaaaaa", 8), 0);
  EXPECT_TRUE(respond(request));
  EXPECT_EQ(ended.times, 1);
  EXPECT_EQ(ended.status, 0);
  const std::string bytes = ended.text;
  const Chunks chunks({std::as_bytes(std::span(bytes))});
  const auto response = parse_infer_response(chunks);
  ASSERT_TRUE(response);
  EXPECT_EQ(response->outputs.at(0).name, "y");
  EXPECT_EQ(response->outputs.at(0).shape, (std::vector<int64_t>{1, 2}));
  EXPECT_NE(bytes.find("seven"), std::string::npos);
  float values[2];
  EXPECT_TRUE(read_elements(chunks, response->outputs[0], std::as_writable_bytes(std::span(values)),
                            Sender::Server));
  EXPECT_EQ(values[1], 4);
  expect_counts({.received = 1, .answered = 1});
}

TEST_F(Serving, EndsEachRequestOnce) {
  Ended ended;
  receive(&ended);
  auto request = model_->take();
  EXPECT_TRUE(respond(request));
  EXPECT_FALSE(respond(request));
  EXPECT_FALSE(request->fail(CallStatus::Internal, "late"));
  model_->stop();
  request.reset();
  EXPECT_EQ(ended.times, 1);
  EXPECT_EQ(ended.status, 0);
}

TEST_F(Serving, AbortsWhatIsDroppedAndNamesTheElement) {
  Ended first, second;
  receive(&first);
  receive(&second);
  model_->take()->entered("valve0");
  EXPECT_EQ(first.status, static_cast<int>(CallStatus::Aborted));
  EXPECT_EQ(first.text, "dropped by valve0");
  model_->take();
  EXPECT_EQ(second.text, "dropped before it entered the pipeline");
  expect_counts({.received = 2, .aborted = 2});
}

TEST_F(Serving, CallsItAStopWhenElementsDropInAPipelineThatDoesNotRun) {
  Ended ended;
  receive(&ended);
  auto request = model_->take();
  request->entered("queue0");
  model_->set_running(false);
  request.reset();
  EXPECT_EQ(ended.status, static_cast<int>(CallStatus::Unavailable));
  EXPECT_EQ(ended.text, "the pipeline of the model m was stopped");
}

TEST_F(Serving, RefusesWhatAFullQueueCannotTake) {
  Ended ended[3];
  for (auto& end : ended) receive(&end);
  EXPECT_EQ(ended[0].times, 0);
  EXPECT_EQ(ended[2].status, static_cast<int>(CallStatus::ResourceExhausted));
  EXPECT_SAYS(ended[2].text, "2 requests wait for the model m (queue)");
  expect_counts({.received = 3, .refused = 1, .in_flight = 2});
  model_->stop();
}

TEST_F(Serving, MakesRoomForARequestByThoseThatExpired) {
  Ended ended[3];
  receive(&ended[0])->is_cancelled = true;
  receive(&ended[1])->expires_at(Call::Clock::now() - 1ms);
  receive(&ended[2]);
  EXPECT_EQ(ended[0].status, static_cast<int>(CallStatus::Cancelled));
  EXPECT_EQ(ended[1].status, static_cast<int>(CallStatus::DeadlineExceeded));
  EXPECT_EQ(ended[2].times, 0);
  expect_counts({.received = 3, .expired = 2, .in_flight = 1});
  model_->stop();
}

TEST_F(Serving, SkipsExpiredRequests) {
  Ended ended[2];
  receive(&ended[0])->expires_at(Call::Clock::now() - 1ms);
  receive(&ended[1]);
  EXPECT_TRUE(respond(model_->take()));
  EXPECT_EQ(ended[0].status, static_cast<int>(CallStatus::DeadlineExceeded));
  EXPECT_SAYS(ended[0].text, "the deadline passed");
  EXPECT_EQ(ended[1].status, 0);
}

TEST_F(Serving, EndsAllWhenItStops) {
  Ended waiting, running, late;
  receive(&running);
  const auto request = model_->take();
  receive(&waiting);
  model_->stop();
  receive(&late);
  for (const auto* ended : {&waiting, &running, &late}) {
    EXPECT_EQ(ended->times, 1);
    EXPECT_EQ(ended->status, static_cast<int>(CallStatus::Unavailable));
  }
  EXPECT_EQ(model_->take(), nullptr);
  EXPECT_FALSE(model_->ready());
  expect_counts({.received = 3, .refused = 1, .aborted = 2});
}

TEST_F(Serving, AnswersWhatWasTakenBeforeItClosed) {
  Ended taken, waiting, late;
  receive(&taken);
  const auto request = model_->take();
  receive(&waiting);
  model_->close();
  receive(&late);
  EXPECT_EQ(waiting.status, static_cast<int>(CallStatus::Unavailable));
  EXPECT_EQ(late.status, static_cast<int>(CallStatus::Unavailable));
  EXPECT_EQ(taken.times, 0);
  EXPECT_TRUE(respond(request));
  EXPECT_EQ(taken.status, 0);
}

TEST_F(Serving, IsReadyOnceBothEndsAreKnown) {
  const auto other = std::make_shared<ServedModel>(ModelRequest{"o", "1"}, "weir", 2);
  EXPECT_FALSE(other->ready());
  other->set_inputs({});
  EXPECT_FALSE(other->ready());
  other->set_outputs({});
  EXPECT_TRUE(other->ready());
}

TEST_F(Serving, IsReadyWithOutputsThatItExpects) {
  const auto other = std::make_shared<ServedModel>(ModelRequest{"o", "1"}, "weir", 2);
  other->set_inputs({});
  other->expect_outputs({{"y", "FP32", {1, 4}}});
  EXPECT_TRUE(other->ready());
  ASSERT_EQ(other->metadata().outputs.size(), 1u);
  other->set_outputs({});
  EXPECT_TRUE(other->metadata().outputs.empty());
  other->expect_outputs({{"y", "FP32", {1, 4}}});
  EXPECT_TRUE(other->metadata().outputs.empty());
}

TEST_F(Serving, RefusesWhileItIsUnloaded) {
  Ended before, between, after;
  receive(&before);
  model_->set_loaded(false);
  model_->set_loaded(false);
  EXPECT_FALSE(model_->ready());
  receive(&between);
  EXPECT_EQ(between.status, static_cast<int>(CallStatus::Unavailable));
  EXPECT_EQ(between.text, "the model m is unloaded");
  EXPECT_TRUE(respond(model_->take()));
  EXPECT_EQ(before.status, 0);
  model_->set_loaded(true);
  EXPECT_TRUE(model_->ready());
  receive(&after);
  EXPECT_TRUE(respond(model_->take()));
  EXPECT_EQ(after.status, 0);
}

TEST_F(Serving, RefusesWhatWaitedWhenTheInputsChange) {
  Ended before, after;
  receive(&before);
  model_->set_inputs({{"x", "FP32", {1, 2}}, {"z", "FP32", {1}}});
  receive(&after, message_with_z());
  const auto request = model_->take();
  std::array<std::byte, 4> second{};
  EXPECT_TRUE(request->read_input(1, second));
  EXPECT_EQ(std::memcmp(second.data(), "bbbb", 4), 0);
  EXPECT_TRUE(respond(request));
  EXPECT_EQ(before.status, static_cast<int>(CallStatus::InvalidArgument));
  EXPECT_SAYS(before.text,
              "WEIR-2001: the inputs of the model m changed while the request waited\n"
              "  offered: 1 inputs\n  needed: 2: x FP32 [1,2], z FP32 [1]");
  EXPECT_EQ(after.status, 0);
  expect_counts({.received = 2, .answered = 1, .refused = 1});
}

TEST_F(Serving, KeepsWhatWaitedWhenItStillFitsTheInputs) {
  Ended ended;
  receive(&ended);
  model_->set_inputs({{"x", "FP32", {1, 2}}, {"z", "FP32", {1}}});
  model_->set_inputs({{"x", "FP32", {2}}});
  const auto request = model_->take();
  std::array<std::byte, 8> elements{};
  EXPECT_TRUE(request->read_input(0, elements));
  EXPECT_TRUE(respond(request));
  EXPECT_EQ(ended.status, 0);
}

TEST_F(Serving, WakesTheThreadThatTakes) {
  std::atomic<bool> returned{false};
  std::thread taker([&] {
    EXPECT_EQ(model_->take(), nullptr);
    returned = true;
  });
  model_->interrupt();
  taker.join();
  EXPECT_TRUE(returned);
  model_->resume();
  Ended ended;
  std::thread other([&] { respond(model_->take()); });
  receive(&ended);
  other.join();
  EXPECT_EQ(ended.status, 0);
}

TEST_F(Serving, RefusesRequestsThatDoNotFitWithBothSides) {
  const struct {
    std::string text;
    const char *offered, *needed;
  } cases[] = {
      {message(std::string(8, 'a'), "INT32"), "x INT32 [1,2]", "x FP32 [1,2]"},
      {message(std::string(8, 'a'), "FP32", std::string("\2\2", 2)), "x FP32 [2,2]",
       "x FP32 [1,2]"},
      {message("abc"), "3 bytes for x FP32 [1,2]", "8 bytes for x FP32 [1,2]"},
  };
  for (const auto& c : cases) {
    Ended ended;
    receive(&ended, c.text);
    EXPECT_EQ(ended.status, static_cast<int>(CallStatus::InvalidArgument));
    EXPECT_SAYS(ended.text, "WEIR-2001: the request does not fit the model m");
    EXPECT_SAYS(ended.text, std::string("offered: ") + c.offered);
    EXPECT_SAYS(ended.text, std::string("needed: ") + c.needed);
  }
}

class ServingBytes : public Serving {
 protected:
  ServingBytes() { model_->set_inputs({{"x", "BYTES", {1}}}); }
  static std::string typed(const std::vector<std::string>& elements) {
    std::string contents, tensor, out;
    for (const auto& element : elements) put_bytes(&contents, 8, element);
    put_bytes(&tensor, 1, "x");
    put_bytes(&tensor, 2, "BYTES");
    put_bytes(&tensor, 3, "\1");
    put_bytes(&tensor, 5, contents);
    put_bytes(&out, 1, "m");
    put_bytes(&out, 5, tensor);
    return out;
  }
  static std::string raw(const std::string& bytes, const std::string& shape = "\1") {
    return message(bytes, "BYTES", shape);
  }
};

TEST_F(ServingBytes, ReadsOneElementRawAndTyped) {
  const std::string raw_three("\3\0\0\0abc", 7), raw_none("\0\0\0\0", 4);
  const struct {
    std::string text, wanted;
  } cases[] = {{typed({"abc"}), "abc"},
               {typed({""}), ""},
               {raw(raw_three), "abc"},
               {raw(raw_none), ""},
               {raw(raw_three, "\1\1"), "abc"}};
  for (const auto& c : cases) {
    Ended ended;
    receive(&ended, c.text);
    const auto request = ended.times == 0 ? model_->take() : nullptr;
    ASSERT_TRUE(request) << ended.text;
    std::string bytes(request->size_of_bytes(0), '?');
    request->copy_bytes(0, std::as_writable_bytes(std::span(bytes)));
    EXPECT_EQ(bytes, c.wanted);
    EXPECT_TRUE(respond(request));
  }
}

TEST_F(ServingBytes, RefusesOtherThanOneElement) {
  const std::string longer("\4\0\0\0abc", 7), shorter("\2\0\0\0abc", 7);
  for (const auto& text : {typed({}), typed({"a", "b"}), raw(longer), raw(shorter), raw("abc")}) {
    Ended ended;
    receive(&ended, text);
    EXPECT_EQ(ended.status, static_cast<int>(CallStatus::InvalidArgument));
    EXPECT_SAYS(ended.text, "offered: not exactly one BYTES element in x BYTES [1]");
  }
  Ended two, other_type;
  receive(&two, raw(std::string("\1\0\0\0a\1\0\0\0b", 10), "\2"));
  EXPECT_SAYS(two.text, "offered: x BYTES [2]");
  receive(&other_type);
  EXPECT_SAYS(other_type.text, "offered: x FP32 [1,2]");
}

TEST(ServiceMessages, RefuseDamagedRequests) {
  const std::string whole = message();
  for (size_t bytes = 1; bytes < whole.size(); ++bytes) {
    const std::string part = whole.substr(0, bytes);
    const Chunks chunks({std::as_bytes(std::span(part))});
    const auto request = parse_infer_request(chunks);
    if (request) continue;  // ends between two fields
    EXPECT_EQ(request.error().code, Code::PEER_MESSAGE_INVALID);
    EXPECT_SAYS(request.error().message(), "a client sent a request that cannot be used");
  }
  std::string many;
  for (int i = 0; i < 257; ++i) put_bytes(&many, 5, "");
  EXPECT_FALSE(parse_infer_request(Chunks({std::as_bytes(std::span(many))})));
}

TEST(ServerSecurity, DistinguishesThisMachineFromOthers) {
  for (const auto* host : {"localhost", "127.0.0.1", "127.1.2.3", "::1", "[::1]"})
    EXPECT_TRUE(is_local({.host = host, .unix_path = "", .security = {}})) << host;
  for (const auto* host :
       {"0.0.0.0", "::", "[::]", "10.0.0.1", "127.evil.example", "example.org", ""})
    EXPECT_FALSE(is_local({.host = host, .unix_path = "", .security = {}})) << host;
  EXPECT_TRUE(is_local({.host = "0.0.0.0", .unix_path = "/run/weir", .security = {}}));
  EXPECT_EQ(address_text({.host = "::1", .port = 5, .unix_path = "", .security = {}}), "[::1]:5");
}

TEST(HeaderTexts, HaveATraceOnlyInTheFormOfTraceContext) {
  const std::string trace = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01";
  EXPECT_TRUE(is_trace_parent(trace));
  for (size_t i = 0; i < trace.size(); ++i)
    for (const char wrong : {'g', 'A', ' ', '\0', '\x7f', '\x80'}) {
      std::string other = trace;
      other[i] = wrong;
      EXPECT_FALSE(is_trace_parent(other)) << other;
    }
  EXPECT_FALSE(is_trace_parent(""));
  EXPECT_FALSE(is_trace_parent(trace + "-00"));
  EXPECT_FALSE(is_trace_parent(trace.substr(1)));
}

}  // namespace server_test
}  // namespace weir::net
