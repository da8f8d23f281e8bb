// Fuzz target: hostile peers of every protocol that Weir speaks, as servers and as clients, in this
// process. An honest client must be served while a hostile one is connected, every pipeline must
// stop soon, memory and descriptors must be given back, and GLib must report no critical message.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/app/gstappsrc.h>
#include <gst/gst.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <future>
#include <iterator>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "fuzz_input.hpp"
#include "gstcpp/element/ref.hpp"
#include "honest_peers.hpp"
#include "hostile_sockets.hpp"
#include "serve/metrics_server.hpp"

// Of AddressSanitizer; GCC has no header for it.
extern "C" size_t __sanitizer_get_current_allocated_bytes();

// Defined by GST_PLUGIN_DEFINE in src/plugin.
G_BEGIN_DECLS
GST_PLUGIN_STATIC_DECLARE(weir);
GST_PLUGIN_STATIC_DECLARE(weiredge);
GST_PLUGIN_STATIC_DECLARE(weirnet);
G_END_DECLS

namespace {

using namespace weir::fuzz;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;
using std::chrono::milliseconds;

// Without the time in which threads of this process wait for a core.
constexpr milliseconds kMaxStop{5000}, kMaxStart{8000}, kMaxService{8000}, kMaxRelease{5000};
// Until a peer leaves for which a pipeline waits while it starts.
constexpr milliseconds kPatience{100};
// What the eight connections of a hostile peer may take, and what may stay for reuse. gRPC keeps
// what it has read (SECURITY.md), libmosquitto allocates what a packet announces: up to 256 MiB.
constexpr size_t kMaxPeak = size_t{64} << 20, kMaxPeakOfLibraries = size_t{320} << 20;
constexpr size_t kMaxKept = size_t{4} << 20;
constexpr int kMaxKeptDescriptors = 16;

#define FRAMES                                                                   \
  "appsrc name=source format=time do-timestamp=true is-live=true max-buffers=4 " \
  "leaky-type=downstream caps=\"other/tensors,format=static,num_tensors=1,"      \
  "dimensions=(string)4,types=(string)uint8,framerate=30/1\" ! "
#define SINK " async=false sync=false"
#define END " ! fakesink name=end async=false sync=false signal-handoffs=true"
#define ECHO                                                                               \
  " ! other/tensors,format=static,num_tensors=1,dimensions=(string)4,types=(string)uint8," \
  "framerate=0/1 ! tensor_query_serversink async=false"

// A pipeline with one side of a protocol. PORT and PATH stand for the address of the server.
struct Subject {
  Protocol protocol;
  bool (*honest)(const Place&);  // a client of it; null: it is a client
  const char* pipeline;          // null: the page of metrics, which is no element
};
constexpr Subject kSubjects[] = {
    {Protocol::Stream, receives_stream, FRAMES "edgesink name=server port=0 max-buffers=4" SINK},
    {Protocol::Query, queries, "tensor_query_serversrc name=server port=0" ECHO},
    {Protocol::Stream, nullptr, "edgesrc dest-port=PORT" END},
    {Protocol::Stream, nullptr, "edgesrc dest-port=PORT reconnect=true" END},
    {Protocol::Query, nullptr, FRAMES "tensor_query_client port=0 dest-port=PORT" END},
    {Protocol::Query, nullptr,
     FRAMES "tensor_query_client port=0 dest-port=PORT reconnect=true timeout=3000" END},
    {Protocol::TensorService, sends_tensors, "tensor_src_grpc name=server port=0" END},
    {Protocol::TensorService, receives_tensors,
     FRAMES "tensor_sink_grpc name=server port=0 server=true" SINK},
    {Protocol::TensorService, nullptr, "tensor_src_grpc server=false port=PORT" END},
    {Protocol::TensorService, nullptr, FRAMES "tensor_sink_grpc port=PORT" SINK},
    {Protocol::Inference, infers,
     "tensor_query_serversrc name=server protocol=oip model-name=m port=0" ECHO},
    {Protocol::Inference, nullptr,
     FRAMES "tensor_filter framework=oip model=grpc://127.0.0.1:PORT/m custom=timeout-ms:500" END},
    {Protocol::Inference, nullptr,
     FRAMES "tensor_filter framework=oip model=grpc://127.0.0.1:PORT/m "
            "custom=timeout-ms:500,input:4,inputtype:uint8,output:4,outputtype:uint8" END},
    {Protocol::Mqtt, nullptr, "mqttsrc port=PORT sub-topic=t" END},
    {Protocol::Mqtt, nullptr, "mqttsrc port=PORT sub-topic=t protocol=5" END},
    {Protocol::Mqtt, nullptr, FRAMES "mqttsink port=PORT pub-topic=t" SINK},
    {Protocol::Mqtt, nullptr, FRAMES "mqttsink port=PORT pub-topic=t protocol=5 mqtt-qos=2" SINK},
    {Protocol::Mqtt, nullptr, "edgesrc connect-type=MQTT dest-port=PORT topic=t" END},
    {Protocol::Mqtt, nullptr, "edgesrc connect-type=HYBRID dest-port=PORT topic=t" END},
    {Protocol::Mqtt, nullptr,
     FRAMES "tensor_query_client connect-type=HYBRID port=0 dest-port=PORT topic=t" END},
    {Protocol::Mqtt, nullptr,
     FRAMES "edgesink connect-type=MQTT port=0 dest-port=PORT topic=t" SINK},
    {Protocol::Mqtt, nullptr,
     FRAMES "edgesink connect-type=HYBRID port=0 dest-port=PORT topic=t" SINK},
    {Protocol::Mqtt, nullptr,
     "tensor_query_serversrc connect-type=HYBRID port=0 dest-port=PORT topic=t" ECHO},
    {Protocol::Local, receives_local_stream,
     FRAMES "edgesink name=server protocol=local path=PATH drop=true max-buffers=4" SINK},
    {Protocol::Local, nullptr, "edgesrc protocol=local path=PATH" END},
    {Protocol::Local, nullptr, "edgesrc protocol=local path=PATH reconnect=true" END},
    {Protocol::Http, reads_metrics, nullptr},
};

bool has_trace() {
  static const bool wanted = std::getenv("FUZZ_TRACE") != nullptr;
  return wanted;
}

// How long the threads of this process have waited for a core.
std::chrono::nanoseconds starved_time() {
  int64_t sum = 0;
  std::error_code gone;  // threads end
  for (std::filesystem::directory_iterator at("/proc/self/task", gone), end; at != end;
       at.increment(gone)) {
    int64_t ran = 0, waited = 0;
    std::ifstream file(at->path() / "schedstat");
    if (file >> ran >> waited) sum += waited;
  }
  return std::chrono::nanoseconds(sum);
}

// Ends the process when a step takes too long, and measures the memory meanwhile.
class Watchdog {
 public:
  Watchdog() : thread_([this] { run(); }) {}
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;
  ~Watchdog() {
    enter(nullptr, {});
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  void enter(const char* step, milliseconds limit) {
    const std::lock_guard lock(mutex_);
    if (has_trace() && step_)
      std::fprintf(stderr, "  %s: %ld ms, starved %ld ms\n", step_, (Clock::now() - began_) / 1ms,
                   starved_ / 1ms);
    step_ = step;
    began_ = Clock::now();
    starved_ = {};
    limit_ = limit;
  }
  size_t peak() const { return peak_; }

 private:
  void run() {
    std::unique_lock lock(mutex_);
    auto starved = starved_time();
    for (auto last = Clock::now(); !stopping_; changed_.wait_for(lock, 5ms)) {
      const auto now = Clock::now();
      const auto starved_now = starved_time();
      // Several threads may wait at a time, and none of them may be the one that counts.
      starved_ += std::clamp(starved_now - starved, 0ns, (now - last) * 3 / 4);
      starved = starved_now;
      last = now;
      peak_ = std::max<size_t>(peak_, __sanitizer_get_current_allocated_bytes());
      if (step_ && now - began_ > limit_ + starved_) {
        std::fprintf(stderr, "broken: it takes too long to %s\n", step_);
        std::abort();
      }
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  const char* step_ = nullptr;
  Clock::time_point began_;
  milliseconds limit_{};
  std::chrono::nanoseconds starved_{};  // since began_
  bool stopping_ = false;
  std::atomic<size_t> peak_{0};
  std::thread thread_;
};

// A pipeline of a subject. Frames come by a thread where it has an appsrc.
class Pipeline {
 public:
  explicit Pipeline(const std::string& description)
      : pipeline_(gst_parse_launch(description.c_str(), nullptr)),
        source_(gst_bin_get_by_name(GST_BIN(pipeline_), "source")) {
    GstBus* bus = gst_element_get_bus(pipeline_);
    gst_bus_set_sync_handler(bus, drop, nullptr, nullptr);
    gst_object_unref(bus);
    if (source_) feeder_ = std::thread([this] { feed(); });
  }
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;
  ~Pipeline() {
    fed_ = true;
    if (feeder_.joinable()) feeder_.join();
    if (source_) gst_object_unref(source_);
    gst_object_unref(pipeline_);
  }

  GstElement* get() const { return pipeline_; }
  // Whether it did not fail.
  bool set_state(GstState state) {
    return gst_element_set_state(pipeline_, state) != GST_STATE_CHANGE_FAILURE;
  }
  // Where the element "server" listens.
  uint16_t port() const {
    GstElement* server = gst_bin_get_by_name(GST_BIN(pipeline_), "server");
    guint port = 0;
    GstStructure* stats = nullptr;
    g_object_get(server, "stats", &stats, nullptr);
    if (!gst_structure_get_uint(stats, "port", &port)) g_object_get(server, "port", &port, nullptr);
    gst_structure_free(stats);
    gst_object_unref(server);
    return static_cast<uint16_t>(port);
  }

 private:
  static GstBusSyncReply drop(GstBus*, GstMessage* message, gpointer) {
    GError* error = nullptr;
    if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR)
      gst_message_parse_error(message, &error, nullptr);
    if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_WARNING)
      gst_message_parse_warning(message, &error, nullptr);
    if (error && has_trace())
      std::fprintf(stderr, "  %s: %s\n", GST_MESSAGE_SRC_NAME(message), error->message);
    g_clear_error(&error);
    gst_message_unref(message);  // a dropped message belongs to the handler
    return GST_BUS_DROP;
  }
  void feed() {
    for (; !fed_; std::this_thread::sleep_for(2ms)) {
      GstBuffer* buffer = gst_buffer_new_allocate(nullptr, kHonestFrame.size(), nullptr);
      gst_buffer_fill(buffer, 0, kHonestFrame.data(), kHonestFrame.size());
      gst_app_src_push_buffer(GST_APP_SRC(source_), buffer);
    }
  }

  GstElement* const pipeline_;
  GstElement* const source_;
  std::atomic<bool> fed_{false};
  std::thread feeder_;
};

// The page of metrics of `weir serve`, and the main context that it needs.
class MetricsPage {
 public:
  MetricsPage() {
    std::promise<uint16_t> opened;
    auto port = opened.get_future();
    thread_ = std::thread([this, &opened] { run(&opened); });
    port_ = port.get();
  }
  MetricsPage(const MetricsPage&) = delete;
  MetricsPage& operator=(const MetricsPage&) = delete;
  ~MetricsPage() { stop(); }

  uint16_t port() const { return port_; }
  void stop() {
    g_main_loop_quit(loop_.get());
    if (thread_.joinable()) thread_.join();
  }

 private:
  void run(std::promise<uint16_t>* opened) {
    auto server =
        weir::app::MetricsServer::open({.host = "127.0.0.1", .port = "0", .unix_path = {}},
                                       [] { return std::string(kHonestFrame); });
    require(server.has_value(), "the page of metrics is served");
    opened->set_value((*server)->port());
    g_main_loop_run(loop_.get());
    server->reset();
    while (g_main_context_iteration(nullptr, FALSE)) {  // its connections end
    }
  }

  const weir::gst::Unique<GMainLoop, g_main_loop_unref> loop_{g_main_loop_new(nullptr, FALSE)};
  std::thread thread_;
  uint16_t port_ = 0;
};

const std::string& socket_path() {
  static const std::string path = [] {
    std::string folder = std::filesystem::temp_directory_path() / "weir-fuzz-XXXXXX";
    require(mkdtemp(folder.data()), "there is a folder for sockets");
    static const struct Remover {
      std::string folder;
      ~Remover() { std::filesystem::remove_all(folder); }
    } remover{folder};
    return folder + "/stream";
  }();
  return path;
}

std::string describe(const Subject& subject, uint16_t port) {
  std::string out = subject.pipeline;
  for (const auto& [word, value] :
       {std::pair{"PORT", std::to_string(port)}, std::pair{"PATH", socket_path()}})
    if (const size_t at = out.find(word); at != std::string::npos) out.replace(at, 4, value);
  return out;
}

// The hostile peer stays until the server has stopped.
void play_against_server(const Subject& subject, const Place& place, FuzzInput* input,
                         Watchdog* watchdog, const std::function<void()>& stop) {
  HostilePeer peer({subject.protocol, true, place.port, place.path});
  watchdog->enter("play", kMaxStop);
  peer.play(input);
  watchdog->enter("serve an honest client", kMaxService);
  while (!subject.honest(place)) std::this_thread::sleep_for(10ms);
  watchdog->enter("stop the server", kMaxStop);
  stop();
}

void play_server(const Subject& subject, FuzzInput* input, Watchdog* watchdog) {
  Pipeline pipeline(describe(subject, 0));
  watchdog->enter("start", kMaxStart);
  require(pipeline.set_state(GST_STATE_PLAYING), "the server starts");
  const bool has_port = subject.protocol != Protocol::Local;
  const Place place{has_port ? pipeline.port() : uint16_t{0}, socket_path(), pipeline.get()};
  play_against_server(subject, place, input, watchdog, [&] { pipeline.set_state(GST_STATE_NULL); });
}

void play_metrics(const Subject& subject, FuzzInput* input, Watchdog* watchdog) {
  watchdog->enter("start", kMaxStart);
  MetricsPage page;
  play_against_server(subject, {page.port(), {}, nullptr}, input, watchdog, [&] { page.stop(); });
}

void play_client(const Subject& subject, FuzzInput* input, Watchdog* watchdog) {
  HostilePeer peer({subject.protocol, false, 0, socket_path()});
  Pipeline pipeline(describe(subject, peer.port()));
  std::promise<void> started;
  std::thread player([&, has_started = started.get_future()] {
    peer.play(input);
    if (has_started.wait_for(kPatience) == std::future_status::timeout) peer.leave();
  });
  watchdog->enter("start the client", kMaxStart);
  pipeline.set_state(GST_STATE_PLAYING);
  started.set_value();
  player.join();
  watchdog->enter("stop the client", kMaxStop);
  pipeline.set_state(GST_STATE_NULL);
}

size_t count_descriptors() {
  size_t count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator("/proc/self/fd"))
    ++count;
  return count;
}

// Threads of gRPC may give back later.
void wait_until_released(size_t bytes, size_t descriptors, Watchdog* watchdog) {
  watchdog->enter("release memory and descriptors", kMaxRelease);
  for (int polls = 1; __sanitizer_get_current_allocated_bytes() > bytes + kMaxKept ||
                      count_descriptors() > descriptors + kMaxKeptDescriptors;
       ++polls) {
    std::this_thread::sleep_for(1ms);
    if (polls % 1000 == 0)
      std::fprintf(stderr, "kept: %zu bytes over %zu, %zu descriptors over %zu\n",
                   __sanitizer_get_current_allocated_bytes() - bytes, bytes,
                   count_descriptors() - descriptors, descriptors);
  }
}

void initialise() {
  gst_init(nullptr, nullptr);
  g_log_set_always_fatal(static_cast<GLogLevelFlags>(G_LOG_LEVEL_CRITICAL | G_LOG_LEVEL_ERROR));
  setenv("WEIR_MODULE_PATH", WEIR_FUZZED_MODULES, 1);
  GST_PLUGIN_STATIC_REGISTER(weir);
  GST_PLUGIN_STATIC_REGISTER(weiredge);
  GST_PLUGIN_STATIC_REGISTER(weirnet);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  [[maybe_unused]] static const bool initialised = (initialise(), true);
  FuzzInput input(data, size);
  const Subject& subject = kSubjects[input.below(std::size(kSubjects))];
  if (has_trace())
    std::fprintf(stderr, "%s\n", subject.pipeline ? subject.pipeline : "the page of metrics");
  const size_t bytes = __sanitizer_get_current_allocated_bytes();
  const size_t descriptors = count_descriptors();
  Watchdog watchdog;
  (!subject.pipeline ? play_metrics
   : subject.honest  ? play_server
                     : play_client)(subject, &input, &watchdog);
  const bool has_library = subject.protocol == Protocol::TensorService ||
                           subject.protocol == Protocol::Inference ||
                           subject.protocol == Protocol::Mqtt;
  require(watchdog.peak() < bytes + (has_library ? kMaxPeakOfLibraries : kMaxPeak),
          "memory is bounded");
  wait_until_released(bytes, descriptors, &watchdog);
  if (has_trace())
    std::fprintf(stderr, "  peak %zu kB, kept %zd kB, %zd descriptors\n",
                 (watchdog.peak() - bytes) / 1024,
                 static_cast<ssize_t>(__sanitizer_get_current_allocated_bytes() - bytes) / 1024,
                 static_cast<ssize_t>(count_descriptors() - descriptors));
  return 0;
}
