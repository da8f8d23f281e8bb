// Fuzz target: packets that one end of a local stream sends to the other, as a writer and as a
// reader, with and without shared memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <thread>
#include <vector>

#include "core/isolate/shared_arena.hpp"
#include "fuzz_input.hpp"
#include "transport/local/reader_link.hpp"
#include "transport/local/subscriber.hpp"

namespace {

using namespace weir;
using namespace weir::local;
using fuzz::require;
using io::Descriptor;

constexpr size_t kBlockBytes = 4096;
constexpr uint32_t kMaxPackets = 64;

// One packet of an input: its kind and body, its size if it lies about it, and whether memory comes
// with it.
struct RawPacket {
  std::vector<std::byte> bytes;
  bool has_block = false;
};
RawPacket next_packet(fuzz::FuzzInput* input) {
  RawPacket out;
  const uint32_t kind = input->byte();
  out.has_block = kind & 0x80;
  isolate::MessageHead head{kind & 0x7f, input->byte()};
  const bool lies = input->rarely();
  const auto body = input->bytes(head.bytes);
  if (!lies) head.bytes = static_cast<uint32_t>(body.size());
  const auto first = std::as_bytes(std::span(&head, 1));
  out.bytes.assign(first.begin(), first.end());
  out.bytes.insert(out.bytes.end(), body.begin(), body.end());
  return out;
}

const std::string& socket_path() {
  static const std::string path = [] {
    std::string folder = std::filesystem::temp_directory_path() / "weir-fuzz-XXXXXX";
    if (!mkdtemp(folder.data())) std::abort();
    static const struct Remover {
      std::string folder;
      ~Remover() { std::filesystem::remove_all(folder); }
    } remover{folder};
    return folder + "/stream";
  }();
  return path;
}

// Accepts one reader, welcomes it and sends it the packets of the input.
void write_to_reader(const Listener& listener, fuzz::FuzzInput input) {
  static const auto block =
      isolate::SharedBlock::create(kBlockBytes, isolate::Sharing::ReadByWorker);
  pollfd waiting{listener.get(), POLLIN, 0};
  if (poll(&waiting, 1, 2000) != 1) return;
  const Descriptor socket = listener.accept();
  if (!socket) return;
  if (!input.rarely()) {
    isolate::MessageWriter writer;
    writer.begin(Kind::Welcome);
    writer.put(Greeting{kMagic, kProtocol});
    writer.put(uint32_t{4});
    send_packet(socket.get(), writer.finish());
  }
  for (uint32_t i = 0; i < kMaxPackets && !input.empty(); ++i) {
    const auto packet = next_packet(&input);
    const int descriptor = packet.has_block ? (*block)->descriptor() : -1;
    if (send_packet(socket.get(), packet.bytes, descriptor) != Transfer::Done) return;
  }
}

void read_frame(const ReceivedFrame& frame) {
  uint32_t sum = 0;
  for (const auto& memory : frame.memories) {
    require(memory.size() <= kBlockBytes, "a memory lies inside its block");
    for (const std::byte byte : memory) sum += std::to_integer<uint32_t>(byte);
  }
  require(sum == 0, "a memory has the writer's bytes");
  require(frame.memories.size() <= kMaxPieces && frame.metas.size() <= kMaxMessageBytes,
          "a frame is within the limits");
}

void check_writer(fuzz::FuzzInput input) {
  auto listener = Listener::open(socket_path());
  require(listener.has_value(), "the socket can be listened on");
  std::thread writer([&listener, input] { write_to_reader(*listener, input); });
  auto subscriber = Subscriber::connect(socket_path());
  writer.join();
  if (!subscriber) {
    require(!subscriber.error().what.empty(), "an error says what is wrong");
    return;
  }
  for (;;) {
    const auto event = subscriber->receive();
    if (!event) {
      require(event.error().code == Code::PEER_MESSAGE_INVALID, "bad packets are a peer's fault");
      return;
    }
    if (event->kind == StreamEvent::Kind::Lost) return;
    if (event->kind == StreamEvent::Kind::Caps)
      require(event->caps.find('\0') == std::string::npos, "caps are one text");
    if (event->frame) read_frame(*event->frame);
  }
}

void check_reader(fuzz::FuzzInput input) {
  static const auto arena = isolate::SharedArena::make(0);
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends) != 0) return;
  ReaderLink link{Descriptor(ends[0])};
  const Descriptor reader(ends[1]);
  LocalFrame frame;
  const auto block = arena->allocate(kBlockBytes);
  if (!block) return;
  frame.memories.push_back({block, 0, kBlockBytes});
  frame.owner = block;
  Garbage garbage;
  size_t sent = 0;
  std::optional<std::string> reason;
  for (uint32_t i = 0; i < kMaxPackets && !input.empty() && !reason; ++i) {
    ++frame.number;
    if (link.state() == ReaderLink::State::Reading && link.has_room(4) && link.send_frame(frame))
      ++sent;
    const auto packet = next_packet(&input);
    const int descriptor = packet.has_block ? reader.get() : -1;
    if (send_packet(reader.get(), packet.bytes, descriptor) != Transfer::Done) break;
    const pollfd events{link.socket(), POLLIN, POLLIN};
    for (const auto& message : link.read(&events).messages)
      if (!reason) reason = link.handle(message, &garbage);
    require(!reason || !reason->empty(), "a refusal has a reason");
  }
  link.release_all(&garbage);
  require(garbage.size() == sent && !link.holds(), "each frame that was sent is released once");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::FuzzInput input(data, size);
  if (input.flag())
    check_writer(input);
  else
    check_reader(input);
  return 0;
}
