// Streams between processes through shared memory: against a queue within the process, GStreamer's
// shmsink, and a bare exchange of eventfds (docs/benchmarks.md).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/base/gstpushsrc.h>
#include <poll.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "launched.hpp"
#include "rounds.hpp"
#include "transport/local/publisher.hpp"
#include "transport/local/subscriber.hpp"

namespace weir::bench {
namespace {

constexpr int kFrames = 400, kWarm = 100;  // the first are not counted
constexpr int kExchanges = 3000;

// framesource: frames of `blocksize` bytes from the allocator that downstream proposes.
bool writes_frames = false;
size_t frame_bytes = 6'220'800;
int readers = 1;  // of edgesink
GstFlowReturn fill(GstPushSrc*, GstBuffer* buffer) {
  if (!writes_frames) return GST_FLOW_OK;
  const gst::Mapped map(buffer, GST_MAP_WRITE);
  std::memset(map.bytes().data(), 16, map.bytes().size());
  return GST_FLOW_OK;
}
void init_class(gpointer k, gpointer) {
  static GstStaticPadTemplate pad =
      GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS_ANY);
  gst_element_class_add_static_pad_template(GST_ELEMENT_CLASS(k), &pad);
  gst_element_class_set_static_metadata(GST_ELEMENT_CLASS(k), "Frames", "Source", "Frames", "Weir");
  GST_PUSH_SRC_CLASS(k)->fill = fill;
}
void init_gstreamer() {
  gst_init(nullptr, nullptr);
  static const GType type =
      g_type_register_static_simple(GST_TYPE_PUSH_SRC, "FrameSource", sizeof(GstPushSrcClass),
                                    init_class, sizeof(GstPushSrc), nullptr, GTypeFlags(0));
  gst_element_register(nullptr, "framesource", GST_RANK_NONE, type);
}
std::string source(int frames) {
  return "framesource blocksize=" + std::to_string(frame_bytes) +
         " num-buffers=" + std::to_string(frames) + " ! application/octet-stream ! ";
}

// Another process that runs `body` before this one has a thread of GStreamer.
template <class Body>
pid_t process(const Body& body) {
  const pid_t child = fork();
  if (child == 0) {
    body();
    _exit(0);
  }
  return child;
}

// Plays a pipeline to its end, or until `stop_after` buffers have reached the sink named "out".
// Returns the frames for each second between the first and the last.
double play(const std::string& description, int stop_after) {
  struct Seen {
    std::atomic<int> count{0};
    double first = 0, last = 0;
  } seen;
  init_gstreamer();
  const auto pipeline = launched(description);
  const auto sink =
      gst::Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline.get()), "out"));
  const auto pad = gst::Ref<GstPad>::adopt(gst_element_get_static_pad(sink.get(), "sink"));
  gst_pad_add_probe(
      pad.get(), GST_PAD_PROBE_TYPE_BUFFER,
      [](GstPad*, GstPadProbeInfo*, gpointer data) {
        auto* s = static_cast<Seen*>(data);
        s->last = seconds(CLOCK_MONOTONIC);
        if (++s->count == kWarm) s->first = s->last;
        return GST_PAD_PROBE_OK;
      },
      &seen, nullptr);
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  const auto bus = gst::Ref<GstBus>::adopt(gst_element_get_bus(pipeline.get()));
  const auto until = GstMessageType(GST_MESSAGE_EOS | GST_MESSAGE_ERROR);
  while (seen.count < stop_after) {
    GstMessage* message = gst_bus_timed_pop_filtered(bus.get(), 10 * GST_MSECOND, until);
    if (!message) continue;
    gst_message_unref(message);
    break;
  }
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  if (seen.count < stop_after - 8) {  // shmsrc ends when shmsink closes, with frames on the way
    std::fprintf(stderr, "only %d frames: %s\n", seen.count.load(), description.c_str());
    std::exit(1);
  }
  return (seen.count - kWarm) / (seen.last - seen.first);
}

std::string folder;

double through_queue() {
  return play(source(kFrames) +
                  "queue max-size-buffers=16 max-size-bytes=0 ! "
                  "fakesink name=out sync=false",
              kFrames);
}

// Holds the frames back at the sink "out" until all readers have connected.
void wait_for_readers(GstElement* pipeline) {
  const auto out = gst::Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline), "out"));
  const auto pad = gst::Ref<GstPad>::adopt(gst_element_get_static_pad(out.get(), "sink"));
  gst_pad_add_probe(
      pad.get(), GST_PAD_PROBE_TYPE_BUFFER,
      [](GstPad*, GstPadProbeInfo*, gpointer sink) {
        for (guint connected = 0; connected < static_cast<guint>(readers); poll(nullptr, 0, 1)) {
          GstStructure* stats = nullptr;
          g_object_get(sink, "stats", &stats, nullptr);
          gst_structure_get_uint(stats, "receivers", &connected);
          gst_structure_free(stats);
        }
        return GST_PAD_PROBE_REMOVE;
      },
      out.get(), nullptr);
}

// The writer is the other process, which reports the bytes that it copied by its exit code.
uint64_t bytes_copied = 0;
double through_local_link() {
  const std::string path = folder + "/local";
  const pid_t writer = process([&] {
    init_gstreamer();
    const auto pipeline = launched(source(kFrames) +
                                   "edgesink name=out sync=false protocol=local "
                                   "wait-connection=true path=" +
                                   path);
    if (readers > 1) wait_for_readers(pipeline.get());
    gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
    const auto bus = gst::Ref<GstBus>::adopt(gst_element_get_bus(pipeline.get()));
    gst_message_unref(gst_bus_timed_pop_filtered(
        bus.get(), GST_CLOCK_TIME_NONE, GstMessageType(GST_MESSAGE_EOS | GST_MESSAGE_ERROR)));
    const auto out =
        gst::Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline.get()), "out"));
    GstStructure* stats = nullptr;
    g_object_get(out.get(), "stats", &stats, nullptr);
    guint64 copied = 1;
    gst_structure_get_uint64(stats, "bytes-copied", &copied);
    _exit(copied == 0 ? 0 : 1);
  });
  const auto read = [&] {
    return play(
        "edgesrc protocol=local reconnect=true path=" + path + " ! fakesink name=out sync=false",
        kFrames);
  };
  std::vector<pid_t> others;
  for (int i = 1; i < readers; ++i) others.push_back(process(read));
  const double rate = read();
  for (const pid_t other : others) waitpid(other, nullptr, 0);
  int status = 1;
  waitpid(writer, &status, 0);
  if (status != 0) ++bytes_copied;
  return rate;
}

// Of the plug-ins "bad"; NaN without it.
double through_shmsink() {
  const pid_t looks = process([] {
    gst_init(nullptr, nullptr);
    GstElementFactory* const found = gst_element_factory_find("shmsink");
    _exit(found ? 0 : 1);
  });
  int missing = 1;
  waitpid(looks, &missing, 0);
  if (missing) return NAN;
  const std::string path = folder + "/shm";
  const pid_t writer = process([&] {
    init_gstreamer();
    play(source(kFrames + 8) +
             "shmsink name=out sync=false wait-for-connection=true "
             "shm-size=120000000 socket-path=" +
             path,
         kFrames + 16);
  });
  for (int i = 0; i < 10000 && !std::filesystem::exists(path); ++i) poll(nullptr, 0, 1);
  const double rate =
      play("shmsrc socket-path=" + path + " ! fakesink name=out sync=false", kFrames);
  kill(writer, SIGKILL);
  waitpid(writer, nullptr, 0);
  std::filesystem::remove(path);
  return rate;
}

void wait_for(int descriptor) {
  pollfd watched{descriptor, POLLIN, 0};
  uint64_t count = 0;
  while (read(descriptor, &count, sizeof count) < 0) poll(&watched, 1, -1);
}

// The median of a round trip in microseconds.
template <class Exchange>
double get_median(const Exchange& exchange) {
  std::vector<double> times;
  for (int i = 0; i < kExchanges; ++i) {
    const double before = seconds(CLOCK_MONOTONIC);
    exchange();
    if (i >= kExchanges / 10) times.push_back((seconds(CLOCK_MONOTONIC) - before) * 1e6);
  }
  return median(times);
}

double by_eventfd() {
  const int there = eventfd(0, EFD_NONBLOCK), back = eventfd(0, EFD_NONBLOCK);
  const auto signal = [](int descriptor) {
    const uint64_t one = 1;
    [[maybe_unused]] const auto written = write(descriptor, &one, sizeof one);
  };
  const pid_t peer = process([&] {
    for (int i = 0; i < kExchanges; ++i) wait_for(there), signal(back);
  });
  const double out = get_median([&] { signal(there), wait_for(back); });
  waitpid(peer, nullptr, 0);
  close(there), close(back);
  return out;
}

local::Subscriber connected(const std::string& path) {
  for (;;)
    if (auto made = local::Subscriber::connect(path)) return *std::move(made);
}
void send(local::Publisher* publisher, const std::shared_ptr<isolate::SharedBlock>& block) {
  local::LocalFrame frame;
  frame.memories.push_back({publisher->arena()->find(block->data(), 4096)->block, 0, 4096});
  frame.owner = block;
  publisher->publish(&frame);
}
// The frame is released with the result, as a buffer after its push.
std::shared_ptr<const local::ReceivedFrame> take(local::Subscriber* subscriber) {
  const auto event = subscriber->receive();
  if (!event || event->kind != local::StreamEvent::Kind::Frame) std::abort();
  return event->frame;
}

// A frame of 4 KiB through one local stream and one back through another.
double by_local_link() {
  const auto open = [](const char* name) {
    return *local::Publisher::open(
        {.path = folder + name, .max_held = 16, .drop = false, .max_readers = 1, .refused = {}});
  };
  const pid_t peer = process([&] {
    const auto publisher = open("/back");
    auto subscriber = connected(folder + "/there");
    publisher->wait_for_reader(std::nullopt);
    const auto block = publisher->arena()->allocate(4096);
    for (int i = 0; i < kExchanges; ++i) {
      const auto frame = take(&subscriber);
      send(publisher.get(), block);
    }
    while (publisher->wait_for_release(publisher->releases()) ==
           local::Publisher::Release::Released) {
    }
  });
  const auto publisher = open("/there");
  auto subscriber = connected(folder + "/back");
  publisher->wait_for_reader(std::nullopt);
  const auto block = publisher->arena()->allocate(4096);
  const double out = get_median([&] { send(publisher.get(), block), take(&subscriber); });
  waitpid(peer, nullptr, 0);
  return out;
}

// Runs a measurement in a process of its own, because a process with threads of GStreamer cannot
// fork. Adds to `copied` whether frames were copied.
double run_once(double (*measured)(), double* copied) {
  int ends[2];
  if (pipe(ends) != 0) std::exit(1);
  const pid_t child = process([&] {
    const double result[] = {measured(), static_cast<double>(bytes_copied)};
    [[maybe_unused]] const auto written = write(ends[1], result, sizeof result);
  });
  close(ends[1]);
  double result[2] = {};
  if (read(ends[0], result, sizeof result) != sizeof result) std::exit(1);
  close(ends[0]);
  waitpid(child, nullptr, 0);
  *copied += result[1];
  return result[0];
}

// Medians over rounds in which each has its turn.
std::vector<double> measure_medians(const std::vector<double (*)()>& measured, int rounds,
                                    double* copied) {
  std::vector<std::vector<double>> values(measured.size());
  for (int round = 0; round < rounds; ++round)
    for (size_t i = 0; i < measured.size(); ++i) values[i].push_back(run_once(measured[i], copied));
  std::vector<double> out;
  for (const auto& some : values) out.push_back(median(some));
  return out;
}

double written_through_queue() {
  writes_frames = true;
  return through_queue();
}
double written_through_local_link() {
  writes_frames = true;
  return through_local_link();
}
double written_through_shmsink() {
  writes_frames = true;
  return through_shmsink();
}

void report_ratios(int rounds) {
  double copied = 0;
  const auto m =
      measure_medians({written_through_queue, written_through_local_link, written_through_shmsink,
                       through_local_link, through_shmsink, by_eventfd, by_local_link},
                      rounds, &copied);
  std::fprintf(stderr,
               "frames/s: written: queue %.0f, local link %.0f, shmsink %.0f; not written: local "
               "link %.0f, shmsink %.0f; us: eventfd %.1f, local stream %.1f\n",
               m[0], m[1], m[2], m[3], m[4], m[5], m[6]);
  report("edgesink protocol=local, 6 MB that are written: time of a frame",
         "a queue in one process", m[0] / m[1], "x", 1 / 0.9);
  if (!std::isnan(m[4]))
    report("edgesink protocol=local, 6 MB that are not written: time of a frame",
           "shmsink and shmsrc", m[4] / m[3], "x", 1.0 / 3);
  report("edgesink protocol=local: runs with frames that were copied", "", copied, "runs", 0);
  report("local stream, 4 KiB there and back: p50", "the same with eventfds", m[6] / m[5], "x", 2);
}

// For tools/plot: microseconds of a frame that is written.
void report_point(const char* axis, size_t x,
                  const std::vector<std::pair<const char*, double (*)()>>& series) {
  std::vector<double (*)()> measured;
  for (const auto& [name, function] : series) measured.push_back(function);
  double copied = 0;
  const auto rates = measure_medians(measured, 3, &copied);
  for (size_t i = 0; i < series.size(); ++i)
    if (!std::isnan(rates[i]))
      std::printf("{\"series\": \"%s\", \"axis\": \"%s\", \"x\": %zu, \"us\": %.1f}\n",
                  series[i].first, axis, x, 1e6 / rates[i]);
  std::fflush(stdout);
}
void report_sizes() {
  for (frame_bytes = 1 << 12; frame_bytes <= 1 << 24; frame_bytes *= 4)
    report_point("bytes", frame_bytes,
                 {{"queue", written_through_queue},
                  {"edgesink protocol=local", written_through_local_link},
                  {"shmsink", written_through_shmsink}});
}
void report_readers() {
  for (readers = 1; readers <= 16; readers *= 2)
    report_point("readers", static_cast<size_t>(readers),
                 {{"edgesink protocol=local", written_through_local_link}});
}

}  // namespace
}  // namespace weir::bench

// Usage: local_link_cost [ROUNDS], local_link_cost sizes or local_link_cost readers.
int main(int argc, char** argv) {
  using namespace weir::bench;
  const std::string what = argc > 1 ? argv[1] : "5";
  char name[] = "/tmp/weir-link-XXXXXX";
  folder = mkdtemp(name);
  if (what == "sizes")
    report_sizes();
  else if (what == "readers")
    report_readers();
  else
    report_ratios(std::atoi(what.c_str()));
  std::filesystem::remove_all(folder);
}
