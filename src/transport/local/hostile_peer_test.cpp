// Readers and writers of local streams that break the rules are refused, and do no harm.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>

#include <future>
#include <thread>

#include "transport/local/local_stream_test_support.hpp"

namespace weir::local::test {
namespace hostile_peer_test {

using isolate::MessageWriter;

// A reader that speaks by hand.
class RawReader {
 public:
  explicit RawReader(const std::string& path) {
    auto socket = connect_to(path);
    if (socket) socket_ = *std::move(socket);
  }
  void hello(uint32_t magic = kMagic, uint32_t protocol = kProtocol) {
    send(Kind::Hello, Greeting{magic, protocol});
  }
  template <class T>
  void send(Kind kind, const T& body) {
    MessageWriter writer;
    writer.begin(kind);
    writer.put(body);
    send_packet(socket_.get(), writer.finish());
  }
  void send_bytes(size_t count, int descriptor = -1) {
    send_packet(socket_.get(), std::vector<std::byte>(count), descriptor);
  }
  // Whether the writer closes the connection.
  bool is_closed() {
    std::vector<std::byte> buffer(kMaxMessageBytes);
    for (;;) {
      Packet packet;
      const Transfer transfer = receive_packet(socket_.get(), buffer, &packet);
      if (transfer == Transfer::Closed) return true;
      if (transfer == Transfer::Done) continue;
      pollfd watched{socket_.get(), POLLIN, 0};
      if (poll(&watched, 1, 10000) == 0) return false;
    }
  }

 private:
  Descriptor socket_;
};

class HostileReader : public ::testing::Test {
 protected:
  HostileReader() { open(); }
  void open() {
    auto made = Publisher::open({.path = folder_.file(),
                                 .max_held = 4,
                                 .drop = false,
                                 .max_readers = 2,
                                 .refused = [this](const Error& error) {
                                   const std::lock_guard lock(mutex_);
                                   reason_ = error.message();
                                 }});
    EXPECT_TRUE(made);
    publisher_ = *std::move(made);
  }
  // The writer refused one reader, with these words, and still serves others.
  void expect_refused(RawReader* reader, const char* words) {
    EXPECT_TRUE(reader->is_closed());
    EXPECT_TRUE(becomes_true([&] { return publisher_->counts().refused == 1; }, "the refusal"));
    EXPECT_TRUE(becomes_true([&] { return !reason().empty(); }, "the reason"));
    EXPECT_SAYS(reason(), words);
    auto good = subscriber_at(folder_.file());
    EXPECT_EQ(publish(*publisher_, make_frame(*publisher_, 3)), Publisher::Outcome::Sent);
    const auto event = good.receive();
    ASSERT_TRUE(event && event->frame);
    EXPECT_TRUE(is_made_frame(*event->frame, 3));
  }
  std::string reason() {
    const std::lock_guard lock(mutex_);
    return reason_;
  }

  Folder folder_;
  std::mutex mutex_;
  std::string reason_;
  std::unique_ptr<Publisher> publisher_;
};

TEST_F(HostileReader, AnotherProtocol) {
  RawReader reader(folder_.file());
  reader.hello(0x12345678);
  expect_refused(&reader, "did not start the handshake");
}
TEST_F(HostileReader, AnotherVersion) {
  RawReader reader(folder_.file());
  reader.hello(kMagic, 77);
  expect_refused(&reader, "version 77");
}
TEST_F(HostileReader, AMessageBeforeTheGreeting) {
  RawReader reader(folder_.file());
  reader.send(Kind::Release, uint64_t{1});
  expect_refused(&reader, "did not start the handshake");
}
TEST_F(HostileReader, ASecondGreeting) {
  RawReader reader(folder_.file());
  reader.hello();
  reader.hello();
  expect_refused(&reader, "kind 1");
}
TEST_F(HostileReader, AReleaseOfAFrameThatItDoesNotHold) {
  RawReader reader(folder_.file());
  reader.hello();
  reader.send(Kind::Release, uint64_t{42});
  expect_refused(&reader, "released frame 42");
}
TEST_F(HostileReader, AReleaseTwice) {
  RawReader reader(folder_.file());
  reader.hello();
  ASSERT_TRUE(readers_become(*publisher_, 1));
  publish(*publisher_, make_frame(*publisher_, 1));
  reader.send(Kind::Release, uint64_t{1});
  reader.send(Kind::Release, uint64_t{1});
  expect_refused(&reader, "released frame 1,");
}
TEST_F(HostileReader, AReleaseOfTheWrongSize) {
  RawReader reader(folder_.file());
  reader.hello();
  reader.send(Kind::Release, uint32_t{1});
  expect_refused(&reader, "wrong size");
}
TEST_F(HostileReader, AWritersMessage) {
  RawReader reader(folder_.file());
  reader.hello();
  reader.send(Kind::End, uint32_t{1});
  expect_refused(&reader, "kind 9");
}
TEST_F(HostileReader, APacketThatIsTooLong) {
  RawReader reader(folder_.file());
  reader.send_bytes(kMaxMessageBytes + 1);
  expect_refused(&reader, "not a message");
}
TEST_F(HostileReader, ShortPackets) {
  RawReader reader(folder_.file());
  reader.send_bytes(3);
  expect_refused(&reader, "not a message");
}
TEST_F(HostileReader, ADescriptor) {
  RawReader reader(folder_.file());
  reader.send_bytes(8, 1);
  expect_refused(&reader, "not a message");
}
TEST_F(HostileReader, Silence) {
  RawReader reader(folder_.file());
  expect_refused(&reader, "within 2 s");
}
TEST_F(HostileReader, OneTooMany) {
  const auto one = subscriber_at(folder_.file());
  const auto two = subscriber_at(folder_.file());
  EXPECT_REFUSED(Subscriber::connect(folder_.file()), SERVER_REFUSED, "accepts another reader");
  EXPECT_EQ(publisher_->counts().refused, 1u);
  EXPECT_EQ(publisher_->counts().readers, 2u);
}
TEST_F(HostileReader, AnotherUser) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root to become another user";
  publisher_.reset();
  const pid_t other = process([&] {
    if (setuid(65534) != 0) return 2;
    const auto is_refused = [&] {
      const auto subscriber = Subscriber::connect(folder_.file());
      return !subscriber && subscriber.error().code == Code::PEER_MESSAGE_INVALID;
    };
    return becomes_true(is_refused, "the refusal") ? 0 : 1;
  });
  open();
  ASSERT_EQ(chmod(std::filesystem::path(folder_.file()).parent_path().c_str(), 0777), 0);
  ASSERT_EQ(chmod(folder_.file().c_str(), 0777), 0);
  EXPECT_EQ(wait_for_exit(other), 0);
  EXPECT_TRUE(becomes_true([&] { return publisher_->counts().refused == 1; }, "the refusal"));
  EXPECT_TRUE(becomes_true([&] { return !reason().empty(); }, "the reason"));
  EXPECT_SAYS(reason(), "user 65534");
}

// A memfd of one page with these seals.
Descriptor make_memory(int seals, off_t bytes = 4096) {
  Descriptor out(memfd_create("test", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  EXPECT_EQ(ftruncate(out.get(), bytes), 0);
  EXPECT_EQ(fcntl(out.get(), F_ADD_SEALS, seals), 0);
  return out;
}

// A writer that sends what `script` says after the greeting.
class HostileWriter : public ::testing::Test {
 protected:
  // The error of the reader.
  template <class Script>
  Error error_after(const Script& script) {
    const auto listener = Listener::open(folder_.file());
    EXPECT_TRUE(listener);
    std::promise<void> done;
    std::thread writer([&] {
      pollfd watched{listener->get(), POLLIN, 0};
      poll(&watched, 1, 10000);
      socket_ = listener->accept();
      send(Kind::Welcome, Greeting{kMagic, kProtocol}, uint32_t{16});
      script();
      done.get_future().wait();
    });
    Error out{.code = Code::INTERNAL, .what = "no error"};
    {
      auto subscriber = Subscriber::connect(folder_.file());
      EXPECT_TRUE(subscriber);
      for (int i = 0; subscriber && i < 8; ++i) {
        const auto event = subscriber->receive();
        if (event) continue;
        out = event.error();
        break;
      }
    }
    done.set_value();
    writer.join();
    return out;
  }
  template <class... T>
  void send(Kind kind, const T&... parts) {
    MessageWriter message;
    message.begin(kind);
    (message.put(parts), ...);
    send_packet(socket_.get(), message.finish());
  }
  void send_block(const BlockMessage& call, const Descriptor& descriptor) {
    MessageWriter message;
    message.begin(Kind::Block);
    message.put(call);
    send_packet(socket_.get(), message.finish(), descriptor.get());
  }
  void send_good_block(uint64_t id = 1) { send_block({id, 4096}, make_memory(F_SEAL_SHRINK)); }
  static FrameHead head(uint64_t number, uint32_t pieces = 1, uint32_t metas = 0) {
    return {number, {}, pieces, metas};
  }

  Folder folder_;
  Descriptor socket_;
};

// edgesrc reconnect=true waits for the next one.
TEST_F(HostileWriter, NoHandshake) {
  const auto listener = Listener::open(folder_.file());
  ASSERT_TRUE(listener);
  const auto subscriber = Subscriber::connect(folder_.file());
  EXPECT_REFUSED(subscriber, SERVER_REFUSED, "has not started the handshake within 2 s");
}

TEST_F(HostileWriter, ABlockThatCanShrink) {
  const auto error = error_after([&] { send_block({1, 4096}, make_memory(F_SEAL_GROW)); });
  EXPECT_EQ(error.code, Code::PEER_MESSAGE_INVALID);
  EXPECT_SAYS(error.message(), "not sealed against shrinking");
}
TEST_F(HostileWriter, ABlockOfAnOrdinaryFile) {
  const auto error = error_after([&] {
    send_block({1, 4096}, Descriptor(open("/proc/self/exe", O_RDONLY | O_CLOEXEC)));
  });
  EXPECT_SAYS(error.message(), "not a memfd");
}
TEST_F(HostileWriter, ABlockWithoutADescriptor) {
  EXPECT_SAYS(error_after([&] {
                send(Kind::Block, BlockMessage{1, 4096});
              }).message(),
              "without a descriptor");
}
TEST_F(HostileWriter, ABlockLargerThanItsMemory) {
  EXPECT_SAYS(error_after([&] {
                send_block({1, 8192}, make_memory(F_SEAL_SHRINK));
              }).message(),
              "4096 bytes as one of 8192");
}
TEST_F(HostileWriter, ABlockOfNoBytes) {
  EXPECT_SAYS(error_after([&] {
                send_block({1, 0}, make_memory(F_SEAL_SHRINK));
              }).message(),
              "4096 bytes as one of 0");
}
TEST_F(HostileWriter, ABlockBeyondAllMemory) {
  EXPECT_SAYS(error_after([&] {
                send_block({1, UINT64_MAX}, make_memory(F_SEAL_SHRINK));
              }).message(),
              "blocks of more than");
}
TEST_F(HostileWriter, ABlockTwice) {
  EXPECT_SAYS(error_after([&] { send_good_block(), send_good_block(); }).message(),
              "block 1 twice");
}
TEST_F(HostileWriter, BlocksWithoutEnd) {
  EXPECT_SAYS(error_after([&] {
                for (uint64_t i = 1; i <= Subscriber::kMaxBlocks + 1; ++i) {
                  pollfd room{socket_.get(), POLLOUT, 0};
                  poll(&room, 1, 10000);
                  send_good_block(i);
                }
              }).message(),
              "more than 512 blocks");
}
TEST_F(HostileWriter, AnEndOfABlockThatIsNotKnown) {
  EXPECT_SAYS(error_after([&] { send(Kind::Forget, uint64_t{5}); }).message(), "did not send");
}
TEST_F(HostileWriter, AFrameInAnUnknownBlock) {
  EXPECT_SAYS(error_after([&] {
                send(Kind::Frame, head(1), Piece{9, 0, 1});
              }).message(),
              "block 9, which is not known");
}
TEST_F(HostileWriter, AFrameBeyondItsBlock) {
  for (const Piece piece : {Piece{1, 0, 4097}, Piece{1, 4097, 0}, Piece{1, 4096, 1},
                            Piece{1, UINT64_MAX, 2}, Piece{1, 2, UINT64_MAX}})
    EXPECT_SAYS(error_after([&] {
                  send_good_block();
                  send(Kind::Frame, head(1), piece);
                }).message(),
                "in a block of 4096");
}
TEST_F(HostileWriter, AFrameThatComesTwice) {
  EXPECT_SAYS(error_after([&] {
                send(Kind::Frame, head(1, 0));
                send(Kind::Frame, head(1, 0));
              }).message(),
              "number 1 after 1");
}
TEST_F(HostileWriter, MoreMemoriesThanThereAre) {
  EXPECT_SAYS(error_after([&] {
                send_good_block();
                send(Kind::Frame, head(1, 2), Piece{1, 0, 1});
              }).message(),
              "block 0, which is not known");
}
TEST_F(HostileWriter, MoreMemoriesThanThereCanBe) {
  EXPECT_SAYS(error_after([&] { send(Kind::Frame, head(1, 257)); }).message(), "257 memories");
}
TEST_F(HostileWriter, MetasInAMemoryThatIsMissing) {
  EXPECT_SAYS(error_after([&] { send(Kind::Frame, head(1, 0, 1)); }).message(), "0 memories");
}
TEST_F(HostileWriter, ADescriptorWithAnotherMessage) {
  EXPECT_SAYS(error_after([&] {
                MessageWriter message;
                message.begin(Kind::End);
                send_packet(socket_.get(), message.finish(), socket_.get());
              }).message(),
              "descriptor without a block");
}
TEST_F(HostileWriter, CapsThatAreNoText) {
  EXPECT_SAYS(error_after([&] { send(Kind::Caps, uint32_t{4}, uint32_t{0}); }).message(),
              "not text");
  EXPECT_SAYS(error_after([&] { send(Kind::Caps, uint32_t{400}); }).message(), "not text");
}
TEST_F(HostileWriter, AReadersMessage) {
  EXPECT_SAYS(error_after([&] { send(Kind::Release, uint64_t{1}); }).message(), "kind 2");
}
TEST_F(HostileWriter, ShortPackets) {
  EXPECT_SAYS(error_after([&] { send_packet(socket_.get(), std::vector<std::byte>(5)); }).message(),
              "not a message");
}

TEST(ReceivedBlock, CannotBeWrittenByItsReader) {
  const auto block = isolate::SharedBlock::create(4096, isolate::Sharing::ReadByWorker);
  ASSERT_TRUE(block);
  EXPECT_EQ(mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, (*block)->descriptor(), 0),
            MAP_FAILED);
  EXPECT_TRUE(map_block(Descriptor(dup((*block)->descriptor())), 4096));
}

}  // namespace hostile_peer_test
}  // namespace weir::local::test
