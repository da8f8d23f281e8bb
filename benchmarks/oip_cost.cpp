// Compares the engine oip with plain calls of grpc++, to the same server with the same bytes: the
// median time of a call, and calls per second with several in flight. Also measures what the engine
// does when a server is killed or stopped.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "core/infer/model/model.hpp"
#include "core/infer/module/held_frame.hpp"
#include "core/infer/module/module_library.hpp"
#include "plain_grpc.hpp"
#include "rounds.hpp"

namespace weir::bench {
namespace {

using Clock = std::chrono::steady_clock;
constexpr size_t kSmall = 150'528 / sizeof(float), kLarge = 6'220'800 / sizeof(float);

double milliseconds_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

// This program as a server, in a process of its own.
class ServerProcess {
 public:
  ServerProcess(size_t elements, std::string port = "0") {
    int out[2], in[2];
    if (pipe2(out, O_CLOEXEC) != 0 || pipe2(in, O_CLOEXEC) != 0) std::exit(1);
    std::string count = std::to_string(elements), self = "/proc/self/exe", role = "server";
    char* argv[] = {self.data(), role.data(), count.data(), port.data(), nullptr};
    process_ = fork();
    if (process_ == 0) {
      dup2(in[0], 0);
      dup2(out[1], 1);
      execv(argv[0], argv);
      _exit(127);
    }
    close(in[0]), close(out[1]);
    input_ = in[1];
    std::string line;
    for (char next = 0; read(out[0], &next, 1) == 1 && next != '\n';) line += next;
    close(out[0]);
    if (line.rfind("port ", 0) != 0) std::exit(1);
    port_ = line.substr(5);
  }
  ~ServerProcess() {
    end();
    close(input_);
  }
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;
  const std::string& port() const { return port_; }
  std::string address() const { return "grpc://127.0.0.1:" + port_ + "/plain/1"; }
  void signal(int number) const { kill(process_, number); }
  void end() {
    if (process_ <= 0) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    process_ = -1;
  }

 private:
  pid_t process_ = -1;
  int input_ = -1;
  std::string port_;
};

template <class T>
T value(Result<T> result) {
  if (result) return *std::move(result);
  std::fprintf(stderr, "%s\n", result.error().message().c_str());
  std::exit(1);
}

// One thread's frames to the engine: it reads and writes memory that stays.
class Engine {
 public:
  Engine(const std::vector<std::string>& addresses, size_t elements)
      : elements_(elements), input_(elements, 1.5F) {
    infer::OpenOptions options;
    options.paths = addresses;
    options.options = {{"in-flight", "64"}, {"probe-ms", "100"}};
    const auto* engine = value(infer::ModuleLibrary::instance().engine("oip"));
    session_ = value(infer::Session::create(value(infer::Model::open(*engine, options))));
  }
  // Any thread; `output` has room for the elements. Whether it was answered.
  bool call(std::vector<float>* output) {
    weir_tensor in = tensor(input_.data()), out = tensor(output->data());
    weir_frame in_frame{}, out_frame{};
    in_frame.struct_size = out_frame.struct_size = sizeof in_frame;
    in_frame.n_tensors = out_frame.n_tensors = 1;
    in_frame.tensors = &in, out_frame.tensors = &out;
    Owner owner;
    const infer::FrameOwnerScope scope(in_frame, &owner);
    return value(session_->invoke(in_frame, out_frame));
  }
  size_t elements() const { return elements_; }

 private:
  struct Owner final : infer::FrameOwner {
    std::shared_ptr<const void> hold() override { return std::make_shared<int>(); }
  };
  weir_tensor tensor(float* data) const {
    weir_tensor out{};
    out.data = data;
    out.bytes = out.capacity = elements_ * sizeof(float);
    out.info.type = WEIR_FLOAT32;
    out.info.rank = 2;
    out.info.shape[0] = 1;
    out.info.shape[1] = static_cast<int64_t>(elements_);
    return out;
  }

  const size_t elements_;
  std::vector<float> input_;
  std::unique_ptr<infer::Session> session_;
};

// The bytes that the engine sends.
net::Pieces request_of(const std::vector<float>& x) {
  const int64_t shape[] = {1, static_cast<int64_t>(x.size())};
  const net::RequestTensor tensor{"x", "FP32", shape, std::as_bytes(std::span(x))};
  uint64_t copied = 0;
  return value(
      net::encode_infer_request("plain", "1", std::span(&tensor, 1), net::Contents::Raw, &copied));
}

using Call = std::function<void(int thread)>;

// Milliseconds of each call, by all threads.
std::vector<double> times_of(const Call& call, int threads, int calls) {
  std::vector<std::vector<double>> times(static_cast<size_t>(threads));
  const auto work = [&](int thread) {
    for (int i = 0; i < calls; ++i) {
      const auto begin = Clock::now();
      call(thread);
      times[static_cast<size_t>(thread)].push_back(milliseconds_since(begin));
    }
  };
  std::vector<std::thread> others;
  for (int i = 1; i < threads; ++i) others.emplace_back(work, i);
  work(0);
  for (auto& other : others) other.join();
  std::vector<double> all;
  for (const auto& some : times) all.insert(all.end(), some.begin(), some.end());
  return all;
}

// Both kinds of calls to one server.
struct Pair {
  explicit Pair(size_t elements, int threads)
      : server(elements),
        client(server.port()),
        engine({server.address()}, elements),
        input(elements, 1.5F),
        outputs(static_cast<size_t>(threads), std::vector<float>(elements)) {}
  Call plain() {
    return [this](int thread) {
      auto& to = outputs[static_cast<size_t>(thread)];
      const std::span room(reinterpret_cast<char*>(to.data()), to.size() * sizeof(float));
      if (client.call("ModelInfer", request_of(input), room) == 0) std::exit(1);
    };
  }
  Call by_engine() {
    return [this](int thread) {
      if (!engine.call(&outputs[static_cast<size_t>(thread)])) std::exit(1);
    };
  }
  ServerProcess server;
  PlainClient client;
  Engine engine;
  std::vector<float> input;
  std::vector<std::vector<float>> outputs;
};

void compare(size_t elements, const char* size, double most, int calls, int rounds) {
  constexpr int kInFlight = 4;
  Pair pair(elements, kInFlight);
  const Call plain = pair.plain(), engine = pair.by_engine();
  std::vector<double> p50, bare, rate;
  for (int round = 0; round <= rounds; ++round) {
    // In turn, so that other load affects both alike.
    std::vector<double> floors, times;
    for (int i = 0; i < calls; ++i) {
      floors.push_back(times_of(plain, 1, 1)[0]);
      times.push_back(times_of(engine, 1, 1)[0]);
    }
    const double floor = median(floors), ours = median(times);
    const auto timed = [&](const Call& call) {
      const auto begin = Clock::now();
      times_of(call, kInFlight, calls / kInFlight);
      return milliseconds_since(begin);
    };
    const double floor_all = timed(plain), ours_all = timed(engine);
    if (round == 0) continue;
    p50.push_back(ours / floor);
    bare.push_back(floor);
    rate.push_back(ours_all / floor_all);
  }
  const std::string name = std::string("engine oip, ") + size + " both ways";
  const std::string of_a_call = std::to_string(static_cast<int>(1000 * median(bare))) + " us";
  report(name + ": p50 of a call", "plain grpc++ generic calls, " + of_a_call, median(p50), "x",
         most);
  report(name + ": time of calls, 4 in flight", "the same, 4 in flight", median(rate), "x",
         1 / 0.95);
}

uint64_t requests_at(const PlainClient& client) {
  char text[32] = "";
  client.call("Requests", net::encode_model_request("plain", "1"), std::span(text, 31));
  return std::strtoull(text, nullptr, 10);
}

// Seconds until the server gets requests.
double until_used(Engine& engine, const PlainClient& client, std::vector<float>* out) {
  const auto begin = Clock::now();
  const uint64_t before = requests_at(client);
  while (requests_at(client) == before && milliseconds_since(begin) < 30e3) engine.call(out);
  return milliseconds_since(begin) / 1000;
}

void fail_over() {
  ServerProcess first(kSmall), second(kSmall);
  Engine engine({first.address(), second.address()}, kSmall);
  std::vector<float> out(kSmall);
  int lost = 0;
  for (int i = 0; i < 400; ++i) {
    if (i == 200) first.end();
    lost += !engine.call(&out);
  }
  report("engine oip, one of two servers killed: frames lost", "2 attempts", lost, "frames", 0);
  ServerProcess again(kSmall, first.port());
  report("engine oip, that server back: until it is used", "probes each 100 ms",
         until_used(engine, PlainClient(again.port()), &out), "s", 2);
  for (int i = 0; i < 100; ++i) engine.call(&out);
  second.signal(SIGSTOP);
  const auto begin = Clock::now();
  double moved = 0;
  lost = 0;
  for (int i = 0; i < 200; ++i) {
    const auto call = Clock::now();
    lost += !engine.call(&out);
    if (milliseconds_since(call) > 25) moved = milliseconds_since(begin) / 1000;
  }
  report("engine oip, one of two servers stopped: until calls are quick again", "25 ms", moved, "s",
         1);
  report("engine oip, one of two servers stopped: frames lost", "2 attempts", lost, "frames", 0);
  second.signal(SIGCONT);
  report("engine oip, that server goes on: until it is used", "probes each 100 ms",
         until_used(engine, PlainClient(second.port()), &out), "s", 2);
}

// Throughput and the 99th percentile for several clients at a time.
void clients() {
  for (int threads = 1; threads <= 64; threads *= 2) {
    Pair pair(kSmall, threads);
    for (const auto& [series, call] :
         {std::pair{"plain grpc++", pair.plain()}, std::pair{"engine oip", pair.by_engine()}}) {
      times_of(call, threads, 10);
      const auto begin = Clock::now();
      auto times = times_of(call, threads, std::max(50, 2000 / threads));
      const double took = milliseconds_since(begin) / 1000;
      const auto at = times.begin() + static_cast<std::ptrdiff_t>(times.size() * 99 / 100);
      std::nth_element(times.begin(), at, times.end());
      std::printf("{\"series\": \"%s\", \"axis\": \"throughput\", \"x\": %d, \"per_s\": %.1f}\n",
                  series, threads, static_cast<double>(times.size()) / took);
      std::printf("{\"series\": \"%s\", \"axis\": \"p99\", \"x\": %d, \"ms\": %.3f}\n", series,
                  threads, *at);
    }
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
