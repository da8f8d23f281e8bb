// The control: the same cascade without Weir, as a team would write it: one loop on one thread with
// OpenCV and ONNX Runtime's own API, like the callback of a ROS node. It shares the arithmetic of
// MTCNN (examples/mtcnn/cascade.cpp), the network files, the resampler and the batching with the
// example, and makes no avoidable copies.
//
//   mtcnn-control --models FOLDER [--min-face N] [--threads N] [--rate R] [--report FILE] INPUT
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <CLI/CLI.hpp>
#include <cstdio>

#include "faces_text.hpp"
#include "floor_requests.hpp"
#include "pictures.hpp"
#include "stage_times.hpp"
#include "stages.hpp"

namespace {

using mtcnn::Stage;

struct Options {
  control::Source source;
  std::string models, report, requests;
  uint32_t min_face = 40;
  int threads = 1;
  bool json = false;
};

int run(const Options& options) {
  Ort::Env env = control::silent_environment();
  control::Propose propose(env, options.models, options.threads, options.min_face);
  control::Refine refine(env, options.models, options.threads);
  control::Mark mark(env, options.models, options.threads);
  control::RequestFile requests(options.requests);
  mtcnn::StageTimes times;
  const auto find = [&](const cv::Mat& picture, int64_t pts) {
    propose.keep(requests.wanted(0));
    refine.keep(requests.wanted(1));
    mark.keep(requests.wanted(2));
    times.reached(Stage::Begin, pts);
    auto regions = propose.find(picture);
    times.reached(Stage::Proposed, pts);
    const size_t refined = regions.size();
    regions = refine.find(picture, std::move(regions));
    times.reached(Stage::Refined, pts);
    const size_t marked = regions.size();
    const auto faces = mark.find(picture, std::move(regions));
    times.reached(Stage::Marked, pts);
    if (options.json) std::printf("%s\n", mtcnn::faces_text(faces).c_str());
    requests.add({{static_cast<uint32_t>(picture.cols), static_cast<uint32_t>(picture.rows)},
                  refined,
                  marked});
  };
  if (!control::for_each_picture(options.source, find)) return 1;
  if (!requests.write())
    return std::fprintf(stderr, "mtcnn-control: %s: cannot be written\n", options.requests.c_str()),
           1;
  if (options.report.empty()) return 0;
  times.copied(propose.copied() + refine.copied() + mark.copied());
  const auto status = times.write(options.report);
  if (!status) std::fprintf(stderr, "mtcnn-control: %s\n", status.error().message().c_str());
  return status ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  gst_init(&argc, &argv);
  cv::setNumThreads(1);
  Options options;
  CLI::App app{"The control of mtcnn: one thread, OpenCV, ONNX Runtime"};
  app.add_option("INPUT", options.source.file, "A photo or a video")->required();
  app.add_option("--models", options.models, "The folder of the networks' files")->required();
  app.add_option("--min-face", options.min_face, "The smallest face in pixels; else 40")
      ->check(CLI::Range(12u, 4096u));
  app.add_option("--threads", options.threads, "Of the engine in each network; else 1");
  app.add_option("--rate", options.source.rate, "Pictures per second, where the clip has more");
  app.add_option("--report", options.report, "A file for the times of each picture, as JSON");
  app.add_option("--requests", options.requests, "A file for what mtcnn-floor repeats");
  app.add_flag("--json", options.json, "Print a list of faces for each picture");
  app.add_flag("--live", options.source.live,
               "Pictures come at the rate of the clip; the newest is taken");
  CLI11_PARSE(app, argc, argv);
  try {
    return run(options);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "mtcnn-control: %s\n", e.what());
    return 1;
  }
}
