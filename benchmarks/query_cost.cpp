// Compares requests in NNStreamer's protocol with a ping-pong of plain sockets that sends the same
// bytes: tensor_query_client to a plain server that speaks the protocol, a plain client to a
// pipeline that is served, and both elements together (docs/benchmarks.md).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <sys/socket.h>

#include <array>
#include <cstring>
#include <memory>

#include "core/wire/edge_capability.hpp"
#include "core/wire/edge_header.hpp"
#include "core/wire/edge_metadata.hpp"
#include "element_stage.hpp"
#include "served_line.hpp"
#include "server_process.hpp"
#include "transport/edge/stream_socket.hpp"

namespace weir::bench {
namespace {

using io::Descriptor;
using Bytes = std::vector<std::byte>;

constexpr auto kForm = wire::HeaderForm::Bytes2088;
constexpr size_t kHeader = wire::kMaxHeaderBytes;
// The header, and client_id and weir.seq with about as many digits as they have.
constexpr size_t kAround = kHeader + 48;

std::string make_caps(size_t bytes) {
  return "other/tensors,format=static,num_tensors=1,types=(string)uint8,dimensions=(string)" +
         std::to_string(bytes) + ",framerate=0/1";
}
void block(const Descriptor& socket) {
  fcntl(socket.get(), F_SETFL, fcntl(socket.get(), F_GETFL) & ~O_NONBLOCK);
}
// False at the end of the connection.
bool read_all(const Descriptor& socket, std::byte* data, size_t size) {
  return recv(socket.get(), data, size, MSG_WAITALL) == static_cast<ssize_t>(size);
}
void write_all(const Descriptor& socket, const std::byte* data, size_t size) {
  while (size > 0) {
    const ssize_t sent = send(socket.get(), data, size, MSG_NOSIGNAL);
    if (sent <= 0) std::exit(1);
    data += sent;
    size -= static_cast<size_t>(sent);
  }
}
Descriptor listening() {
  auto out = value(edge::listen_on("127.0.0.1", 0));
  block(out);
  return out;
}
Descriptor accepted(const Descriptor& listener) {
  Descriptor out = edge::accept_from(listener.get());
  block(out);
  return out;
}
Descriptor connected_to(uint32_t port) {
  auto out = value(edge::connect_to("127.0.0.1", port, std::nullopt, -1));
  block(out);
  return out;
}
Descriptor connected_to(const ServerProcess& server) {
  return connected_to(static_cast<uint32_t>(std::stoul(server.port())));
}
void print_port(const Descriptor& listener) {
  std::printf("port %u\n", edge::get_port(listener.get()));
  std::fflush(stdout);
}

// Sends back messages of `size` bytes, with a thread for each connection.
int run_ping(size_t size) {
  const Descriptor listener = listening();
  print_port(listener);
  for (;;)
    std::thread([size, socket = accepted(listener)] {
      Bytes message(size);
      while (read_all(socket, message.data(), size)) write_all(socket, message.data(), size);
    }).detach();
}

// The same as a query server of one client, for frames of `bytes` bytes.
int run_echo(size_t bytes) {
  const Descriptor listener = listening();
  print_port(listener);
  const Descriptor requests = accepted(listener);
  const auto text = value(wire::query_capability_text({make_caps(bytes), make_caps(bytes)}));
  const auto greeting = value(wire::text_message(kForm, wire::Command::Capability, 1, text));
  write_all(requests, greeting.data(), greeting.size());
  Bytes message(2 * kAround + bytes);
  // The bytes of the next message; 0 at the end.
  const auto read_message = [&]() -> size_t {
    for (size_t have = 0;;) {
      const ssize_t got = recv(requests.get(), &message[have], message.size() - have, 0);
      if (got <= 0) return 0;
      have += static_cast<size_t>(got);
      if (have < kHeader) continue;
      uint64_t memory = 0, metadata = 0;
      std::memcpy(&memory, &message[32], 8);
      std::memcpy(&metadata, &message[2080], 8);
      if (have >= kHeader + memory + metadata) return have;
    }
  };
  const size_t host_info = read_message();
  if (host_info == 0) return 1;
  const auto address = value(wire::parse_host_address(
      value(wire::text_of_memory(std::span(message).subspan(kHeader, host_info - kHeader)))));
  const Descriptor responses = connected_to(address.port);
  while (const size_t size = read_message()) write_all(responses, message.data(), size);
  return 0;
}

// A client of plain sockets, to which the server opens the second connection.
class PlainClient {
 public:
  PlainClient(const ServerProcess& server, size_t bytes) : requests_(connected_to(server)) {
    Bytes header(kHeader);
    if (!read_all(requests_, header.data(), header.size())) std::exit(1);
    const auto greeting = value(wire::read_header(kForm, header, {}));
    Bytes text(greeting.sizes[0]);
    if (!read_all(requests_, text.data(), text.size())) std::exit(1);
    const Descriptor listener = listening();
    const auto host_info =
        value(wire::text_message(kForm, wire::Command::HostInfo, greeting.client_id,
                                 "127.0.0.1:" + std::to_string(edge::get_port(listener.get()))));
    write_all(requests_, host_info.data(), host_info.size());
    responses_ = accepted(listener);
    make_request(greeting.client_id, bytes);
  }
  void call() {
    write_all(requests_, request_.data(), request_.size());
    if (!read_all(responses_, response_.data(), response_.size())) std::exit(1);
  }

 private:
  // Of one memory; the response is as long.
  void make_request(int64_t client, size_t bytes) {
    wire::EdgeMetadata metadata;
    if (!metadata.set("client_id", std::to_string(client))) std::exit(1);
    const Bytes pairs = metadata.encode();
    request_ = value(wire::write_header(kForm, {.command = wire::Command::TransferData,
                                                .client_id = client,
                                                .sizes = {bytes},
                                                .metadata_bytes = pairs.size()}));
    request_.resize(request_.size() + bytes);
    request_.insert(request_.end(), pairs.begin(), pairs.end());
    response_.resize(request_.size());
  }
  Descriptor requests_, responses_;
  Bytes request_, response_;
};

// A plain connection to run_ping().
class Ping {
 public:
  Ping(const ServerProcess& server, size_t bytes)
      : socket_(connected_to(server)), message_(kAround + bytes) {}
  static ServerProcess server(size_t bytes) {
    return ServerProcess({"ping", std::to_string(kAround + bytes)});
  }
  void call() {
    write_all(socket_, message_.data(), message_.size());
    if (!read_all(socket_, message_.data(), message_.size())) std::exit(1);
  }

 private:
  Descriptor socket_;
  Bytes message_;
};

std::unique_ptr<ElementStage> make_client(const ServerProcess& server, size_t bytes) {
  return std::make_unique<ElementStage>(
      "tensor_query_client port=0 timeout=60000 max-message=1000000000 dest-port=" + server.port(),
      make_caps(bytes).c_str(), bytes);
}
ServerProcess served_pipeline(size_t bytes) {
  return ServerProcess(
      {"pipeline", "tensor_query_serversrc name=source port=0 max-message=1000000000 caps=\"" +
                       make_caps(bytes) + "\" ! tensor_query_serversink"});
}

// What sends frames of one size and waits for their responses.
class Exchanges {
 public:
  explicit Exchanges(size_t bytes)
      : ping_server_(Ping::server(bytes)),
        echo_({"echo", std::to_string(bytes)}),
        pipeline_(served_pipeline(bytes)),
        ping_(ping_server_, bytes),
        plain_client_(pipeline_, bytes),
        to_echo_(make_client(echo_, bytes)),
        to_pipeline_(make_client(pipeline_, bytes)) {}
  static constexpr std::array kNames = {"plain sockets", "tensor_query_client to plain sockets",
                                        "plain sockets to tensor_query_serversrc",
                                        "tensor_query_client to tensor_query_serversrc"};

  // Medians of a round trip in microseconds, in the order of kNames.
  std::vector<double> medians(int exchanges) {
    return medians_in_turn(
        {[this](int) { ping_.call(); }, [this](int) { to_echo_->push(1); },
         [this](int) { plain_client_.call(); }, [this](int) { to_pipeline_->push(1); }},
        exchanges, exchanges / 10);
  }
  uint64_t unanswered() const {
    return to_echo_->stat("sent") - to_echo_->stat("answered") + to_pipeline_->stat("sent") -
           to_pipeline_->stat("answered");
  }

 private:
  const ServerProcess ping_server_, echo_, pipeline_;
  Ping ping_;
  PlainClient plain_client_;
  const std::unique_ptr<ElementStage> to_echo_, to_pipeline_;
};

Rounds times_of_rounds(size_t bytes, int rounds, uint64_t* unanswered) {
  Exchanges exchanges(bytes);
  const int count = std::clamp(static_cast<int>(100'000'000 / (bytes + 50'000)), 20, 1000);
  Rounds out;
  for (int round = 0; round < rounds; ++round) add_round(exchanges.medians(count), &out);
  *unanswered += exchanges.unanswered();
  return out;
}

// For tools/plot.
int report_sizes() {
  uint64_t unanswered = 0;
  for (size_t bytes = 1 << 10; bytes <= 1 << 24; bytes *= 4) {
    const auto times = times_of_rounds(bytes, 3, &unanswered);
    for (size_t i = 0; i < times.size(); ++i)
      std::printf("{\"series\": \"%s\", \"axis\": \"bytes\", \"x\": %zu, \"us\": %.1f}\n",
                  Exchanges::kNames[i], bytes, median(times[i]));
    std::fflush(stdout);
  }
  return unanswered == 0 ? 0 : 1;
}

// For tools/plot: requests of 150 kB of several clients at a time.
int report_clients_at_once() {
  constexpr size_t kBytes = 150'528;
  for (const int count : {1, 2, 4, 8, 16}) {
    const ServerProcess ping = Ping::server(kBytes), pipeline = served_pipeline(kBytes);
    std::vector<std::unique_ptr<Ping>> pings;
    std::vector<std::unique_ptr<ElementStage>> elements;
    for (int i = 0; i < count; ++i) {
      pings.push_back(std::make_unique<Ping>(ping, kBytes));
      elements.push_back(make_client(pipeline, kBytes));
    }
    report_clients(
        {{Exchanges::kNames[0], [&](int i) { pings[static_cast<size_t>(i)]->call(); }},
         {Exchanges::kNames[3], [&](int i) { elements[static_cast<size_t>(i)]->push(1); }}},
        count);
  }
  return 0;
}

int report_ratios(int rounds) {
  constexpr std::array kTargets = {1.0, 1.2, 1.2, 2.0};
  uint64_t unanswered = 0;
  for (const auto& [bytes, text] : kFrameSizes) {
    const auto times = times_of_rounds(bytes, rounds, &unanswered);
    for (size_t i = 0; i < times.size(); ++i) {
      std::fprintf(stderr, "%s: %s: %.1f us\n", text, Exchanges::kNames[i], median(times[i]));
      if (i == 0) continue;
      report(std::string(Exchanges::kNames[i]) + ", " + text + " there and back: p50",
             "the same bytes by plain sockets", median_ratio(times[0], times[i]), "x", kTargets[i]);
    }
  }
  report("tensor_query_client: frames without an answer", "", static_cast<double>(unanswered),
         "frames", 0);
  return 0;
}

}  // namespace
}  // namespace weir::bench

// Usage: query_cost [ROUNDS], query_cost sizes or query_cost clients. The other forms are its
// servers.
int main(int argc, char** argv) {
  using namespace weir::bench;
  const std::string what = argc > 1 ? argv[1] : "5";
  const std::string server = argc > 2 ? argv[2] : "";
  if (what == "ping") return run_ping(std::stoul(server));
  if (what == "echo") return run_echo(std::stoul(server));
  gst_init(nullptr, nullptr);
  if (what == "pipeline") return run_served_line(server);
  if (what == "sizes") return report_sizes();
  return what == "clients" ? report_clients_at_once() : report_ratios(std::stoi(what));
}
