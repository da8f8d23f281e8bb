// Compares a pipeline that serves NNStreamer's query clients with a bare exchange of as many bytes
// over one TCP connection: the median time of a request and its answer.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "core/wire/edge_header.hpp"
#include "core/wire/edge_metadata.hpp"
#include "rounds.hpp"
#include "served_line.hpp"
#include "server_process.hpp"

namespace weir::bench {
namespace {

using Bytes = std::vector<std::byte>;
constexpr auto kForm = wire::HeaderForm::Bytes2088;
constexpr size_t kHeaderBytes = 2088;

// Ends the program when a call of the system fails.
int checked(int result, const char* what) {
  if (result >= 0) return result;
  std::perror(what);
  std::exit(1);
}
int tcp_socket() {
  const int out = checked(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0), "socket");
  const int yes = 1;
  setsockopt(out, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  return out;
}
sockaddr_in loopback(uint16_t port) {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_port = htons(port);
  out.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return out;
}
int connected_to(const std::string& port) {
  const auto address = loopback(static_cast<uint16_t>(std::stoi(port)));
  const int out = tcp_socket();
  checked(connect(out, reinterpret_cast<const sockaddr*>(&address), sizeof address), "connect");
  return out;
}
struct Listener {
  int socket = tcp_socket();
  uint16_t port = 0;
  Listener() {
    auto address = loopback(0);
    socklen_t size = sizeof address;
    checked(bind(socket, reinterpret_cast<sockaddr*>(&address), size), "bind");
    checked(listen(socket, 1), "listen");
    checked(getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size), "getsockname");
    port = ntohs(address.sin_port);
  }
  int accepted() const {
    const int out = checked(accept4(socket, nullptr, nullptr, SOCK_CLOEXEC), "accept");
    const int yes = 1;
    setsockopt(out, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    return out;
  }
};

void send_all(int socket, const Bytes& bytes) {
  for (size_t sent = 0; sent < bytes.size();) {
    const ssize_t more = send(socket, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (more <= 0) std::exit(1);
    sent += static_cast<size_t>(more);
  }
}
// False at the end of the connection.
bool receive_all(int socket, Bytes* bytes) {
  for (size_t got = 0; got < bytes->size();) {
    const ssize_t more = recv(socket, bytes->data() + got, bytes->size() - got, 0);
    if (more <= 0) return false;
    got += static_cast<size_t>(more);
  }
  return true;
}

// The bare server: what it received goes back once all of it is there.
int run_bare(size_t bytes) {
  const Listener listener;
  std::printf("port %u\n", listener.port);
  std::fflush(stdout);
  const int connection = listener.accepted();
  Bytes message(bytes);
  while (receive_all(connection, &message)) send_all(connection, message);
  return 0;
}

// A request of one memory; its answer is as long.
Bytes request_of(int64_t client, size_t bytes) {
  wire::EdgeMetadata metadata;
  if (!metadata.set("client_id", std::to_string(client))) std::exit(1);
  const Bytes pairs = metadata.encode();
  Bytes out = value(wire::write_header(kForm, {.command = wire::Command::TransferData,
                                               .client_id = client,
                                               .sizes = {bytes},
                                               .metadata_bytes = pairs.size()}));
  out.resize(out.size() + bytes);
  out.insert(out.end(), pairs.begin(), pairs.end());
  return out;
}

// A client of raw sockets, to which the server opens the second connection.
class Client {
 public:
  Client(const std::string& port, size_t bytes) : requests_(connected_to(port)) {
    const Listener listener;
    Bytes header(kHeaderBytes);
    if (!receive_all(requests_, &header)) std::exit(1);
    const auto greeting = value(wire::read_header(kForm, header, {}));
    Bytes text(greeting.sizes[0]);
    if (!receive_all(requests_, &text)) std::exit(1);
    send_all(requests_, value(wire::text_message(kForm, wire::Command::HostInfo, greeting.client_id,
                                                 "127.0.0.1:" + std::to_string(listener.port))));
    answers_ = listener.accepted();
    close(listener.socket);
    request_ = request_of(greeting.client_id, bytes);
    answer_.resize(request_.size());
  }
  size_t message_bytes() const { return request_.size(); }
  void call() {
    send_all(requests_, request_);
    if (!receive_all(answers_, &answer_)) std::exit(1);
  }

 private:
  int requests_, answers_ = -1;
  Bytes request_, answer_;
};

void compare(size_t bytes, const char* size, int rounds) {
  const ServerProcess server(
      {"pipeline",
       "tensor_query_serversrc name=source port=0 "
       "caps=other/tensors,format=static,num_tensors=1,dimensions=(string)" +
           std::to_string(bytes) +
           ",types=(string)uint8,framerate=0/1 ! identity ! tensor_query_serversink"});
  Client client(server.port(), bytes);
  const ServerProcess bare({"bare", std::to_string(client.message_bytes())});
  const int connection = connected_to(bare.port());
  Bytes sent(client.message_bytes()), received(sent.size());
  const Call calls[] = {[&](int) {
                          send_all(connection, sent);
                          if (!receive_all(connection, &received)) std::exit(1);
                        },
                        [&](int) { client.call(); }};
  std::vector<double> ratios, floor, ours;
  for (int round = 0; round <= rounds; ++round) {
    std::vector<double> times[2];
    for (int i = 0; i < 300; ++i)  // in turn, so that other load affects both alike
      for (size_t which = 0; which < 2; ++which)
        times[which].push_back(times_of(calls[which], 1, 1)[0]);
    if (round == 0) continue;
    floor.push_back(median(times[0]));
    ours.push_back(median(times[1]));
    ratios.push_back(ours.back() / floor.back());
  }
  std::fprintf(stderr, "%s: bare %.1f us, served %.1f us\n", size, 1000 * median(floor),
               1000 * median(ours));
  report("a pipeline that serves query clients, " + std::string(size) + " both ways: p50",
         "a bare exchange of as many bytes over one TCP connection", median(ratios), "x", 1.2);
}

}  // namespace
}  // namespace weir::bench

// Usage: edge_query_cost [ROUNDS]
int main(int argc, char** argv) {
  using namespace weir::bench;
  const std::string role = argc > 2 ? argv[1] : "";
  if (role == "bare") return run_bare(static_cast<size_t>(std::atoll(argv[2])));
  if (role == "pipeline") {
    gst_init(nullptr, nullptr);
    return run_served_line(argv[2]);
  }
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 15;
  compare(4096, "4 KiB", rounds);
  compare(150'528, "150 kB", rounds);
  compare(6'220'800, "6 MB", rounds);
}
