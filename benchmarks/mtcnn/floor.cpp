// Runs an engine alone: repeats the invokes that the control made for the pictures of a clip, with
// the same sizes and batches and the values of one of its pictures, and nothing else. Built twice:
// mtcnn-floor for ONNX Runtime, mtcnn-kernels-floor for our own kernels.
//
//   mtcnn-floor --models FOLDER [--min-face N] [--threads N] [--clip FILE] REQUESTS
//
// REQUESTS: the file from mtcnn-control --requests. Prints JSON: "pictures", the milliseconds of
// P-, R-, O-Net's and all invokes per picture on one thread; "rate", pictures per second on N
// threads, each with its own networks, and "cpu_ms", CPU time per picture there. With --clip also
// "decoding": both again with each picture decoded first, a limit for any program that reads a
// clip.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <memory>
#include <thread>

#include "floor.hpp"
#include "floor_clip.hpp"

namespace {

using control::Invokes;
using control::Requests;
using control::Seen;
using Clock = std::chrono::steady_clock;

double ms(Clock::duration time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6;
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

struct Times {
  double p, r, o, all;  // ms
};

Times one_picture(Invokes& invokes, const Requests& picture) {
  const auto begin = Clock::now();
  invokes.p(picture);
  const auto p = Clock::now();
  invokes.r(picture);
  const auto r = Clock::now();
  invokes.o(picture);
  const auto o = Clock::now();
  return {ms(p - begin), ms(r - p), ms(o - r), ms(o - begin)};
}

// "rate" and "cpu_ms" of all pictures, with a thread for each item of `all`; decodes each picture
// of `clip` first if there is one.
std::string on_all_threads(const std::vector<std::unique_ptr<Invokes>>& all,
                           const std::vector<Requests>& pictures, control::DecodedClip* clip) {
  std::atomic<size_t> next = 0, done = 0;
  const double cpu = cpu_seconds();
  const auto begin = Clock::now();
  {
    std::vector<std::jthread> running;
    for (const auto& invokes : all)
      running.emplace_back([&] {
        for (size_t k = next++; k < pictures.size() && (!clip || clip->next()); k = next++, ++done)
          one_picture(*invokes, pictures[k]);
      });
  }
  const double took = ms(Clock::now() - begin),
               count = static_cast<double>(std::max<size_t>(done, 1));
  char text[80];
  std::snprintf(text, sizeof text, "\"rate\": %.3f, \"cpu_ms\": %.3f", count * 1e3 / took,
                (cpu_seconds() - cpu) * 1e3 / count);
  return text;
}

int run(const std::string& file, const std::string& clip, const std::string& models,
        uint32_t min_face, int threads) {
  const std::vector<Requests> pictures = control::read_requests(file);
  if (pictures.empty()) return std::fprintf(stderr, "mtcnn-floor: %s is empty\n", file.c_str()), 1;
  Requests max;
  for (const Requests& one : pictures) {
    max.picture.width = std::max(max.picture.width, one.picture.width);
    max.picture.height = std::max(max.picture.height, one.picture.height);
    max.refined = std::max(max.refined, one.refined);
    max.marked = std::max(max.marked, one.marked);
  }
  const Seen seen = control::read_seen(file);
  std::vector<std::unique_ptr<Invokes>> all;
  for (int i = 0; i < threads; ++i) {
    all.push_back(control::make_invokes(models, min_face, max, seen));
    one_picture(*all.back(), pictures.front());  // warms up
  }
  std::string alone;
  for (const Requests& picture : pictures) {
    const Times took = one_picture(*all.front(), picture);
    char text[100];
    std::snprintf(text, sizeof text, "%s[%.3f, %.3f, %.3f, %.3f]", alone.empty() ? "" : ", ",
                  took.p, took.r, took.o, took.all);
    alone += text;
  }
  const std::string bare = on_all_threads(all, pictures, nullptr);
  std::string decoding;
  if (!clip.empty()) {
    control::DecodedClip decoded(clip);
    decoding = ", \"decoding\": {" + on_all_threads(all, pictures, &decoded) + "}";
  }
  std::printf("{\"pictures\": [%s], %s%s}\n", alone.c_str(), bare.c_str(), decoding.c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::string requests, clip, models;
  uint32_t min_face = 40;
  int threads = 1;
  CLI::App app{"An engine's own time for the invokes of mtcnn-control"};
  app.add_option("REQUESTS", requests, "What mtcnn-control --requests wrote")->required();
  app.add_option("--models", models, "The folder of the networks' files")->required();
  app.add_option("--min-face", min_face, "As the control had it; else 40");
  app.add_option("--clip", clip,
                 "The clip that the requests are from, to be decoded in a second run");
  app.add_option("--threads", threads, "That run at once; else 1")->check(CLI::Range(1, 64));
  CLI11_PARSE(app, argc, argv);
  try {
    return run(requests, clip, models, min_face, threads);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "mtcnn-floor: %s\n", e.what());
    return 1;
  }
}
