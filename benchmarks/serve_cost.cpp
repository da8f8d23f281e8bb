// Compares a pipeline that is served with a plain server of grpc++ that calls the same engine: the
// median time of a call of the same plain client. Also counts calls of 64 clients that have no end,
// compares TLS with none, and measures until a fallback answers in place of a server.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/app/gstappsink.h>
#include <gst/app/gstappsrc.h>
#include <gst/gst.h>

#include <atomic>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <mutex>

#include "launched.hpp"
#include "oip_client.hpp"
#include "plain_grpc.hpp"
#include "rounds.hpp"
#include "served_line.hpp"
#include "server_process.hpp"

namespace weir::bench {
namespace {

constexpr int kClients = 64, kCallsOfEach = 1000, kRepeats = 3;
// 150 kB through the engine identity, which copies them.
constexpr size_t kBytes = 150'528;
// The input and output of models/clock_digits.onnx.
constexpr size_t kDigitsIn = 192 * 32 * sizeof(float), kDigitsOut = 13 * 12 * sizeof(float);
const char* const kDigitsCaps =
    "other/tensors,format=static,num_tensors=1,dimensions=(string)1:192:32:1,types=(string)float32,"
    "framerate=0/1";

// A server that plays `line` after its source.
std::vector<std::string> make_pipeline(const std::string& options, const std::string& line) {
  return {"pipeline", "tensor_query_serversrc name=source protocol=oip model-name=m " + options +
                          " ! " + line + " ! tensor_query_serversink"};
}
const std::string kIdentity = "tensor_filter framework=identity",
                  kIdentityCaps =
                      " caps=other/tensors,format=static,num_tensors=1,dimensions="
                      "(string)150528,types=(string)uint8,framerate=0/1";
std::string digits(const std::string& model) {
  return "tensor_filter model=" + model + " custom=NumThreads:1";
}

// The plain server around one session of an engine.
void run_bare(const char* engine, const std::string& model, size_t bytes_in, size_t bytes_out) {
  Options options;
  if (!model.empty()) options = {{"NumThreads", "1"}};
  const auto session = open_session(
      engine, model.empty() ? std::vector<std::string>{} : std::vector{model}, options);
  weir_tensor_info in = session->model().inputs()[0];
  for (uint32_t i = 0; i < in.rank; ++i)
    if (in.shape[i] < 0) in.shape[i] = static_cast<int64_t>(bytes_in);
  const weir_tensor_info out = value(session->resolve({in}))[0];
  std::vector<char> input(bytes_in);
  std::mutex mutex;  // guards the session and its input
  PlainServer(bytes_out / sizeof(float), [&](const grpc::ByteBuffer& request) {
    auto* const response = static_cast<char*>(std::malloc(bytes_out));
    std::lock_guard lock(mutex);
    if (!response || !copy_end(request, input) ||
        !invoke(*session, make_tensor(in, input.data(), bytes_in),
                make_tensor(out, response, bytes_out)))
      std::exit(1);
    return grpc::Slice(response, bytes_out, std::free);
  }).run("0");
}

struct Request {
  net::Pieces pieces;
  std::vector<std::byte> data;
};

// The bytes of a request of any server.
std::unique_ptr<Request> make_request(const char* input, const char* datatype,
                                      std::vector<int64_t> shape, size_t bytes) {
  auto out = std::make_unique<Request>();
  out->data.resize(bytes);
  const net::RequestTensor tensor{input, datatype, shape, out->data};
  uint64_t copied = 0;
  out->pieces = value(net::encode_infer_request("m", "1", std::span(&tensor, 1), net::Contents::Raw,
                                                false, &copied));
  return out;
}

// Returns once the pipeline has answered.
void wait_for(const PlainClient& client, const Request& request, std::span<char> out) {
  const auto begin = Clock::now();
  grpc::StatusCode code{};
  while (client.call("ModelInfer", request.pieces, out, &code) == 0)
    if (milliseconds_since(begin) > 10e3) {
      std::fprintf(stderr, "the server does not answer: status %d\n", code);
      std::exit(1);
    }
}

// Of each round, the median time of each of these calls, which are done in turn.
Rounds measure_medians(const std::vector<Call>& calls, int rounds) {
  Rounds out;
  for (int round = 0; round <= rounds; ++round) {
    const auto medians = medians_in_turn(calls, 200);
    if (round != 0) add_round(medians, &out);
  }
  return out;
}

std::string median_text(const std::vector<double>& microseconds) {
  return std::to_string(static_cast<int>(median(microseconds))) + " us";
}

// The end of the response's bytes go to `response`. Ends the program when there is none.
Call make_call(const PlainClient& client, const Request& request, std::span<char> response) {
  return [&client, &request, response](int) {
    if (client.call("ModelInfer", request.pieces, response) == 0) std::exit(1);
  };
}
Call make_call(OipClient& client, std::span<char> response) {
  return [&client, response](int) {
    if (!client.call(response.data())) std::exit(1);
  };
}

void compare(const std::string& name, const std::vector<std::string>& bare,
             const std::vector<std::string>& served, const Request& request, size_t bytes_out,
             int rounds) {
  const ServerProcess plain(bare), pipeline(served);
  const PlainClient to_plain(plain.port()), to_pipeline(pipeline.port());
  std::vector<char> expected(bytes_out, 1), response(bytes_out, 2);
  wait_for(to_plain, request, expected);
  wait_for(to_pipeline, request, response);
  if (expected != response) {
    std::fprintf(stderr, "%s: the two servers answer differently\n", name.c_str());
    std::exit(1);
  }
  const Rounds times = measure_medians(
      {make_call(to_plain, request, response), make_call(to_pipeline, request, response)}, rounds);
  report("served pipeline, " + name + ": p50 of a call",
         "plain grpc++ server that calls the same engine, " + median_text(times[0]),
         median_ratio(times[0], times[1]), "x", 1.15);
}

const char* const kNoLimits = "port=0 max-connections=0 max-connections-per-address=0";

// Throughput and the 99th percentile, for clients with a connection each.
void clients() {
  const ServerProcess bare(
      {"bare", "identity", "", std::to_string(kBytes), std::to_string(kBytes)}),
      served(make_pipeline(std::string(kNoLimits) + kIdentityCaps, kIdentity));
  const auto request = make_request("input", "UINT8", {kBytes}, kBytes);
  std::vector<std::vector<char>> responses(kClients, std::vector<char>(kBytes));
  for (int threads = 1; threads <= kClients; threads *= 2) {
    std::vector<std::vector<std::unique_ptr<PlainClient>>> of_server;
    for (const auto* server : {&bare, &served}) {
      of_server.emplace_back();
      for (int i = 0; i < threads; ++i) {
        of_server.back().push_back(std::make_unique<PlainClient>(server->port()));
        wait_for(*of_server.back().back(), *request, responses[static_cast<size_t>(i)]);
      }
    }
    const auto make_calls = [&](size_t server) {
      return [&, server](int thread) {
        const auto at = static_cast<size_t>(thread);
        make_call(*of_server[server][at], *request, responses[at])(thread);
      };
    };
    report_clients({{"plain grpc++ server", make_calls(0)}, {"served pipeline", make_calls(1)}},
                   threads);
  }
}

// 64 connections, each a thread.
void many_clients(const char* name, const std::string& options, bool all_are_answered) {
  const ServerProcess server(make_pipeline(options + kIdentityCaps, kIdentity));
  const auto request = make_request("input", "UINT8", {kBytes}, kBytes);
  std::vector<std::unique_ptr<PlainClient>> clients;
  for (int i = 0; i < kClients; ++i)
    clients.push_back(std::make_unique<PlainClient>(server.port()));
  std::vector<std::vector<char>> responses(kClients, std::vector<char>(kBytes));
  wait_for(*clients[0], *request, responses[0]);
  std::atomic<int> answered{0}, refused{0}, other{0};
  measure_times(
      [&](int thread) {
        const auto at = static_cast<size_t>(thread);
        grpc::StatusCode code{};
        if (clients[at]->call("ModelInfer", request->pieces, responses[at], &code) != 0)
          ++answered;
        else if (code == grpc::StatusCode::RESOURCE_EXHAUSTED)
          ++refused;
        else
          ++other;
      },
      kClients, kCallsOfEach);
  const int total = kClients * kCallsOfEach;
  report(std::string("served pipeline, 64 clients x 1,000 calls, ") + name,
         std::to_string(answered) + " answered, " + std::to_string(refused) + " refused",
         total - answered - (all_are_answered ? 0 : refused.load()), "calls", 0);
}

std::string read_file(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

// The plain server with TLS, and the same bytes for each response.
void run_plain(const std::string& pki) {
  grpc::SslServerCredentialsOptions options;
  options.pem_key_cert_pairs = {
      {read_file(pki + "/localhost.key"), read_file(pki + "/localhost.pem")}};
  PlainServer(kBytes / sizeof(float))
      .run("0",
           pki.empty() ? grpc::InsecureServerCredentials() : grpc::SslServerCredentials(options));
}

// Beside it what TLS makes of a call by plain grpc++ alone.
void tls(const std::string& pki, int rounds) {
  const std::string files = "tls-cert=" + pki + "/localhost.pem tls-key=" + pki + "/localhost.key";
  const ServerProcess plain(make_pipeline("port=0" + kIdentityCaps, kIdentity)),
      secure(make_pipeline("port=0 " + files + kIdentityCaps, kIdentity)),
      bare_plain({"plain", ""}), bare_secure({"plain", pki});
  weir_tensor_info info{};
  info.type = WEIR_UINT8;
  info.rank = 1;
  info.shape[0] = kBytes;
  OipClient to_plain({"grpc://localhost:" + plain.port() + "/m"}, info, kBytes),
      to_secure({"grpcs://localhost:" + secure.port() + "/m"}, info, kBytes,
                {{"ca", pki + "/ca.pem"}});
  const PlainClient to_bare(bare_plain.port()),
      to_bare_secure(bare_secure.port(),
                     grpc::SslCredentials({read_file(pki + "/ca.pem"), "", ""}));
  const auto request = make_request("x", "UINT8", {kBytes}, kBytes);
  std::vector<char> response(kBytes);
  const Rounds times = measure_medians(
      {make_call(to_plain, response), make_call(to_secure, response),
       make_call(to_bare, *request, response), make_call(to_bare_secure, *request, response)},
      rounds);
  char bare[32];
  std::snprintf(bare, sizeof bare, "%.2f", median_ratio(times[2], times[3]));
  report("engine oip and served pipeline, 150 kB both ways, TLS: p50 of a call",
         "the same without TLS, " + median_text(times[0]) + "; plain grpc++ alone " + bare + " x",
         median_ratio(times[0], times[1]), "x", 1.3);
}

// appsrc ! tensor_filter framework=oip fallback=MODEL ! appsink.
class Camera {
 public:
  Camera(const std::string& port, const std::string& model) {
    pipeline_ =
        launched(std::string("appsrc name=in format=time caps=") + kDigitsCaps +
                 " ! tensor_filter name=filter framework=oip model=grpc://localhost:" + port +
                 "/m custom=timeout-ms:200,probe-ms:100 fallback=" + model +
                 " ! appsink name=out sync=false");
    in_ = child("in"), out_ = child("out"), filter_ = child("filter");
    gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING);
  }
  ~Camera() { gst_element_set_state(pipeline_.get(), GST_STATE_NULL); }
  Camera(const Camera&) = delete;
  Camera& operator=(const Camera&) = delete;
  // Whether there is a result of one frame.
  bool frame() {
    GstBuffer* const buffer = gst_buffer_new_allocate(nullptr, kDigitsIn, nullptr);
    gst_buffer_memset(buffer, 0, 0, kDigitsIn);
    GST_BUFFER_PTS(buffer) = frames_++ * GST_MSECOND;
    gst_app_src_push_buffer(GST_APP_SRC(in_.get()), buffer);
    GstSample* const sample =
        gst_app_sink_try_pull_sample(GST_APP_SINK(out_.get()), 5 * GST_SECOND);
    if (!sample) return false;
    gst_sample_unref(sample);
    return true;
  }
  uint64_t by_fallback() const {
    GstStructure* stats = nullptr;
    guint64 frames = 0;
    g_object_get(filter_.get(), "stats", &stats, nullptr);
    gst_structure_get_uint64(stats, "fallback-frames", &frames);
    gst_structure_free(stats);
    return frames;
  }

 private:
  gst::Ref<GstElement> child(const char* name) {
    return gst::Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline_.get()), name));
  }
  gst::Ref<GstElement> pipeline_, in_, out_, filter_;
  uint64_t frames_ = 0;
};

struct Gap {
  double seconds = 0;  // until the next result
  int lost = 0;        // frames without a result
};

// The only server gets the signal; then frames come one after the other.
Gap gap_after(int number, const std::string& model) {
  const ServerProcess server(make_pipeline("port=0", digits(model)));
  Camera camera(server.port(), model);
  Gap out;
  for (int i = 0; i < 50; ++i) out.lost += !camera.frame();
  if (out.lost != 0 || camera.by_fallback() != 0) std::exit(1);
  server.signal(number);
  const auto begin = Clock::now();
  for (int i = 0; i < 50; ++i) {
    out.lost += !camera.frame();
    if (i == 0) out.seconds = milliseconds_since(begin) / 1000;
  }
  if (camera.by_fallback() == 0) std::exit(1);
  return out;
}

void fallback(const std::string& model) {
  for (const auto& [number, what] : {std::pair{SIGKILL, "killed"}, std::pair{SIGSTOP, "stopped"}}) {
    std::vector<double> seconds;
    int lost = 0;
    for (int i = 0; i < kRepeats; ++i) {
      const Gap gap = gap_after(number, model);
      seconds.push_back(gap.seconds);
      lost += gap.lost;
    }
    const std::string name = std::string("tensor_filter, its only server ") + what;
    report(name + ": until the fallback answers", "timeout-ms:200", median(seconds), "s", 1);
    report(name + ": frames lost", "50 frames after it, three times", lost, "frames", 0);
  }
}

}  // namespace
}  // namespace weir::bench

// Usage: serve_cost ROUNDS clock_digits.onnx FOLDER, with ca.pem, localhost.pem and localhost.key;
// or serve_cost clients.
int main(int argc, char** argv) {
  using namespace weir::bench;
  signal(SIGPIPE, SIG_IGN);
  const std::string what = argc > 1 ? argv[1] : "";
  if (what == "bare" && argc == 6) {
    run_bare(argv[2], argv[3], std::strtoul(argv[4], nullptr, 10),
             std::strtoul(argv[5], nullptr, 10));
    return 0;
  }
  if (what == "plain" && argc == 3) {
    run_plain(argv[2]);
    return 0;
  }
  gst_init(&argc, &argv);
  if (what == "pipeline" && argc == 3) return run_served_line(argv[2]);
  if (what == "clients") {
    clients();
    return 0;
  }
  if (argc != 4) return 2;
  const int rounds = std::atoi(argv[1]);
  const std::string model = argv[2];
  const auto bytes = [](size_t count) { return std::to_string(count); };
  compare("150 kB both ways, engine identity",
          {"bare", "identity", "", bytes(kBytes), bytes(kBytes)},
          make_pipeline("port=0" + kIdentityCaps, kIdentity),
          *make_request("input", "UINT8", {kBytes}, kBytes), kBytes, rounds);
  compare("clock_digits, engine onnxruntime",
          {"bare", "onnxruntime", model, bytes(kDigitsIn), bytes(kDigitsOut)},
          make_pipeline("port=0", digits(model)),
          *make_request("strip", "FP32", {1, 32, 192, 1}, kDigitsIn), kDigitsOut, rounds);
  tls(argv[3], rounds);
  fallback(model);
  many_clients("without limits: without an answer", kNoLimits, true);
  many_clients("default limits: without an end", "port=0", false);
}
