// The queues between peers and an element, without a network: who waits, what is dropped, how it
// ends.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <thread>

#include "becomes.hpp"
#include "net/tensor_service/incoming_frames.hpp"
#include "net/tensor_service/outgoing_frames.hpp"
#include "says.hpp"

namespace weir::net {
namespace frames_test {

using namespace std::chrono_literals;
using Outcome = OutgoingFrames::Outcome;

// A peer that records what is written, one message at a time.
struct TestReader final : OutgoingStream {
  void write(const OutgoingMessage& message) override {
    EXPECT_FALSE(writing) << "two writes at a time";
    writing = true;
    texts.emplace_back(reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size());
  }
  void end() override { ended = true; }
  void reads(OutgoingFrames* frames) {
    writing = false;
    frames->written(this);
  }
  std::vector<std::string> texts;
  bool writing = false, ended = false;
};

OutgoingMessage message(const std::string& text) {
  const auto memory = std::make_shared<std::string>(text);
  return {std::as_bytes(std::span(*memory)), memory};
}

using Texts = std::vector<std::string>;

TEST(OutgoingFrames, WritesOneMessageAtATimeInOrder) {
  OutgoingFrames frames({.queue = 4, .waits = true, .keeps = false});
  TestReader reader;
  EXPECT_TRUE(frames.join(&reader));
  for (const char* text : {"a", "b", "c"}) EXPECT_EQ(frames.send(message(text)), Outcome::Queued);
  EXPECT_EQ(reader.texts, Texts({"a"}));
  reader.reads(&frames);
  reader.reads(&frames);
  reader.reads(&frames);
  EXPECT_EQ(reader.texts, Texts({"a", "b", "c"}));
  EXPECT_EQ(frames.counts().sent, 3u);
  frames.leave(&reader);
  EXPECT_EQ(frames.counts().lost, 0u);
}

TEST(OutgoingFrames, APeerThatDoesNotReadDoesNotStopTheOthers) {
  OutgoingFrames frames({.queue = 2, .waits = true, .keeps = false});
  TestReader still, good;
  frames.join(&still);
  frames.join(&good);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(frames.send(message("x")), Outcome::Queued);
    good.reads(&frames);
  }
  EXPECT_EQ(good.texts.size(), 10u);
  EXPECT_EQ(frames.counts().dropped, 7u) << "one is being written, two wait";
  frames.leave(&still);
  EXPECT_EQ(frames.counts().lost, 3u);
  frames.leave(&good);
}

TEST(OutgoingFrames, WithoutWaitingDropsWhatNoPeerHasRoomFor) {
  OutgoingFrames frames({.queue = 1, .waits = false, .keeps = false});
  EXPECT_EQ(frames.send(message("no peer")), Outcome::Dropped);
  TestReader reader;
  frames.join(&reader);
  EXPECT_EQ(frames.send(message("a")), Outcome::Queued);
  EXPECT_EQ(frames.send(message("b")), Outcome::Queued);
  EXPECT_EQ(frames.send(message("c")), Outcome::Dropped);
  EXPECT_EQ(reader.texts, Texts({"a"}));
  frames.leave(&reader);
}

TEST(OutgoingFrames, WaitsForTheFirstPeer) {
  OutgoingFrames frames({.queue = 1, .waits = true, .keeps = false});
  TestReader reader;
  std::thread sender([&] { EXPECT_EQ(frames.send(message("a")), Outcome::Queued); });
  frames.join(&reader);
  sender.join();
  EXPECT_EQ(reader.texts, Texts({"a"}));
  frames.leave(&reader);
}

TEST(OutgoingFrames, AnInterruptEndsTheWait) {
  OutgoingFrames frames({.queue = 1, .waits = true, .keeps = false});
  std::thread sender([&] { EXPECT_EQ(frames.send(message("a")), Outcome::Interrupted); });
  frames.interrupt();
  sender.join();
  frames.resume();
}

TEST(OutgoingFrames, KeepsWhatWaitsForItsServer) {
  OutgoingFrames frames({.queue = 4, .waits = true, .keeps = true});
  for (const char* text : {"a", "b", "c"}) EXPECT_EQ(frames.send(message(text)), Outcome::Queued);
  TestReader first, second;
  frames.join(&first);
  EXPECT_TRUE(frames.leave(&first)) << "a is being written";
  frames.join(&second);
  second.reads(&frames);
  EXPECT_EQ(second.texts, Texts({"b", "c"}));
  EXPECT_EQ(frames.counts().lost, 1u);
  frames.leave(&second);
}

TEST(OutgoingFrames, FinishesWhenEachPeerHasAll) {
  OutgoingFrames frames({.queue = 4, .waits = true, .keeps = false});
  TestReader reader, late;
  frames.join(&reader);
  frames.send(message("a"));
  frames.send(message("b"));
  bool finished = false;
  std::thread end([&] { finished = frames.finish(60s); });
  const auto refuses = [&] {
    if (!frames.join(&late)) return true;
    frames.leave(&late);
    return false;
  };
  ASSERT_TRUE(becomes_true(refuses, "the end to begin")) << "no more frames come";
  reader.reads(&frames);
  EXPECT_FALSE(reader.ended) << "b is being written";
  reader.reads(&frames);
  EXPECT_TRUE(reader.ended);
  frames.leave(&reader);
  end.join();
  EXPECT_TRUE(finished);
  EXPECT_EQ(frames.counts().sent, 2u);
}

TEST(OutgoingFrames, DoesNotWaitForEverForAPeerAtTheEnd) {
  OutgoingFrames frames({.queue = 4, .waits = true, .keeps = false});
  TestReader still;
  frames.join(&still);
  frames.send(message("a"));
  EXPECT_FALSE(frames.finish(1ms));
  frames.leave(&still);
  OutgoingFrames unused({.queue = 4, .waits = true, .keeps = true});
  EXPECT_TRUE(unused.finish(60s)) << "nothing is queued";
}

TEST(OutgoingFrames, SendsAgainAfterTheEnd) {
  for (const bool keeps : {true, false}) {
    OutgoingFrames frames({.queue = 1, .waits = false, .keeps = keeps});
    TestReader first, second;
    frames.join(&first);
    frames.finish(0ms);
    EXPECT_TRUE(first.ended);
    frames.leave(&first);
    EXPECT_FALSE(frames.join(&second));
    frames.restart();
    EXPECT_EQ(frames.send(message("a")), keeps ? Outcome::Queued : Outcome::Dropped);
    EXPECT_TRUE(frames.join(&second));
    frames.send(message("b"));
    EXPECT_EQ(second.texts, Texts({keeps ? "a" : "b"}));
    EXPECT_FALSE(second.ended);
    frames.leave(&second);
  }
}

TEST(OutgoingFrames, AClientWaitsForTheRestartOrTheClose) {
  OutgoingFrames frames({.queue = 1, .waits = true, .keeps = true});
  EXPECT_TRUE(frames.wait_until_needed());
  frames.finish(0ms);
  std::thread restarted([&] { EXPECT_TRUE(frames.wait_until_needed()); });
  frames.restart();
  restarted.join();
  frames.finish(0ms);
  std::thread closed([&] { EXPECT_FALSE(frames.wait_until_needed()); });
  frames.close();
  closed.join();
}

TEST(OutgoingFrames, AFailureEndsTheWait) {
  OutgoingFrames frames({.queue = 1, .waits = true, .keeps = true});
  EXPECT_EQ(frames.send(message("a")), Outcome::Queued);
  std::thread sender([&] { EXPECT_EQ(frames.send(message("b")), Outcome::Failed); });
  frames.fail({.code = Code::SERVER_REFUSED, .what = "no"});
  sender.join();
  EXPECT_SAYS(frames.error()->message(), "WEIR-6002: no");
}

// A peer that sends. Reads are counted.
struct TestSender final : IncomingStream {
  void read() override { ++reads; }
  void refuse(CallStatus status, const std::string& why) override {
    refusals.push_back(std::to_string(static_cast<int>(status)) + " " + why);
  }
  void sends(IncomingFrames* frames, const std::string& text) {
    const auto memory = std::make_shared<std::string>(text);
    frames->arrived(this, {Chunks({std::as_bytes(std::span(*memory))}), memory, "peer", 0});
  }
  int reads = 0;
  std::vector<std::string> refusals;
};

std::string text_of(const IncomingMessage& message) {
  std::string out(message.chunks.size(), ' ');
  message.chunks.copy({0, out.size()}, out.data());
  return out;
}

std::string taken(IncomingFrames* frames) {
  const auto taken = frames->take();
  return taken.outcome == IncomingFrames::Outcome::Message ? text_of(taken.message) : "none";
}

TEST(IncomingFrames, SendersWaitWhileTheQueueIsFull) {
  IncomingFrames frames({.queue = 2, .waits = true});
  TestSender a, b;
  frames.join(&a);
  frames.join(&b);
  a.sends(&frames, "a1");
  EXPECT_EQ(a.reads, 2);
  a.sends(&frames, "a2");
  EXPECT_EQ(a.reads, 2) << "the queue is full";
  b.sends(&frames, "b1");  // its read had been started
  EXPECT_EQ(b.reads, 1);
  EXPECT_EQ(taken(&frames), "a1");
  EXPECT_EQ(a.reads, 2);
  EXPECT_EQ(taken(&frames), "a2");
  EXPECT_EQ(a.reads, 3) << "who waits longest goes on first";
  EXPECT_EQ(taken(&frames), "b1");
  frames.leave(&a);
  frames.leave(&b);
}

TEST(IncomingFrames, TheBytesThatWaitAreBounded) {
  IncomingFrames frames({.queue = 100, .max_bytes = 10, .waits = true});
  TestSender sender;
  frames.join(&sender);
  sender.sends(&frames, "12345");
  EXPECT_EQ(sender.reads, 2);
  sender.sends(&frames, "12345");
  EXPECT_EQ(sender.reads, 2);
  frames.leave(&sender);
}

TEST(IncomingFrames, WithoutWaitingKeepsTheNewest) {
  IncomingFrames frames({.queue = 2, .waits = false});
  TestSender sender;
  frames.join(&sender);
  for (const char* text : {"1", "2", "3", "4"}) sender.sends(&frames, text);
  EXPECT_EQ(sender.reads, 5) << "it never waits";
  EXPECT_EQ(taken(&frames), "3");
  EXPECT_EQ(taken(&frames), "4");
  EXPECT_EQ(frames.counts().dropped, 2u);
  frames.leave(&sender);
}

TEST(IncomingFrames, ARefusedSenderLosesWhatWaits) {
  IncomingFrames frames({.queue = 4, .waits = true});
  TestSender bad, good;
  frames.join(&bad);
  frames.join(&good);
  bad.sends(&frames, "bad");
  good.sends(&frames, "good");
  bad.sends(&frames, "worse");
  const auto first = frames.take();
  frames.refuse(first.message, "damaged");
  EXPECT_EQ(bad.refusals, Texts({"3 damaged"}));
  EXPECT_EQ(taken(&frames), "good");
  EXPECT_EQ(frames.counts().refused, 2u);
  EXPECT_FALSE(frames.leave(&bad)) << "it has left";
  bad.sends(&frames, "after the end");
  frames.interrupt();
  EXPECT_EQ(taken(&frames), "none");
  frames.leave(&good);
}

TEST(IncomingFrames, EndsAndFailuresComeAfterTheLastMessage) {
  IncomingFrames ended({}), failed({});
  TestSender one, other;
  ended.join(&one);
  one.sends(&ended, "last");
  ended.end();
  EXPECT_EQ(taken(&ended), "last");
  EXPECT_EQ(ended.take().outcome, IncomingFrames::Outcome::Ended);
  failed.join(&other);
  other.sends(&failed, "last");
  failed.fail({.code = Code::SERVER_REFUSED, .what = "no"});
  EXPECT_EQ(taken(&failed), "last");
  const auto taken = failed.take();
  EXPECT_EQ(taken.outcome, IncomingFrames::Outcome::Failed);
  EXPECT_SAYS(taken.error->message(), "WEIR-6002: no");
  ended.leave(&one);
  failed.leave(&other);
}

TEST(IncomingFrames, CloseEndsAllAndAdmitsNoMore) {
  IncomingFrames frames({});
  TestSender sender, late;
  frames.join(&sender);
  frames.close();
  EXPECT_EQ(sender.refusals, Texts({"14 the stream of the receiver has ended"}));
  EXPECT_FALSE(frames.join(&late));
}

}  // namespace frames_test
}  // namespace weir::net
