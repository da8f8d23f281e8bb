// Unix sockets by path: SOCK_SEQPACKET, never blocking.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/local/local_socket.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace weir::local {
namespace {

constexpr int kBacklog = 16;

Error unusable(const std::string& path, const std::string& reason) {
  return Error{.code = Code::OPTION_VALUE,
               .what = "the path of a local stream cannot be used",
               .offered = "path=" + path + ": " + reason,
               .needed = "a path in a folder that this user can write, such as /run/user/1000",
               .fix = "path=/tmp/weir-stream"};
}

Result<sockaddr_un> make_address(const std::string& path) {
  sockaddr_un out{};
  out.sun_family = AF_UNIX;
  if (path.empty()) return unusable(path, "it is empty");
  if (path.size() >= sizeof out.sun_path)
    return unusable(path, "it has " + std::to_string(path.size()) + " bytes, more than " +
                              std::to_string(sizeof out.sun_path - 1));
  std::memcpy(out.sun_path, path.data(), path.size());
  return out;
}

Descriptor make_socket() {
  return Descriptor(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

int call(int (*function)(int, const sockaddr*, socklen_t), int socket, const sockaddr_un& to) {
  return function(socket, reinterpret_cast<const sockaddr*>(&to), sizeof to);
}

// OK if the file is a socket without a listener: it is removed.
Status remove_stale(const std::string& path, const sockaddr_un& address) {
  struct stat found {};
  if (lstat(path.c_str(), &found) != 0) return unusable(path, std::strerror(errno));
  if (!S_ISSOCK(found.st_mode)) return unusable(path, "the file exists and is not a socket");
  const Descriptor probe = make_socket();
  if (call(connect, probe.get(), address) == 0 || errno == EAGAIN)
    return unusable(path, "another process already listens on it");
  if (errno != ECONNREFUSED) return unusable(path, std::strerror(errno));
  if (unlink(path.c_str()) != 0 && errno != ENOENT) return unusable(path, std::strerror(errno));
  return ok();
}

// The only descriptor of a message; several are closed, and `cut` is set.
Descriptor get_descriptor(msghdr* head, bool* cut) {
  Descriptor out;
  for (cmsghdr* along = CMSG_FIRSTHDR(head); along; along = CMSG_NXTHDR(head, along)) {
    if (along->cmsg_level != SOL_SOCKET || along->cmsg_type != SCM_RIGHTS) continue;
    if (along->cmsg_len != CMSG_LEN(sizeof(int)) || out) {
      *cut = true;
      continue;
    }
    int number = -1;
    std::memcpy(&number, CMSG_DATA(along), sizeof number);
    out = Descriptor(number);
  }
  return out;
}

}  // namespace

Result<Listener> Listener::open(const std::string& path) {
  const auto address = make_address(path);
  if (!address) return address.error();
  Listener out;
  out.socket_ = make_socket();
  if (!out.socket_) return unusable(path, std::strerror(errno));
  fchmod(out.socket_.get(), S_IRUSR | S_IWUSR);  // before bind(): the mode of the file
  if (call(bind, out.socket_.get(), *address) != 0) {
    if (errno != EADDRINUSE) return unusable(path, std::strerror(errno));
    if (auto status = remove_stale(path, *address); !status) return status.error();
    if (call(bind, out.socket_.get(), *address) != 0) return unusable(path, std::strerror(errno));
  }
  struct stat made {};
  if (lstat(path.c_str(), &made) != 0 || listen(out.socket_.get(), kBacklog) != 0)
    return unusable(path, std::strerror(errno));
  out.path_ = path;
  out.inode_ = made.st_ino;
  return out;
}

Listener::~Listener() {
  struct stat now {};
  if (socket_ && lstat(path_.c_str(), &now) == 0 && now.st_ino == inode_) unlink(path_.c_str());
}

Descriptor Listener::accept() const {
  return Descriptor(accept4(socket_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
}

Result<Descriptor> connect_to(const std::string& path) {
  const auto address = make_address(path);
  if (!address) return address.error();
  Descriptor out = make_socket();
  if (!out) return unusable(path, std::strerror(errno));
  if (call(connect, out.get(), *address) == 0) return out;
  return Error{.code = Code::SERVER_UNREACHABLE,
               .what = "no process writes to this local stream",
               .offered = "path=" + path + ": " + std::strerror(errno),
               .needed = "an edgesink with the same path that is already running",
               .fix = "reconnect=true, which waits for the edgesink"};
}

std::optional<uid_t> user_of_peer(int socket) noexcept {
  ucred peer{};
  socklen_t size = sizeof peer;
  if (getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) return std::nullopt;
  return peer.uid;
}

Transfer send_packet(int socket, std::span<const std::byte> packet, int descriptor) noexcept {
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  iovec part{const_cast<std::byte*>(packet.data()), packet.size()};
  msghdr head{};
  head.msg_iov = &part;
  head.msg_iovlen = 1;
  if (descriptor >= 0) {
    head.msg_control = control;
    head.msg_controllen = sizeof control;
    cmsghdr* const along = CMSG_FIRSTHDR(&head);
    along->cmsg_level = SOL_SOCKET;
    along->cmsg_type = SCM_RIGHTS;
    along->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(along), &descriptor, sizeof descriptor);
  }
  ssize_t sent = -1;
  do {
    sent = sendmsg(socket, &head, MSG_NOSIGNAL | MSG_DONTWAIT);
  } while (sent < 0 && errno == EINTR);
  if (sent >= 0) return Transfer::Done;
  return errno == EAGAIN || errno == EWOULDBLOCK || errno == ENOBUFS ? Transfer::WouldWait
                                                                     : Transfer::Closed;
}

Transfer receive_packet(int socket, std::span<std::byte> into, Packet* out) noexcept {
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  iovec part{into.data(), into.size()};
  msghdr head{};
  ssize_t got = -1;
  do {
    head = {};
    head.msg_iov = &part;
    head.msg_iovlen = 1;
    head.msg_control = control;
    // Room for one: the kernel closes the others.
    head.msg_controllen = CMSG_LEN(sizeof(int));
    got = recvmsg(socket, &head, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
    // ECONNRESET: the peer closed before it had read all; what it sent can still be read.
  } while (got < 0 && (errno == EINTR || errno == ECONNRESET));
  if (got < 0)
    return errno == EAGAIN || errno == EWOULDBLOCK ? Transfer::WouldWait : Transfer::Closed;
  if (got == 0) return Transfer::Closed;
  *out = {};
  out->cut = (head.msg_flags & (MSG_TRUNC | MSG_CTRUNC)) != 0;
  out->descriptor = get_descriptor(&head, &out->cut);
  out->bytes = into.first(static_cast<size_t>(got));
  return Transfer::Done;
}

}  // namespace weir::local
