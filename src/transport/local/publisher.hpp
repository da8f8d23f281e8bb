// Publisher: the writing end of a local stream. Its frames lie in shared memory that any number of
// readers of the same user map; nothing is copied for them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/io/deadline.hpp"
#include "core/isolate/shared_arena.hpp"
#include "transport/local/local_message.hpp"
#include "transport/local/local_socket.hpp"
#include "transport/local/reader_link.hpp"
#include "transport/poll_server.hpp"

namespace weir::local {

struct LocalPublisherOptions {
  std::string path;
  uint32_t max_held = 16;     // frames that a reader has received and not released
  bool drop = false;          // a reader that holds so many misses frames; else publish() waits
  uint32_t max_readers = 32;  // more are refused
  std::function<void(const Error&)> refused;  // called for each reader that is refused; any thread
};

struct LocalPublisherCounts {
  uint32_t readers = 0;
  uint64_t refused = 0;  // connections that were closed because of what they are or sent
  uint64_t missed = 0;   // frames that were not sent to a reader, over all readers
};

// publish(), set_caps() and end() are called by one thread; everything else by any.
class Publisher : public transport::PollServer<ReaderLink> {
 public:
  // Listens on the path. Errors: those of Listener::open().
  static Result<std::unique_ptr<Publisher>> open(LocalPublisherOptions options);
  ~Publisher() override;

  // Memory allocated here can be published without a copy.
  const std::shared_ptr<isolate::SharedArena>& arena() const noexcept { return arena_; }

  enum class Outcome { Sent, NoReader, Missed, Interrupted };
  // The caps of the frames that follow. LIMIT_EXCEEDED for a text beyond kMaxCapsBytes.
  Status set_caps(std::string text);
  // Sends a frame to every reader. Missed: no reader had room, with `drop`. Interrupted: the next
  // call with this frame goes on with the readers that do not have it.
  Outcome publish(LocalFrame* frame);
  // Reports the end of the stream to readers, also to those that come later.
  Outcome end();

  // Waits until there is a reader; false after the deadline or an interruption.
  bool wait_for_reader(const io::Deadline& deadline);
  // How often memory of frames that readers released has become free.
  uint64_t releases() const;
  // Waits until that has happened since `releases`, which was taken before there was too little
  // memory.
  enum class Release { Released, NoneHeld, Interrupted };
  Release wait_for_release(uint64_t releases);
  LocalPublisherCounts counts() const;

 private:
  explicit Publisher(LocalPublisherOptions options);
  int listening() const override { return listener_.get(); }
  Descriptor accept() override { return listener_.accept(); }
  void add(Descriptor socket) override;
  io::Deadline watch(const Clients& readers, std::vector<pollfd>* watched) override;
  void attend(const Client& reader, const pollfd* events, ReaderLink::Input input) override;
  void end_turn() override;
  void release() override;
  Clients active() const;
  // What to send to each reader, and whether it waits for a reader that holds `max_held` frames.
  struct Delivery {
    std::function<bool(ReaderLink&)> send;
    size_t max_held = SIZE_MAX;
    bool may_drop = false;
  };
  Outcome deliver(Lock* lock, const Client& reader, const Delivery& delivery);
  Outcome deliver_to_all(Lock* lock, const Delivery& delivery);

  const LocalPublisherOptions options_;
  const std::shared_ptr<isolate::SharedArena> arena_;
  Listener listener_;
  Garbage garbage_;  // of the server's thread
  // Guarded by the mutex.
  std::shared_ptr<const std::string> caps_;  // null before the first
  uint64_t last_number_ = 0, missed_ = 0, releases_ = 0;
  bool ended_ = false;
  bool has_garbage_ = false;  // frames that no reader holds and whose memory is not free yet
};

}  // namespace weir::local
