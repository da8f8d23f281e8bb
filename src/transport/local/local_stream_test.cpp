// Frames through a local stream: within a process, to other processes, with ends that die.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fstream>
#include <future>
#include <thread>

#include "transport/local/local_stream_test_support.hpp"

namespace weir::local::test {
namespace local_stream_test {

using Outcome = Publisher::Outcome;
using EventKind = StreamEvent::Kind;

std::vector<std::byte> to_bytes(std::string_view text) {
  std::vector<std::byte> out(text.size());
  std::memcpy(out.data(), text.data(), text.size());
  return out;
}

StreamEvent next(Subscriber* subscriber) {
  auto event = subscriber->receive();
  EXPECT_TRUE(event) << (event ? "" : event.error().message());
  return event ? *std::move(event) : StreamEvent{EventKind::Lost, {}, {}};
}

TEST(LocalStream, DeliversCapsFramesTimesMetasAndTheEnd) {
  const Folder folder;
  const auto publisher = publisher_at(folder.file());
  auto subscriber = subscriber_at(folder.file());
  ASSERT_TRUE(publisher->set_caps("other/tensors"));
  auto frame = make_frame(*publisher, 7);
  frame.metas = to_bytes("metas");
  EXPECT_EQ(publish(*publisher, frame), Outcome::Sent);
  EXPECT_EQ(publisher->end(), Outcome::Sent);

  const auto caps = next(&subscriber);
  EXPECT_EQ(caps.kind, EventKind::Caps);
  EXPECT_EQ(caps.caps, "other/tensors");
  const auto got = next(&subscriber);
  ASSERT_EQ(got.kind, EventKind::Frame);
  EXPECT_TRUE(is_made_frame(*got.frame, 7));
  EXPECT_EQ(got.frame->times, frame.times);
  EXPECT_EQ(got.frame->metas, to_bytes("metas"));
  EXPECT_EQ(next(&subscriber).kind, EventKind::End);
}

TEST(LocalStream, MapsTheWritersMemoryInsteadOfCopyingIt) {
  const Folder folder;
  const auto publisher = publisher_at(folder.file());
  auto subscriber = subscriber_at(folder.file());
  const auto frame = make_frame(*publisher, 1);
  publish(*publisher, frame);
  const auto got = next(&subscriber);
  ASSERT_EQ(got.kind, EventKind::Frame);
  frame.memories[0].block->data()[5] = std::byte{99};
  EXPECT_EQ(got.frame->memories[0][5], std::byte{99});
}

TEST(LocalStream, SendsEachBlockOnce) {
  const Folder folder;
  const auto publisher = publisher_at(folder.file(), 4);
  auto subscriber = subscriber_at(folder.file());
  const size_t before = open_descriptors();
  for (uint64_t i = 1; i <= 100; ++i) {
    publish(*publisher, make_frame(*publisher, i));
    const auto got = next(&subscriber);
    ASSERT_TRUE(got.frame && is_made_frame(*got.frame, i)) << i;
  }
  // At most 4 frames are held and 1 is written: their blocks have a descriptor each. What the
  // reader maps has none.
  EXPECT_LE(open_descriptors(), before + 5);
}

TEST(LocalStream, WaitsForAReaderThatHoldsAllItMay) {
  const Folder folder;
  const auto publisher = publisher_at(folder.file(), 2);
  auto subscriber = subscriber_at(folder.file());
  publish(*publisher, make_frame(*publisher, 1));
  publish(*publisher, make_frame(*publisher, 2));
  std::atomic<bool> third{false};
  std::thread writer([&] {
    EXPECT_EQ(publish(*publisher, make_frame(*publisher, 3)), Outcome::Sent);
    third = true;
  });
  auto first = next(&subscriber);
  const auto second = next(&subscriber);
  EXPECT_FALSE(third);
  first.frame.reset();
  EXPECT_TRUE(is_made_frame(*next(&subscriber).frame, 3));
  writer.join();
  EXPECT_TRUE(third);
  EXPECT_EQ(publisher->counts().missed, 0u);
}

TEST(LocalStream, WithDropAFullReaderMissesFramesAndOthersDoNot) {
  const Folder folder;
  const auto publisher = publisher_at(folder.file(), 2, true);
  auto slow = subscriber_at(folder.file());
  auto fast = subscriber_at(folder.file());
  std::vector<StreamEvent> held;
  for (uint64_t i = 1; i <= 10; ++i) {
    ASSERT_TRUE(becomes_true(
        [&] { return publish(*publisher, make_frame(*publisher, i)) == Outcome::Sent; },
        "room for the fast reader"));
    ASSERT_TRUE(is_made_frame(*next(&fast).frame, i));
    if (i <= 2) held.push_back(next(&slow));
  }
  EXPECT_TRUE(is_made_frame(*held[0].frame, 1));
  EXPECT_TRUE(is_made_frame(*held[1].frame, 2));
  EXPECT_GE(publisher->counts().missed, 8u);
}

TEST(LocalStream, AnInterruptionEndsWaiting) {
  const Folder folder;
  const auto publisher = publisher_at(folder.file(), 1);
  const auto subscriber = subscriber_at(folder.file());
  publish(*publisher, make_frame(*publisher, 1));
  std::thread writer(
      [&] { EXPECT_EQ(publish(*publisher, make_frame(*publisher, 2)), Outcome::Interrupted); });
  publisher->interrupt();
  writer.join();
  EXPECT_EQ(publisher->wait_for_release(publisher->releases()), Publisher::Release::Interrupted);
  publisher->resume();
}

// A writer without memory waits for this. It is not there yet when the reader's message has come.
TEST(LocalStream, AFrameIsReleasedWhenItsMemoryIsFree) {
  const Folder folder;
  const auto publisher = publisher_at(folder.file());
  auto subscriber = subscriber_at(folder.file());
  std::promise<void> freeing, may_free;
  auto frame = make_frame(*publisher, 1);
  const std::weak_ptr<const void> memory = frame.owner;
  frame.owner =
      std::shared_ptr<const void>(frame.owner.get(), [&, block = frame.owner](const void*) {
        freeing.set_value();
        may_free.get_future().wait();
      });
  const uint64_t releases = publisher->releases();
  EXPECT_EQ(publisher->publish(&frame), Outcome::Sent);
  frame = {};
  next(&subscriber);  // and releases it
  freeing.get_future().wait();
  std::thread reader([&] { may_free.set_value(); });
  EXPECT_EQ(publisher->wait_for_release(releases), Publisher::Release::Released);
  EXPECT_TRUE(memory.expired());
  reader.join();
  EXPECT_EQ(publisher->wait_for_release(publisher->releases()), Publisher::Release::NoneHeld);
}

TEST(LocalStream, FramesWithoutReadersGoNowhere) {
  const Folder folder;
  const auto publisher = publisher_at(folder.file());
  EXPECT_EQ(publish(*publisher, make_frame(*publisher, 1)), Outcome::NoReader);
  EXPECT_FALSE(publisher->wait_for_reader(io::deadline_in(std::chrono::milliseconds(1))));
}

TEST(LocalStream, AReaderThatComesLaterGetsTheCapsAndTheEnd) {
  const Folder folder;
  const auto publisher = publisher_at(folder.file());
  ASSERT_TRUE(publisher->set_caps("old"));
  ASSERT_TRUE(publisher->set_caps("new"));
  publisher->end();
  auto subscriber = subscriber_at(folder.file());
  EXPECT_EQ(next(&subscriber).caps, "new");
  EXPECT_EQ(next(&subscriber).kind, EventKind::End);
}

TEST(LocalStream, CapsChangeBetweenFrames) {
  const Folder folder;
  const auto publisher = publisher_at(folder.file());
  auto subscriber = subscriber_at(folder.file());
  ASSERT_TRUE(publisher->set_caps("a"));
  publish(*publisher, make_frame(*publisher, 1, 100));
  ASSERT_TRUE(publisher->set_caps("b"));
  publish(*publisher, make_frame(*publisher, 2, 300000));
  EXPECT_EQ(next(&subscriber).caps, "a");
  EXPECT_TRUE(is_made_frame(*next(&subscriber).frame, 1, 100));
  EXPECT_EQ(next(&subscriber).caps, "b");
  EXPECT_TRUE(is_made_frame(*next(&subscriber).frame, 2, 300000));
}

TEST(LocalStream, CapsThatAreTooLongAreRefused) {
  const Folder folder;
  const auto publisher = publisher_at(folder.file());
  EXPECT_REFUSED(publisher->set_caps(std::string(40000, 'x')), LIMIT_EXCEEDED, "40000 bytes");
}

TEST(LocalStream, LongMetasTravelInAMemory) {
  const Folder folder;
  const auto publisher = publisher_at(folder.file());
  auto subscriber = subscriber_at(folder.file());
  auto frame = make_frame(*publisher, 1);
  frame.memories.push_back(make_frame(*publisher, 9, 100000).memories[0]);
  frame.metas_are_memory = true;
  publish(*publisher, frame);
  const auto got = next(&subscriber);
  EXPECT_TRUE(is_made_frame(*got.frame, 1));
  ASSERT_EQ(got.frame->metas.size(), 100000u);
  EXPECT_EQ(got.frame->metas[70000], make_byte(9, 70000));
}

TEST(LocalStream, AFrameThatIsHeldOutlivesItsReader) {
  const Folder folder;
  const auto publisher = publisher_at(folder.file());
  auto frame = make_frame(*publisher, 1);
  const std::weak_ptr<const void> owner = frame.owner;
  StreamEvent got;
  {
    auto subscriber = subscriber_at(folder.file());
    publish(*publisher, frame);
    got = next(&subscriber);
  }
  frame = {};
  ASSERT_TRUE(readers_become(*publisher, 0));
  EXPECT_FALSE(owner.expired());
  EXPECT_TRUE(is_made_frame(*got.frame, 1));
  got = {};
  EXPECT_TRUE(becomes_true([&] { return owner.expired(); }, "the release"));
}

TEST(LocalStream, BlocksThatAreGoneAreForgotten) {
  const Folder folder;
  const auto publisher = publisher_at(folder.file());
  auto subscriber = subscriber_at(folder.file());
  // Every size needs blocks of its own, more than the arena retains and a reader accepts.
  for (uint64_t i = 1; i <= 700; ++i) {
    auto frame = make_frame(*publisher, i, 64);
    const auto large = publisher->arena()->allocate(4096 * (1 + (i * 37) % 701));
    ASSERT_TRUE(large);
    std::memcpy(large->data(), frame.memories[0].block->data(), 64);
    frame.memories[0] = {publisher->arena()->find(large->data(), 64)->block, 0, 64};
    frame.owner = large;
    ASSERT_EQ(publish(*publisher, frame), Outcome::Sent);
    const auto got = next(&subscriber);
    ASSERT_TRUE(got.frame && is_made_frame(*got.frame, i, 64)) << i;
  }
}

// The reader's process counts frames that are right, and gives its count as exit code.
// A slow reader looks at each frame several times.
int read_all(const std::string& path, int times) {
  auto subscriber = subscriber_when_served(path);
  if (!subscriber) return 255;
  uint64_t seed = 1;
  int right = 0;
  for (;;) {
    const auto event = subscriber->receive();
    if (!event || event->kind == EventKind::Lost) return 254;
    if (event->kind == EventKind::End) return right;
    if (event->kind != EventKind::Frame) continue;
    bool is_right = true;
    for (int i = 0; i < times; ++i)
      is_right = is_right && is_made_frame(*event->frame, seed, 100000);
    right += is_right ? 1 : 0;
    ++seed;
  }
}

TEST(LocalStreamBetweenProcesses, BytesArriveInThreeReadersOfDifferentSpeeds) {
  const Folder folder;
  std::vector<pid_t> readers;
  for (const int times : {1, 2, 8})
    readers.push_back(process([&] { return read_all(folder.file(), times); }));
  const auto publisher = publisher_at(folder.file(), 3);
  ASSERT_TRUE(readers_become(*publisher, 3));
  for (uint64_t i = 1; i <= 100; ++i) {
    ASSERT_EQ(publish(*publisher, make_frame(*publisher, i, 100000)), Outcome::Sent);
  }
  publisher->end();
  for (const pid_t reader : readers) EXPECT_EQ(wait_for_exit(reader), 100);
}

TEST(LocalStreamBetweenProcesses, AKilledReaderReturnsItsFrames) {
  const Folder folder;
  const pid_t reader = process([&] {
    const auto subscriber = subscriber_when_served(folder.file());
    for (;;) pause();
    return 0;
  });
  const auto publisher = publisher_at(folder.file(), 2);
  ASSERT_TRUE(readers_become(*publisher, 1));
  std::vector<std::weak_ptr<const void>> owners;
  for (uint64_t i = 1; i <= 2; ++i) {
    const auto frame = make_frame(*publisher, i);
    owners.push_back(frame.owner);
    EXPECT_EQ(publish(*publisher, frame), Outcome::Sent);
  }
  std::thread writer([&] {  // waits for the reader that is full, until it dies
    EXPECT_EQ(publish(*publisher, make_frame(*publisher, 3)), Outcome::NoReader);
  });
  kill(reader, SIGKILL);
  writer.join();
  EXPECT_EQ(wait_for_exit(reader), 1000 + SIGKILL);
  for (const auto& owner : owners)
    EXPECT_TRUE(becomes_true([&] { return owner.expired(); }, "a frame of the dead reader"));
}

TEST(LocalStreamBetweenProcesses, AReaderKeepsItsFramesWhenTheWriterIsKilled) {
  const Folder folder;
  const pid_t writer = process([&] {
    const auto publisher = publisher_at(folder.file());
    publisher->wait_for_reader(std::nullopt);
    publish(*publisher, make_frame(*publisher, 5));
    for (;;) pause();
    return 0;
  });
  auto subscriber = subscriber_when_served(folder.file());
  ASSERT_TRUE(subscriber);
  const auto event = next(&*subscriber);
  kill(writer, SIGKILL);
  wait_for_exit(writer);
  EXPECT_EQ(next(&*subscriber).kind, EventKind::Lost);
  ASSERT_EQ(event.kind, EventKind::Frame);
  EXPECT_TRUE(is_made_frame(*event.frame, 5));
  // Its socket file is stale: another writer takes its place.
  const auto publisher = publisher_at(folder.file());
  ASSERT_TRUE(publisher);
  auto again = subscriber_at(folder.file());
  publish(*publisher, make_frame(*publisher, 6));
  EXPECT_TRUE(is_made_frame(*next(&again).frame, 6));
}

size_t resident_kilobytes() {
  std::ifstream status("/proc/self/statm");
  size_t all = 0, resident = 0;
  status >> all >> resident;
  return resident * 4;
}

TEST(LocalStream, DescriptorsAndMemoryStayOverAThousandReconnections) {
  const Folder folder;
  const auto publisher = publisher_at(folder.file());
  const auto round = [&](uint64_t i) {
    auto subscriber = subscriber_at(folder.file());
    ASSERT_EQ(publish(*publisher, make_frame(*publisher, i, 200000)), Outcome::Sent);
    ASSERT_TRUE(is_made_frame(*next(&subscriber).frame, i, 200000));
  };
  for (uint64_t i = 1; i <= 50; ++i) round(i);
  ASSERT_TRUE(readers_become(*publisher, 0));
  const size_t descriptors = open_descriptors();
  [[maybe_unused]] const size_t memory = resident_kilobytes();
  for (uint64_t i = 51; i <= 1050; ++i) round(i);
  ASSERT_TRUE(readers_become(*publisher, 0));
  EXPECT_TRUE(becomes_true([&] { return open_descriptors() <= descriptors + 2; },
                           "the sockets to be closed"));
#ifndef __SANITIZE_ADDRESS__  // it keeps freed memory for a while
  EXPECT_LE(resident_kilobytes(), memory + 4096);
#endif
}

}  // namespace local_stream_test
}  // namespace weir::local::test
