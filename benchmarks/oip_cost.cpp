// Compares the engine oip with plain calls of grpc++, to the same server with the same bytes: the
// median time of a call, and calls per second with several in flight. Also measures what the engine
// does when a server is killed or stopped.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <numeric>

#include "oip_client.hpp"
#include "plain_grpc.hpp"
#include "rounds.hpp"
#include "server_process.hpp"

namespace weir::bench {
namespace {

constexpr size_t kSmall = 150'528 / sizeof(float), kLarge = 6'220'800 / sizeof(float);
constexpr int kRepeats = 3;  // of what happens with a server

struct PlainProcess : ServerProcess {
  explicit PlainProcess(size_t elements, const std::string& port = "0")
      : ServerProcess({"server", std::to_string(elements), port}) {}
  std::string address() const { return "grpc://127.0.0.1:" + port() + "/plain/1"; }
};

OipClient make_client(const std::vector<std::string>& addresses, size_t elements) {
  weir_tensor_info info{};
  info.type = WEIR_FLOAT32;
  info.rank = 2;
  info.shape[0] = 1;
  info.shape[1] = static_cast<int64_t>(elements);
  return {addresses, info, elements * sizeof(float)};
}

// The bytes that the engine sends.
net::Pieces make_request(const std::vector<float>& x) {
  const int64_t shape[] = {1, static_cast<int64_t>(x.size())};
  const net::RequestTensor tensor{"x", "FP32", shape, std::as_bytes(std::span(x))};
  uint64_t copied = 0;
  return value(net::encode_infer_request("plain", "1", std::span(&tensor, 1), net::Contents::Raw,
                                         false, &copied));
}

// Both kinds of calls to one server.
struct Pair {
  explicit Pair(size_t elements, int threads)
      : server(elements),
        client(server.port()),
        engine(make_client({server.address()}, elements)),
        input(elements, 1.5F),
        outputs(static_cast<size_t>(threads), std::vector<float>(elements)) {}
  Call plain() {
    return [this](int thread) {
      auto& to = outputs[static_cast<size_t>(thread)];
      const std::span room(reinterpret_cast<char*>(to.data()), to.size() * sizeof(float));
      if (client.call("ModelInfer", make_request(input), room) == 0) std::exit(1);
    };
  }
  Call by_engine() {
    return [this](int thread) {
      if (!engine.call(outputs[static_cast<size_t>(thread)].data())) std::exit(1);
    };
  }
  PlainProcess server;
  PlainClient client;
  OipClient engine;
  std::vector<float> input;
  std::vector<std::vector<float>> outputs;
};

void compare(size_t elements, const char* size, double max, int calls, int rounds) {
  constexpr int kInFlight = 4;
  Pair pair(elements, kInFlight);
  const Call plain = pair.plain(), engine = pair.by_engine();
  std::vector<double> p50, bare, rate;
  for (int round = 0; round <= rounds; ++round) {
    const auto medians = medians_in_turn({plain, engine}, calls);
    const auto timed = [&](const Call& call) {
      const auto begin = Clock::now();
      measure_times(call, kInFlight, calls / kInFlight);
      return milliseconds_since(begin);
    };
    const double floor_all = timed(plain), ours_all = timed(engine);
    if (round == 0) continue;
    p50.push_back(medians[1] / medians[0]);
    bare.push_back(medians[0]);
    rate.push_back(ours_all / floor_all);
  }
  const std::string name = std::string("engine oip, ") + size + " both ways";
  const std::string of_a_call = std::to_string(static_cast<int>(median(bare))) + " us";
  report(name + ": p50 of a call", "plain grpc++ generic calls, " + of_a_call, median(p50), "x",
         max);
  report(name + ": time of calls, 4 in flight", "the same, 4 in flight", median(rate), "x",
         1 / 0.95);
}

uint64_t requests_at(const PlainClient& client) {
  char text[32] = "";
  client.call("Requests", net::encode_model_request("plain", "1"), std::span(text, 31));
  return std::strtoull(text, nullptr, 10);
}

// Seconds until the server gets requests. Those that it was sent before it stopped are none.
double until_used(OipClient& engine, const PlainClient& client, float* out) {
  const auto begin = Clock::now();
  uint64_t before = requests_at(client);
  for (int same = 0; same < 50; ++same)
    if (const uint64_t now = requests_at(client); now != before) before = now, same = 0;
  while (requests_at(client) == before && milliseconds_since(begin) < 30e3) engine.call(out);
  return milliseconds_since(begin) / 1000;
}

// Seconds until the first of 20 calls in a row that take less than 25 ms each, and how many calls
// were lost until then. A single slow call later is other load.
double until_quick(OipClient& engine, float* out, int* lost) {
  const auto begin = Clock::now();
  double quick_since = 0;
  for (int quick = 0; quick < 20 && milliseconds_since(begin) < 30e3;) {
    const auto call = Clock::now();
    if (quick == 0) quick_since = milliseconds_since(begin) / 1000;
    *lost += !engine.call(out);
    quick = milliseconds_since(call) < 25 ? quick + 1 : 0;
  }
  return quick_since;
}

// Of each repeat.
struct FailOver {
  std::vector<double> killed_lost, back, stopped_quick, stopped_lost, resumed;
};

void fail_over_once(FailOver* out) {
  PlainProcess first(kSmall), second(kSmall);
  OipClient engine = make_client({first.address(), second.address()}, kSmall);
  std::vector<float> output(kSmall);
  int lost = 0;
  for (int i = 0; i < 400; ++i) {
    if (i == 200) first.end();
    lost += !engine.call(output.data());
  }
  out->killed_lost.push_back(lost);
  const PlainProcess again(kSmall, first.port());
  out->back.push_back(until_used(engine, PlainClient(again.port()), output.data()));
  for (int i = 0; i < 100; ++i) engine.call(output.data());
  second.signal(SIGSTOP);
  lost = 0;
  out->stopped_quick.push_back(until_quick(engine, output.data(), &lost));
  for (int i = 0; i < 200; ++i) lost += !engine.call(output.data());
  out->stopped_lost.push_back(lost);
  second.signal(SIGCONT);
  out->resumed.push_back(until_used(engine, PlainClient(second.port()), output.data()));
}

void fail_over() {
  FailOver found;
  for (int i = 0; i < kRepeats; ++i) fail_over_once(&found);
  const auto sum = [](const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
  };
  report("engine oip, one of two servers killed: frames lost", "2 attempts", sum(found.killed_lost),
         "frames", 0);
  report("engine oip, that server back: until it is used", "probes each 100 ms", median(found.back),
         "s", 2);
  report("engine oip, one of two servers stopped: until calls are quick again", "25 ms",
         median(found.stopped_quick), "s", 1);
  report("engine oip, one of two servers stopped: frames lost", "2 attempts",
         sum(found.stopped_lost), "frames", 0);
  report("engine oip, that server goes on: until it is used", "probes each 100 ms",
         median(found.resumed), "s", 2);
}

// Throughput and the 99th percentile for several clients at a time.
void clients() {
  for (int threads = 1; threads <= 64; threads *= 2) {
    Pair pair(kSmall, threads);
    report_clients({{"plain grpc++", pair.plain()}, {"engine oip", pair.by_engine()}}, threads);
  }
}

}  // namespace
}  // namespace weir::bench

// Usage: oip_cost [ROUNDS], or oip_cost clients; WEIR_MODULE_PATH has the module.
int main(int argc, char** argv) {
  using namespace weir::bench;
  const std::string what = argc > 1 ? argv[1] : "";
  if (what == "server" && argc == 4) {
    PlainServer(std::strtoul(argv[2], nullptr, 10)).run(argv[3]);
    return 0;
  }
  signal(SIGPIPE, SIG_IGN);
  if (what == "clients") {
    clients();
    return 0;
  }
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 11;
  compare(kSmall, "150 kB", 1.10, 200, rounds);
  compare(kLarge, "6 MB", 1.05, 40, rounds);
  fail_over();
}
