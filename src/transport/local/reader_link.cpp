// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/local/reader_link.hpp"

namespace weir::local {

bool ReaderLink::send(std::span<const std::byte> message, int descriptor) {
  switch (send_packet(socket_.get(), message, descriptor)) {
    case Transfer::Done:
      return true;
    case Transfer::WouldWait:
      full_ = true;
      return false;
    case Transfer::Closed:
      break;
  }
  state_ = State::Gone;
  return false;
}

bool ReaderLink::welcome(uint32_t max_held) {
  writer_.begin(Kind::Welcome);
  writer_.put(Greeting{kMagic, kProtocol});
  writer_.put(max_held);
  return send(writer_.finish());
}

bool ReaderLink::send_caps(const std::shared_ptr<const std::string>& caps) {
  if (caps == caps_) return true;
  writer_.begin(Kind::Caps);
  writer_.text(*caps);
  if (!send(writer_.finish())) return false;
  caps_ = caps;
  return true;
}

bool ReaderLink::send_end() {
  writer_.begin(Kind::End);
  return send(writer_.finish());
}

bool ReaderLink::forget_gone_blocks() {
  for (auto block = blocks_.begin(); block != blocks_.end();) {
    if (!block->second.expired()) {
      ++block;
      continue;
    }
    writer_.begin(Kind::Forget);
    writer_.put(block->first);
    if (!send(writer_.finish())) return false;
    block = blocks_.erase(block);
  }
  return true;
}

// Sends a block with its descriptor the first time.
bool ReaderLink::share(const std::shared_ptr<isolate::SharedBlock>& block) {
  if (blocks_.contains(block->id())) return true;
  if (!forget_gone_blocks()) return false;
  writer_.begin(Kind::Block);
  writer_.put(BlockMessage{block->id(), block->bytes()});
  if (!send(writer_.finish(), block->descriptor())) return false;
  blocks_.emplace(block->id(), block);
  return true;
}

bool ReaderLink::send_frame(const LocalFrame& frame) {
  if (frame.number <= last_number_) return true;
  for (const auto& memory : frame.memories)
    if (!share(memory.block)) return false;
  writer_.begin(Kind::Frame);
  writer_.put(FrameHead{frame.number, frame.times, static_cast<uint32_t>(frame.memories.size()),
                        frame.metas_are_memory ? 1u : 0u});
  for (const auto& memory : frame.memories)
    writer_.put(Piece{memory.block->id(), memory.offset, memory.bytes});
  writer_.bytes(frame.metas);
  // Before the message: the release may come at once.
  held_.emplace(frame.number, frame.owner);
  if (!send(writer_.finish())) {
    held_.erase(frame.number);
    return false;
  }
  last_number_ = frame.number;
  return true;
}

std::optional<std::string> ReaderLink::release(uint64_t number, Garbage* garbage) {
  const auto found = held_.find(number);
  if (found == held_.end())
    return "it released frame " + std::to_string(number) + ", which it does not hold";
  garbage->push_back(std::move(found->second));
  held_.erase(found);
  return std::nullopt;
}

ReaderLink::Input ReaderLink::read(const pollfd* events) {
  Input out;
  if (!(events->revents & ~POLLOUT)) return out;
  while (out.messages.size() < kMaxMessages) {
    Message message;
    Packet packet;
    const Transfer transfer = receive_packet(socket_.get(), message.bytes, &packet);
    out.is_closed = transfer == Transfer::Closed;
    if (transfer != Transfer::Done) break;
    if (!packet.cut && !packet.descriptor) message.size = packet.bytes.size();
    out.messages.push_back(message);
  }
  return out;
}

std::optional<std::string> ReaderLink::handle(const Message& received, Garbage* garbage) {
  auto message = open_message(std::span(received.bytes).first(received.size));
  if (!message) return "it sent a packet that is not a message";
  auto& body = message->body;
  if (state_ == State::Greeting) {
    const auto greeting = body.take<Greeting>();
    if (message->kind != Kind::Hello || !body.complete() || greeting.magic != kMagic)
      return "it did not start the handshake of a reader";
    if (greeting.protocol != kProtocol)
      return "it speaks version " + std::to_string(greeting.protocol) + " of the protocol, not " +
             std::to_string(kProtocol);
    state_ = State::Reading;
    return std::nullopt;
  }
  if (message->kind == Kind::Release) {
    const auto number = body.take<uint64_t>();
    if (!body.complete()) return "it sent a release of the wrong size";
    return release(number, garbage);
  }
  if (message->kind == Kind::Leave && body.complete() && state_ == State::Reading) {
    state_ = State::Leaving;
    return std::nullopt;
  }
  return "it sent a message of kind " + std::to_string(static_cast<uint32_t>(message->kind)) +
         ", which a reader does not send now";
}

void ReaderLink::release_all(Garbage* garbage) {
  for (auto& [number, owner] : held_) garbage->push_back(std::move(owner));
  held_.clear();
}

}  // namespace weir::local
