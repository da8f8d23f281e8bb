// Subscriber: the reading end of a local stream. It maps the writer's memory for reading and
// releases each frame when its last user has.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <atomic>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/io/deadline.hpp"
#include "core/isolate/shared_block.hpp"
#include "transport/local/local_message.hpp"
#include "transport/local/local_socket.hpp"

namespace weir::local {

// The error for what a writer sends and must not.
Error bad_writer(std::string sent);

// Maps `bytes` of a block for reading. The block must be sealed against shrinking: a page that is
// cut off would kill the process that reads it.
// Errors: PEER_MESSAGE_INVALID, OUT_OF_MEMORY.
Result<isolate::Mapping> map_block(const Descriptor& block, uint64_t bytes);

// The connection, which outlives the Subscriber while frames are held.
class WriterLink {
 public:
  explicit WriterLink(Descriptor socket) : socket_(std::move(socket)) {}
  int socket() const noexcept { return socket_.get(); }
  void add_held() noexcept { ++held_; }
  uint32_t held() const noexcept { return held_; }
  void release(uint64_t number) noexcept;
  void leave() noexcept;

 private:
  void send(std::span<const std::byte> message) noexcept;
  const Descriptor socket_;
  std::atomic<uint32_t> held_{0};  // frames that were received and not released
};

// A frame in the writer's memory, which is free again when the object is destroyed. Any thread.
class ReceivedFrame {
 public:
  ReceivedFrame(std::shared_ptr<WriterLink> link, uint64_t number) noexcept
      : link_(std::move(link)), number_(number) {
    link_->add_held();
  }
  ReceivedFrame(const ReceivedFrame&) = delete;
  ReceivedFrame& operator=(const ReceivedFrame&) = delete;
  ~ReceivedFrame() { link_->release(number_); }

  FrameTimes times;
  std::vector<std::span<const std::byte>> memories;
  std::vector<std::byte> metas;  // a copy: the writer can change shared memory
  std::vector<std::shared_ptr<const isolate::Mapping>> mappings;  // of `memories`

 private:
  const std::shared_ptr<WriterLink> link_;
  const uint64_t number_;
};

struct StreamEvent {
  enum class Kind {
    Caps,         // `caps` of the frames that follow
    Frame,        // `frame`
    End,          // of the stream
    Lost,         // the writer has ended or closed the connection
    Interrupted,  // `cancel` became readable
  };
  Kind kind;
  std::string caps;
  std::shared_ptr<const ReceivedFrame> frame;
};

// Used by one thread.
class Subscriber {
 public:
  static constexpr size_t kMaxBlocks = 512;
  static constexpr uint64_t kMaxMappedBytes = uint64_t{16} << 30;

  // Connects and greets, within 2 s. `cancel` is a borrowed descriptor that ends waiting when
  // readable, or -1. Errors: those of connect_to(), PEER_MESSAGE_INVALID for a peer of another user
  // or protocol, CANCELLED.
  static Result<Subscriber> connect(const std::string& path, int cancel = -1);
  Subscriber(Subscriber&&) noexcept = default;
  Subscriber& operator=(Subscriber&&) noexcept = default;
  ~Subscriber();

  // Whether the writer waits until a frame is released: copy this one rather than keep it.
  bool holds_all() const noexcept { return link_->held() >= max_held_; }

  // Waits for what comes next. PEER_MESSAGE_INVALID: close the connection.
  Result<StreamEvent> receive(int cancel = -1);

 private:
  explicit Subscriber(Descriptor socket)
      : link_(std::make_shared<WriterLink>(std::move(socket))), buffer_(kMaxMessageBytes) {}
  Status greet(int cancel);
  enum class Wait { Packet, Closed, Cancelled, Late };
  Wait wait(int cancel, const io::Deadline& deadline, Packet* packet);
  // No event: the message was for this object.
  using Handled = Result<std::optional<StreamEvent>>;
  Handled handle(Packet* packet);
  Status add_block(isolate::MessageReader* body, const Descriptor& descriptor);
  Status forget_block(isolate::MessageReader* body);
  Handled caps(isolate::MessageReader* body);
  Handled frame(isolate::MessageReader* body);

  std::shared_ptr<WriterLink> link_;
  std::vector<std::byte> buffer_;
  std::map<uint64_t, std::shared_ptr<const isolate::Mapping>> blocks_;
  uint64_t mapped_bytes_ = 0, last_number_ = 0;
  uint32_t max_held_ = 0;
};

}  // namespace weir::local
