// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/local/subscriber.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace weir::local {
namespace {

constexpr auto kGreetingTime = std::chrono::seconds(2);

template <class T>
struct Small {
  isolate::MessageHead head;
  T body;
};

Result<std::optional<StreamEvent>> without_event(Status status) {
  if (!status) return std::move(status).error();
  return std::optional<StreamEvent>();
}

Error no_greeting(const std::string& what) {
  return Error{.code = Code::SERVER_REFUSED,
               .what = "the edgesink of a local stream " + what,
               .offered = "an edgesrc of protocol version " + std::to_string(kProtocol),
               .needed = "an edgesink of the same version that accepts another reader"};
}

}  // namespace

Error bad_writer(std::string sent) {
  return Error{.code = Code::PEER_MESSAGE_INVALID,
               .what = "the edgesink of a local stream sent an invalid message",
               .offered = std::move(sent),
               .needed = "an edgesink of the same version; the connection is closed"};
}

Result<isolate::Mapping> map_block(const Descriptor& block, uint64_t bytes) {
  if (!block) return bad_writer("a block without a descriptor");
  const int seals = fcntl(block.get(), F_GET_SEALS);
  if (seals < 0) return bad_writer("a block that is not a memfd");
  if (!(seals & F_SEAL_SHRINK)) return bad_writer("a block that is not sealed against shrinking");
  struct stat found {};
  if (fstat(block.get(), &found) != 0 || found.st_size < 0)
    return bad_writer("a block of unknown size");
  const auto size = static_cast<uint64_t>(found.st_size);
  if (bytes == 0 || bytes > size)
    return bad_writer("a block of " + std::to_string(size) + " bytes as one of " +
                      std::to_string(bytes));
  isolate::Mapping out(block.get(), bytes, false);
  if (!out)
    return Error{.code = Code::OUT_OF_MEMORY,
                 .what = "a block of a local stream cannot be mapped",
                 .offered = std::to_string(bytes) + " bytes"};
  return out;
}

void WriterLink::send(std::span<const std::byte> message) noexcept {
  // A writer that does not read its few releases is stopped or hostile: it loses the connection.
  if (send_packet(socket_.get(), message) == Transfer::WouldWait)
    shutdown(socket_.get(), SHUT_RDWR);
}

void WriterLink::release(uint64_t number) noexcept {
  --held_;
  const Small<uint64_t> message{{static_cast<uint32_t>(Kind::Release), sizeof number}, number};
  send(std::as_bytes(std::span(&message, 1)));
}

void WriterLink::leave() noexcept {
  const isolate::MessageHead message{static_cast<uint32_t>(Kind::Leave), 0};
  send(std::as_bytes(std::span(&message, 1)));
}

Subscriber::~Subscriber() {
  if (link_) link_->leave();
}

Result<Subscriber> Subscriber::connect(const std::string& path, int cancel) {
  auto socket = connect_to(path);
  if (!socket) return socket.error();
  const auto user = user_of_peer(socket->get());
  if (user != geteuid())
    return bad_writer("path=" + path + " is served by user " +
                      (user ? std::to_string(*user) : "?") + ", not by user " +
                      std::to_string(geteuid()));
  Subscriber out(*std::move(socket));
  if (auto status = out.greet(cancel); !status) return status.error();
  return out;
}

Status Subscriber::greet(int cancel) {
  const Small<Greeting> hello{{static_cast<uint32_t>(Kind::Hello), sizeof(Greeting)},
                              {kMagic, kProtocol}};
  send_packet(link_->socket(), std::as_bytes(std::span(&hello, 1)));
  Packet packet;
  switch (wait(cancel, io::deadline_in(kGreetingTime), &packet)) {
    case Wait::Packet:
      break;
    case Wait::Cancelled:
      return Error{.code = Code::CANCELLED, .what = "connecting to a local stream was cancelled"};
    case Wait::Late:
      return no_greeting("has not started the handshake within 2 s");
    case Wait::Closed:
      return no_greeting("closed the connection");
  }
  auto message = packet.cut ? std::nullopt : open_message(packet.bytes);
  if (!message || message->kind != Kind::Welcome) return bad_writer("no handshake");
  const auto greeting = message->body.take<Greeting>();
  max_held_ = message->body.take<uint32_t>();
  if (!message->body.complete() || greeting.magic != kMagic || greeting.protocol != kProtocol)
    return bad_writer("a handshake of a different version of the protocol");
  return ok();
}

Subscriber::Wait Subscriber::wait(int cancel, const io::Deadline& deadline, Packet* packet) {
  for (;;) {
    switch (receive_packet(link_->socket(), buffer_, packet)) {
      case Transfer::Done:
        return Wait::Packet;
      case Transfer::Closed:
        return Wait::Closed;
      case Transfer::WouldWait:
        break;
    }
    pollfd watched[] = {{link_->socket(), POLLIN, 0}, {cancel, POLLIN, 0}};
    const int ready = poll(watched, 2, io::poll_timeout(deadline));
    if (ready < 0 && errno != EINTR) return Wait::Closed;
    if (ready > 0 && watched[1].revents) return Wait::Cancelled;
    if (ready == 0 && io::is_over(deadline)) return Wait::Late;
  }
}

Result<StreamEvent> Subscriber::receive(int cancel) {
  for (;;) {
    Packet packet;
    const Wait waited = wait(cancel, std::nullopt, &packet);
    if (waited == Wait::Cancelled) return StreamEvent{StreamEvent::Kind::Interrupted, {}, {}};
    if (waited != Wait::Packet) return StreamEvent{StreamEvent::Kind::Lost, {}, {}};
    auto event = handle(&packet);
    if (!event) return event.error();
    if (*event) return **std::move(event);
  }
}

Subscriber::Handled Subscriber::handle(Packet* packet) {
  auto message = packet->cut ? std::nullopt : open_message(packet->bytes);
  if (!message) return bad_writer("a packet that is not a message");
  auto& body = message->body;
  if (packet->descriptor && message->kind != Kind::Block)
    return bad_writer("a descriptor without a block");
  switch (message->kind) {
    case Kind::Block:
      return without_event(add_block(&body, packet->descriptor));
    case Kind::Forget:
      return without_event(forget_block(&body));
    case Kind::Caps:
      return caps(&body);
    case Kind::Frame:
      return frame(&body);
    case Kind::End:
      if (!body.complete()) return bad_writer("an end of stream of the wrong size");
      return std::optional(StreamEvent{StreamEvent::Kind::End, {}, {}});
    default:
      return bad_writer("a message of kind " +
                        std::to_string(static_cast<uint32_t>(message->kind)));
  }
}

Status Subscriber::add_block(isolate::MessageReader* body, const Descriptor& descriptor) {
  const auto call = body->take<BlockMessage>();
  if (!body->complete()) return bad_writer("a block message of the wrong size");
  if (blocks_.contains(call.id)) return bad_writer("block " + std::to_string(call.id) + " twice");
  if (blocks_.size() >= kMaxBlocks)
    return bad_writer("more than " + std::to_string(kMaxBlocks) + " blocks");
  if (call.bytes > kMaxMappedBytes - mapped_bytes_)
    return bad_writer("blocks of more than " + std::to_string(kMaxMappedBytes) + " bytes");
  auto mapping = map_block(descriptor, call.bytes);
  if (!mapping) return mapping.error();
  mapped_bytes_ += call.bytes;
  blocks_.emplace(call.id, std::make_shared<const isolate::Mapping>(*std::move(mapping)));
  return ok();
}

Status Subscriber::forget_block(isolate::MessageReader* body) {
  const auto found = blocks_.find(body->take<uint64_t>());
  if (!body->complete() || found == blocks_.end())
    return bad_writer("an end of a block that it did not send");
  mapped_bytes_ -= found->second->bytes();
  blocks_.erase(found);  // frames that are held keep it mapped
  return ok();
}

Subscriber::Handled Subscriber::caps(isolate::MessageReader* body) {
  StreamEvent event{StreamEvent::Kind::Caps, body->text(), {}};
  if (!body->complete() || event.caps.find('\0') != std::string::npos)
    return bad_writer("caps that are not text");
  return std::optional(std::move(event));
}

Subscriber::Handled Subscriber::frame(isolate::MessageReader* body) {
  const auto head = body->take<FrameHead>();
  if (head.number <= last_number_ || head.pieces > kMaxPieces || head.metas_are_piece > 1 ||
      (head.metas_are_piece && head.pieces == 0))
    return bad_writer("a frame with the number " + std::to_string(head.number) + " after " +
                      std::to_string(last_number_) + " and " + std::to_string(head.pieces) +
                      " memories");
  last_number_ = head.number;
  auto out = std::make_shared<ReceivedFrame>(link_, head.number);
  out->times = head.times;
  for (uint32_t i = 0; i < head.pieces; ++i) {
    const auto piece = body->take<Piece>();
    const auto block = blocks_.find(piece.block);
    if (block == blocks_.end())
      return bad_writer("a frame in block " + std::to_string(piece.block) + ", which is not known");
    const uint64_t size = block->second->bytes();
    if (piece.offset > size || piece.bytes > size - piece.offset)
      return bad_writer("a frame of " + std::to_string(piece.bytes) + " bytes at " +
                        std::to_string(piece.offset) + " in a block of " + std::to_string(size));
    out->memories.emplace_back(block->second->data() + piece.offset, piece.bytes);
    out->mappings.push_back(block->second);
  }
  const auto metas = head.metas_are_piece ? out->memories.back() : body->rest();
  if (!body->complete()) return bad_writer("a frame message of the wrong size");
  out->metas.assign(metas.begin(), metas.end());
  if (head.metas_are_piece) out->memories.pop_back();
  return std::optional(StreamEvent{StreamEvent::Kind::Frame, {}, std::move(out)});
}

}  // namespace weir::local
