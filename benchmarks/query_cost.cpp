// Compares a request of tensor_query_client with a ping-pong of plain sockets that sends the same
// bytes: to a plain server that speaks the same protocol, and to a pipeline that is served
// (docs/benchmarks.md).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <sys/socket.h>
#include <sys/uio.h>

#include <cstring>
#include <memory>

#include "core/wire/edge_header.hpp"
#include "core/wire/edge_texts.hpp"
#include "element_stage.hpp"
#include "server_process.hpp"
#include "transport/edge/stream_socket.hpp"

namespace weir::bench {
namespace {

using edge::Descriptor;

constexpr size_t kHeader = wire::kLargestHeaderBytes;
// The header, and client_id and weir.seq with about as many digits as they have.
constexpr size_t kAround = kHeader + 48;

std::string caps_of(size_t bytes) {
  return "other/tensors,format=static,num_tensors=1,types=(string)uint8,dimensions=(string)" +
         std::to_string(bytes) + ",framerate=0/1";
}
void block(int socket) {
  fcntl(socket, F_SETFL, fcntl(socket, F_GETFL) & ~O_NONBLOCK);
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
Descriptor accepted(const Descriptor& listener) {
  block(listener.get());
  Descriptor out = edge::accept_from(listener.get());
  block(out.get());
  return out;
}
Descriptor listening() {
  auto out = value(edge::listen_on("127.0.0.1", 0));
  std::printf("port %u\n", edge::port_of(out.get()));
  std::fflush(stdout);
  return out;
}

// Sends back messages of `size` bytes.
int run_ping(size_t size) {
  const Descriptor socket = accepted(listening());
  std::vector<std::byte> message(size);
  while (read_all(socket, message.data(), size)) write_all(socket, message.data(), size);
  return 0;
}

// The same as a query server, for frames of `bytes` bytes.
int run_echo(size_t bytes) {
  const Descriptor requests = accepted(listening());
  const auto text = value(wire::query_capability_text({caps_of(bytes), caps_of(bytes)}));
  const auto greeting =
      value(wire::text_message(wire::HeaderForm::Bytes2088, wire::Command::Capability, 1, text));
  write_all(requests, greeting.data(), greeting.size());
  std::vector<std::byte> message(2 * kAround + bytes);
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
  const Descriptor answers = value(edge::connect_to("127.0.0.1", address.port, std::nullopt, -1));
  block(answers.get());
  while (const size_t size = read_message()) write_all(answers, message.data(), size);
  return 0;
}

int run_pipeline(size_t bytes) {
  gst_init(nullptr, nullptr);
  const auto pipeline =
      launched("tensor_query_serversrc name=source port=0 max-message=1000000000 ! " +
               caps_of(bytes) + " ! tensor_query_serversink async=false sync=false");
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  const auto source =
      gst::Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline.get()), "source"));
  guint port = 0;
  g_object_get(source.get(), "port", &port, nullptr);
  std::printf("port %u\n", port);
  std::fflush(stdout);
  while (std::getchar() != EOF) {
  }
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  return 0;
}

// What sends frames of one size and waits for their answers.
class Exchanges {
 public:
  explicit Exchanges(size_t bytes)
      : message_(kAround + bytes),
        ping_({"ping", std::to_string(message_.size())}),
        echo_({"echo", std::to_string(bytes)}),
        pipeline_({"pipeline", std::to_string(bytes)}),
        socket_(value(edge::connect_to("127.0.0.1", static_cast<uint32_t>(std::stoul(ping_.port())),
                                       std::nullopt, -1))) {
    block(socket_.get());
    to_echo_ = stage(echo_, bytes);
    to_pipeline_ = stage(pipeline_, bytes);
  }
  static constexpr const char* kNames[] = {"plain sockets", "tensor_query_client to plain sockets",
                                           "tensor_query_client to tensor_query_serversrc"};
  // Medians of a round trip in microseconds, in the order of kNames.
  std::vector<double> medians(int exchanges) {
    return {median_of(exchanges,
                      [this] {
                        write_all(socket_, message_.data(), message_.size());
                        if (!read_all(socket_, message_.data(), message_.size())) std::exit(1);
                      }),
            median_of(exchanges, [this] { to_echo_->push(1); }),
            median_of(exchanges, [this] { to_pipeline_->push(1); })};
  }
  uint64_t unanswered() const {
    return to_echo_->stat("sent") - to_echo_->stat("answered") + to_pipeline_->stat("sent") -
           to_pipeline_->stat("answered");
  }

 private:
  static std::unique_ptr<ElementStage> stage(const ServerProcess& server, size_t bytes) {
    return std::make_unique<ElementStage>(
        "tensor_query_client port=0 timeout=60000 max-message=1000000000 dest-port=" +
            server.port(),
        caps_of(bytes).c_str(), bytes);
  }
  template <class Exchange>
  static double median_of(int exchanges, const Exchange& exchange) {
    std::vector<double> times;
    for (int i = -exchanges / 10; i < exchanges; ++i) {
      const double before = seconds(CLOCK_MONOTONIC);
      exchange();
      if (i >= 0) times.push_back((seconds(CLOCK_MONOTONIC) - before) * 1e6);
    }
    return median(times);
  }

  std::vector<std::byte> message_;
  ServerProcess ping_, echo_, pipeline_;
  Descriptor socket_;
  std::unique_ptr<ElementStage> to_echo_, to_pipeline_;
};

std::vector<double> over_rounds_of(size_t bytes, int rounds, uint64_t* unanswered) {
  Exchanges exchanges(bytes);
  const int count = std::clamp(static_cast<int>(100'000'000 / (bytes + 50'000)), 20, 1000);
  std::vector<std::vector<double>> all(std::size(Exchanges::kNames));
  for (int round = 0; round < rounds; ++round) {
    const auto medians = exchanges.medians(count);
    for (size_t i = 0; i < all.size(); ++i) all[i].push_back(medians[i]);
  }
  if (unanswered) *unanswered += exchanges.unanswered();
  std::vector<double> out;
  for (const auto& times : all) out.push_back(median(times));
  return out;
}

// For tools/plot.
int report_sizes() {
  for (size_t bytes = 1 << 10; bytes <= 1 << 24; bytes *= 4) {
    const auto times = over_rounds_of(bytes, 3, nullptr);
    for (size_t i = 0; i < times.size(); ++i)
      std::printf("{\"series\": \"%s\", \"axis\": \"bytes\", \"x\": %zu, \"us\": %.1f}\n",
                  Exchanges::kNames[i], bytes, times[i]);
    std::fflush(stdout);
  }
  return 0;
}

int report_ratios(int rounds) {
  uint64_t unanswered = 0;
  for (const auto& [bytes, text] :
       {std::pair<size_t, const char*>{4096, "4 KiB"}, {150'528, "150 kB"}, {6'220'800, "6 MB"}}) {
    const auto times = over_rounds_of(bytes, rounds, &unanswered);
    std::fprintf(stderr, "%s: us: plain sockets %.1f, client %.1f, client and server %.1f\n", text,
                 times[0], times[1], times[2]);
    const std::string frame = std::string(", ") + text + " there and back: p50";
    report("tensor_query_client" + frame, "the same bytes by plain sockets", times[1] / times[0],
           "x", 1.2);
    report("tensor_query_client to tensor_query_serversrc" + frame,
           "the same bytes by plain sockets", times[2] / times[0], "x", 2);
  }
  report("tensor_query_client: frames without an answer", "", static_cast<double>(unanswered),
         "frames", 0);
  return 0;
}

}  // namespace
}  // namespace weir::bench

// Usage: query_cost [ROUNDS], or query_cost sizes. The other forms are its servers.
int main(int argc, char** argv) {
  using namespace weir::bench;
  const std::string what = argc > 1 ? argv[1] : "5";
  const size_t size = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 0;
  if (what == "ping") return run_ping(size);
  if (what == "echo") return run_echo(size);
  if (what == "pipeline") return run_pipeline(size);
  gst_init(nullptr, nullptr);
  return what == "sizes" ? report_sizes() : report_ratios(std::atoi(what.c_str()));
}
