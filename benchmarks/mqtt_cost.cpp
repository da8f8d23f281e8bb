// Compares a stream from mqttsink to mqttsrc with libmosquitto's own calls, with as many bytes
// through the same broker (docs/benchmarks.md).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <mosquitto.h>
#include <sys/prctl.h>

#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>

#include "core/wire/mqtt_header.hpp"
#include "element_stage.hpp"
#include "server_process.hpp"
#include "transport/edge/stream_socket.hpp"

namespace weir::bench {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
// Whatever takes longer ends the program: a message of QoS 0 that was dropped never comes.
constexpr auto kTimeout = 30s;
constexpr int kInFlight = 8;

[[noreturn]] void fail(const std::string& what) {
  std::fprintf(stderr, "%s\n", what.c_str());
  std::exit(1);
}

// A mosquitto on a free port, which ends with this program.
class Broker {
 public:
  Broker() {
    char name[] = "/tmp/weir-bench-XXXXXX";
    if (!mkdtemp(name)) fail("no folder for the broker");
    const fs::path folder = name;
    const std::string settings = folder / "broker.conf";
    port_ = free_port();
    // As another user it would not end with this program.
    std::ofstream(settings) << "user root\nlistener " << port_
                            << " 127.0.0.1\nallow_anonymous true\n"
                            << "set_tcp_nodelay true\nlog_type none\n";
    process_ = fork();
    if (process_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      // Without these, glibc may return the memory of a large message to the system after each one:
      // that depends on what lies next to it in memory, and makes the broker ten times slower.
      setenv("MALLOC_TRIM_THRESHOLD_", "1000000000", 1);
      setenv("MALLOC_MMAP_THRESHOLD_", "33554432", 1);
      for (const char* program : {"/usr/sbin/mosquitto", "/usr/local/sbin/mosquitto", "mosquitto"})
        execlp(program, program, "-c", settings.c_str(), nullptr);
      _exit(127);
    }
    const auto end = Clock::now() + kTimeout;
    while (!is_listening()) {
      if (waitpid(process_, nullptr, WNOHANG) != 0)
        fail("mosquitto does not start: apt-get install mosquitto");
      if (Clock::now() > end) fail("mosquitto does not listen");
      std::this_thread::sleep_for(1ms);
    }
    fs::remove_all(folder);
  }
  ~Broker() {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  Broker(const Broker&) = delete;
  Broker& operator=(const Broker&) = delete;
  int port() const { return port_; }

 private:
  static int free_port() { return edge::get_port(value(edge::listen_on("127.0.0.1", 0)).get()); }
  bool is_listening() const {
    return bool(edge::connect_to("127.0.0.1", static_cast<uint32_t>(port_), std::nullopt, -1));
  }

  int port_ = 0;
  pid_t process_ = -1;
};

// Frames of one size through the broker to one receiver or several.
class Stream {
 public:
  virtual ~Stream() = default;
  // Returns when the frame may be on its way.
  virtual void send() = 0;
  // Waits until all receivers have all frames but `less` of those that were sent.
  void wait(uint64_t less) {
    std::unique_lock lock(mutex_);
    const auto enough = [&] { return arrived_ + less * receivers_ >= sent_ * receivers_; };
    if (!changed_.wait_for(lock, kTimeout, enough))
      fail(name_ + ": of " + std::to_string(sent_ * receivers_) + " messages " +
           std::to_string(arrived_) + " arrived");
  }
  void send_one() {
    {
      const std::lock_guard lock(mutex_);
      ++sent_;
    }
    send();
  }

 protected:
  Stream(std::string name, int receivers)
      : name_(std::move(name)), receivers_(static_cast<uint64_t>(receivers)) {}
  void arrive() {
    const std::lock_guard lock(mutex_);
    ++arrived_;
    changed_.notify_one();
  }

 private:
  const std::string name_;
  const uint64_t receivers_;
  std::mutex mutex_;
  std::condition_variable changed_;
  uint64_t sent_ = 0, arrived_ = 0;
};

void check(int result, const char* what) {
  if (result != MOSQ_ERR_SUCCESS) fail(std::string(what) + ": " + mosquitto_strerror(result));
}

// libmosquitto with its own threads; messages as long as those of mqttsink, retained like them.
class BareStream : public Stream {
 public:
  static constexpr const char* kName = "libmosquitto";
  BareStream(int port, size_t bytes, int receivers)
      : Stream(kName, receivers), payload_(wire::kMqttHeaderBytes + bytes, std::byte{1}) {
    for (int i = 0; i <= receivers; ++i) {
      mosquitto* const client = mosquitto_new(nullptr, true, this);
      clients_.push_back(client);
      mosquitto_int_option(client, MOSQ_OPT_TCP_NODELAY, 1);
      mosquitto_message_callback_set(client, [](mosquitto*, void* self, const mosquitto_message*) {
        static_cast<BareStream*>(self)->arrive();
      });
      mosquitto_subscribe_callback_set(client, [](mosquitto*, void* self, int, int, const int*) {
        static_cast<BareStream*>(self)->subscribed();
      });
      check(mosquitto_connect(client, "127.0.0.1", port, 60), "connect");
      check(mosquitto_loop_start(client), "thread");
      if (i > 0) check(mosquitto_subscribe(client, nullptr, "bare", 2), "subscribe");
    }
    std::unique_lock lock(start_);
    if (!ready_.wait_for(lock, kTimeout, [&] { return subscribed_ == receivers; }))
      fail("the broker does not answer");
  }
  ~BareStream() override {
    for (mosquitto* client : clients_) {
      mosquitto_disconnect(client);
      mosquitto_loop_stop(client, true);
      mosquitto_destroy(client);
    }
  }
  void send() override {
    check(mosquitto_publish(clients_[0], nullptr, "bare", static_cast<int>(payload_.size()),
                            payload_.data(), 0, true),
          "publish");
  }

 private:
  void subscribed() {
    const std::lock_guard lock(start_);
    ++subscribed_;
    ready_.notify_one();
  }
  std::vector<std::byte> payload_;
  std::vector<mosquitto*> clients_;
  std::mutex start_;
  std::condition_variable ready_;
  int subscribed_ = 0;
};

// mqttsink, pushed to from this thread, and a pipeline for each receiver.
class ElementStream : public Stream {
 public:
  ElementStream(const std::string& name, int port, size_t bytes, int receivers)
      : Stream(name, receivers) {
    const std::string topic = "elements/" + name.substr(name.size() - 1);
    const std::string broker = " port=" + std::to_string(port) + " protocol=" + topic.back();
    for (int i = 0; i < receivers; ++i) {
      // The default of sub-timeout, 10 s, is shorter than the turns of the others may be.
      pipelines_.push_back(launched("mqttsrc sub-timeout=60000000 sub-topic=" + topic + broker +
                                    " ! fakesink name=out async=false sync=false "
                                    "signal-handoffs=true"));
      GstElement* const pipeline = pipelines_.back().get();
      const auto out = gst::Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline), "out"));
      g_signal_connect(out.get(), "handoff", G_CALLBACK(on_frame), this);
      gst_element_set_state(pipeline, GST_STATE_PLAYING);
      if (gst_element_get_state(pipeline, nullptr, nullptr, 10 * GST_SECOND) ==
          GST_STATE_CHANGE_FAILURE)
        fail("mqttsrc does not start");
    }
    sink_ = std::make_unique<ElementStage>("mqttsink async=false pub-topic=" + topic + broker,
                                           make_caps(bytes).c_str(), bytes);
  }
  ~ElementStream() override {
    for (const auto& pipeline : pipelines_) gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  }
  void send() override {
    // Written once, so that each memory of the pool has pages of its own.
    sink_->push(1, [this](GstBuffer* buffer) {
      if (filled_++ < kInFlight) gst_buffer_memset(buffer, 0, 1, gst_buffer_get_size(buffer));
    });
  }

 private:
  static std::string make_caps(size_t bytes) {
    return "other/tensors,format=static,num_tensors=1,types=(string)uint8,dimensions=(string)" +
           std::to_string(bytes) + ",framerate=0/1";
  }
  static void on_frame(GstElement*, GstBuffer*, GstPad*, ElementStream* self) { self->arrive(); }
  std::vector<gst::Ref<GstElement>> pipelines_;
  std::unique_ptr<ElementStage> sink_;
  int filled_ = 0;
};

// What is compared, at one broker. It is a new one for each size: it keeps the last message.
class Streams {
 public:
  Streams(size_t bytes, int receivers) {
    const int port = broker_.port();
    all_.push_back(std::make_unique<BareStream>(port, bytes, receivers));
    for (const char* name : {"mqttsink protocol=4", "mqttsink protocol=5"})
      all_.push_back(std::make_unique<ElementStream>(name, port, bytes, receivers));
    for (const auto& stream : all_)
      for (int i = 0; i < kInFlight; ++i) {
        stream->send_one();
        stream->wait(0);
      }
  }
  static constexpr const char* kNames[] = {BareStream::kName, "mqttsink protocol=4",
                                           "mqttsink protocol=5"};
  // Medians in microseconds from a frame's start until all receivers have it, one at a time.
  std::vector<double> latencies(int frames) {
    std::vector<Call> calls;
    for (const auto& stream : all_)
      calls.push_back([&stream](int) {
        stream->send_one();
        stream->wait(0);
      });
    return medians_in_turn(calls, frames);
  }
  // Microseconds of a frame with kInFlight of them on their way.
  std::vector<double> times_in_flight(int frames) {
    std::vector<double> out;
    for (const auto& stream : all_) {
      const double before = seconds(CLOCK_MONOTONIC);
      for (int i = 0; i < frames; ++i) {
        stream->send_one();
        stream->wait(kInFlight - 1);
      }
      stream->wait(0);
      out.push_back((seconds(CLOCK_MONOTONIC) - before) * 1e6 / frames);
    }
    return out;
  }

 private:
  const Broker broker_;
  std::vector<std::unique_ptr<Stream>> all_;
};

int count_frames(size_t bytes) {
  return std::clamp(static_cast<int>(50'000'000 / (bytes + 50'000)), 8, 500);
}

int report_ratios(int rounds) {
  for (const auto& [bytes, text] : kFrameSizes) {
    Streams streams(bytes, 1);
    Rounds latency, in_flight;
    for (int round = 0; round < rounds; ++round) {
      add_round(streams.latencies(count_frames(bytes)), &latency);
      add_round(streams.times_in_flight(count_frames(bytes)), &in_flight);
    }
    for (size_t i = 0; i < latency.size(); ++i) {
      std::fprintf(stderr, "%s: %s: p50 %.1f us; %d in flight: %.1f us a frame\n", text,
                   Streams::kNames[i], median(latency[i]), kInFlight, median(in_flight[i]));
      if (i == 0) continue;
      const std::string name = Streams::kNames[i] + std::string(" to mqttsrc, ") + text;
      report(name + ": p50", "libmosquitto, the same broker", median_ratio(latency[0], latency[i]),
             "x", 1 / 0.9);
      report(name + ", 8 in flight: time of a frame", "libmosquitto, the same broker",
             median_ratio(in_flight[0], in_flight[i]), "x", 1 / 0.9);
    }
  }
  return 0;
}

// For tools/plot: medians of three rounds.
void report_point(const char* axis, int x, size_t bytes, int receivers) {
  Streams streams(bytes, receivers);
  Rounds latency;
  for (int round = 0; round < 3; ++round)
    add_round(streams.latencies(count_frames(bytes)), &latency);
  for (size_t i = 0; i < latency.size(); ++i)
    std::printf("{\"series\": \"%s\", \"axis\": \"%s\", \"x\": %d, \"us\": %.1f}\n",
                Streams::kNames[i], axis, x, median(latency[i]));
  std::fflush(stdout);
}
int report_sizes() {
  for (int bytes = 1 << 10; bytes <= 1 << 24; bytes *= 4)
    report_point("bytes", bytes, static_cast<size_t>(bytes), 1);
  return 0;
}
int report_receivers() {
  for (int receivers = 1; receivers <= 16; receivers *= 2)
    report_point("receivers", receivers, 150'528, receivers);
  return 0;
}

}  // namespace
}  // namespace weir::bench

// Usage: mqtt_cost [ROUNDS], mqtt_cost sizes or mqtt_cost receivers.
int main(int argc, char** argv) {
  using namespace weir::bench;
  const std::string what = argc > 1 ? argv[1] : "5";
  gst_init(nullptr, nullptr);
  mosquitto_lib_init();
  if (what == "sizes") return report_sizes();
  return what == "receivers" ? report_receivers() : report_ratios(std::atoi(what.c_str()));
}
