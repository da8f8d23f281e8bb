// Unix sockets of whole packets between processes of one user.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "machine/descriptor.hpp"
#include "weir/result.hpp"

namespace weir::local {

using io::Descriptor;

// A listening socket and the file that it owns: removed with the object unless another process
// has replaced it.
class Listener {
 public:
  // Replaces the socket file of a process that has ended; only this user can connect.
  // Errors: OPTION_VALUE for a path that cannot be used, or that another process listens on.
  static Result<Listener> open(const std::string& path);
  Listener() = default;
  Listener(Listener&& other) noexcept = default;
  Listener& operator=(Listener&& other) noexcept = default;
  ~Listener();

  int get() const noexcept { return socket_.get(); }
  // Non-blocking; no descriptor if no peer waits.
  Descriptor accept() const;

 private:
  Descriptor socket_;
  std::string path_;
  ino_t inode_ = 0;
};

// Errors: OPTION_VALUE for a path that cannot be used, SERVER_UNREACHABLE if no process listens.
Result<Descriptor> connect_to(const std::string& path);

// The user of the process at the other end; nullopt if the kernel does not tell.
std::optional<uid_t> user_of_peer(int socket) noexcept;

enum class Transfer { Done, WouldWait, Closed };

// Sends one packet, with `descriptor` if it is >= 0. Never blocks.
Transfer send_packet(int socket, std::span<const std::byte> packet, int descriptor = -1) noexcept;

struct Packet {
  std::span<const std::byte> bytes;  // in `into` of receive_packet()
  Descriptor descriptor;
  bool cut = false;  // it was longer than `into`, or brought several descriptors
};
// Receives one packet. Never blocks.
Transfer receive_packet(int socket, std::span<std::byte> into, Packet* out) noexcept;

}  // namespace weir::local
