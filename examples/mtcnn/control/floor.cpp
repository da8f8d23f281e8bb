// The engine alone: the invokes that the control made for the pictures of a clip, same sizes and
// batches, on numbers of no meaning and with nothing around them.
//
//   mtcnn-floor --models FOLDER [--min-face N] [--threads N] ASKED
//
// ASKED is what mtcnn-control --asked wrote. Prints JSON: "ms", the medians of P-, R-, O-Net's and
// all invokes of a picture on one thread, "p99" of the latter; "rate", pictures per second on N
// threads, each with one network of each kind, and "cpu_ms", the CPU time of a picture there.
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>
#include <thread>

#include "../cascade.hpp"
#include "network.hpp"

namespace {

struct Asked {
  mtcnn::Size picture;
  int64_t refined = 0, marked = 0;  // regions of R-Net and of O-Net
};

class Invokes {
 public:
  Invokes(const std::string& models, uint32_t min_face)
      : p_(control::p_net(env_, models, 1)),
        r_(control::r_net(env_, models, 1)),
        o_(control::o_net(env_, models, 1)),
        min_face_(min_face) {}
  void p(const Asked& asked) {
    for (const auto& layer : mtcnn::pyramid(asked.picture, min_face_))
      one(p_, {1, 3, layer.height, layer.width});
  }
  void r(const Asked& asked) {
    one(r_, {asked.refined, 3, mtcnn::kRefineSide, mtcnn::kRefineSide});
  }
  void o(const Asked& asked) {
    one(o_, {asked.marked, 3, mtcnn::kLandmarkSide, mtcnn::kLandmarkSide});
  }

 private:
  void one(control::Network& network, const control::Shape& shape) {
    numbers_.resize(static_cast<size_t>(shape[0] * shape[1] * shape[2] * shape[3]), 0.1f);
    if (shape[0] > 0) network.run(numbers_, shape);
  }
  Ort::Env env_;
  control::Network p_, r_, o_;
  uint32_t min_face_;
  std::vector<float> numbers_;
};

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

double median(std::vector<double> all) {
  std::ranges::sort(all);
  const size_t n = all.size();
  return (all[(n - 1) / 2] + all[n / 2]) / 2;
}

double p99(std::vector<double> all) {
  std::ranges::sort(all);
  return all[(99 * all.size() + 99) / 100 - 1];
}

// Medians of P, R, O and of all three, and the 99th percentile of the last.
std::array<double, 5> one_thread(Invokes& invokes, const std::vector<Asked>& pictures) {
  std::vector<double> times[4];
  for (const Asked& picture : pictures) {
    const auto begin = Clock::now();
    invokes.p(picture);
    const auto p = Clock::now();
    invokes.r(picture);
    const auto r = Clock::now();
    invokes.o(picture);
    const auto o = Clock::now();
    times[0].push_back(ms(p - begin));
    times[1].push_back(ms(r - p));
    times[2].push_back(ms(o - r));
    times[3].push_back(ms(o - begin));
  }
  return {median(times[0]), median(times[1]), median(times[2]), median(times[3]), p99(times[3])};
}

int run(const std::string& file, const std::string& models, uint32_t min_face, int threads) {
  std::vector<Asked> pictures;
  std::ifstream in(file);
  for (Asked one; in >> one.picture.width >> one.picture.height >> one.refined >> one.marked;)
    pictures.push_back(one);
  if (pictures.empty())
    return std::fprintf(stderr, "mtcnn-floor: %s says nothing\n", file.c_str()), 1;
  std::vector<std::unique_ptr<Invokes>> all;
  for (int i = 0; i < threads; ++i) {
    all.push_back(std::make_unique<Invokes>(models, min_face));
    one_thread(*all.back(), {pictures.front()});  // the first meets what is not warm
  }
  const auto medians = one_thread(*all.front(), pictures);
  const double cpu = cpu_seconds();
  const auto begin = Clock::now();
  {
    std::vector<std::jthread> running;
    for (size_t i = 0; i < all.size(); ++i)
      running.emplace_back([&, i] {
        for (size_t k = i; k < pictures.size(); k += all.size()) {
          all[i]->p(pictures[k]);
          all[i]->r(pictures[k]);
          all[i]->o(pictures[k]);
        }
      });
  }
  const double took = ms(Clock::now() - begin), count = static_cast<double>(pictures.size());
  std::printf(
      "{\"ms\": [%.3f, %.3f, %.3f, %.3f], \"p99\": %.3f, \"rate\": %.3f, \"cpu_ms\": %.3f}\n",
      medians[0], medians[1], medians[2], medians[3], medians[4], count * 1e3 / took,
      (cpu_seconds() - cpu) * 1e3 / count);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::string asked, models;
  uint32_t min_face = 40;
  int threads = 1;
  CLI::App app{"The engine's own time for the invokes of mtcnn-control"};
  app.add_option("ASKED", asked, "What mtcnn-control --asked wrote")->required();
  app.add_option("--models", models, "The folder of the networks' files")->required();
  app.add_option("--min-face", min_face, "As the control had it; else 40");
  app.add_option("--threads", threads, "That run at once; else 1")->check(CLI::Range(1, 64));
  CLI11_PARSE(app, argc, argv);
  try {
    return run(asked, models, min_face, threads);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "mtcnn-floor: %s\n", e.what());
    return 1;
  }
}
