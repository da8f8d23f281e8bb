// Finds faces in a photo or a video: mtcnn --json PHOTO-OR-VIDEO prints them, mtcnn --output CLIP
// VIDEO draws them on the video, which never waits for the networks. See README.md.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "copied_bytes.hpp"
#include "faces_text.hpp"
#include "line.hpp"
#include "stage_times.hpp"
#include "weir/pipeline.hpp"

namespace mtcnn {
namespace {

using namespace std::chrono_literals;

struct Options {
  std::string input, framework = "mtcnn-kernels", models, custom, output, report;
  uint32_t min_face = 40;
  double rate = 0, patience = 60;
  bool json = false, live = false, show = false, draw = false, rounded = false;
  bool draws() const { return draw || show || !output.empty(); }
};

// Quotes a value for a pipeline's text.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text)
    out += (c == '"' || c == '\\') ? std::string("\\") + c : std::string(1, c);
  return out + "\"";
}

std::string make_source(const std::string& file) {
  return "filesrc location=" + quoted(file) +
         " ! decodebin ! videoconvert ! video/x-raw,format=(string){I420,NV12}";
}

std::optional<uint32_t> number_after(const std::string& text, const std::string& key) {
  const size_t at = text.find(key);
  if (at == std::string::npos) return std::nullopt;
  return static_cast<uint32_t>(std::strtoul(text.c_str() + at + key.size(), nullptr, 10));
}

// The networks' sizes depend on the picture's, so one picture is decoded to find it.
weir::Result<Size> read_size(const std::string& file) {
  auto made = weir::Pipeline::parse(make_source(file) + " ! appsink name=first max-buffers=1");
  if (!made) return made.error();
  if (auto status = made->start(); !status) return status.error();
  auto frame = made->pull("first", 30s);
  if (!frame) return frame.error();
  const std::string caps = *frame ? (*frame)->caps() : "";
  const auto width = number_after(caps, "width=(int)"), height = number_after(caps, "height=(int)");
  if (width && height) return Size{*width, *height};
  return weir::Error{.code = weir::Code::FILE_NOT_FOUND,
                     .what = "there is no picture in the file",
                     .offered = file,
                     .needed = "a photo or a video that GStreamer can decode",
                     .fix = "gst-discoverer-1.0 " + file};
}

// The display: the newest results of the networks on every picture.
std::string overlay_line(const Options& options) {
  std::string line = " pictures. ! queue ! overlay.sink  tensor_overlay name=overlay";
  std::string sinks;
  if (!options.output.empty())
    sinks += " shown. ! queue ! videoconvert ! jpegenc ! matroskamux ! filesink location=" +
             quoted(options.output);
  sinks += options.show ? " shown. ! queue ! videoconvert ! autovideosink"
                        : " shown. ! queue ! appsink name=display sync=true";
  return line + " ! tee name=shown" + sinks;
}

std::string whole_line(const Options& options, const Setup& setup, const Networks& networks) {
  std::string line = make_source(options.input);
  if (options.rate > 0)
    line += " ! videorate drop-only=true ! capsfilter caps=video/x-raw,framerate=(fraction)" +
            std::to_string(static_cast<int>(options.rate * 1000)) + "/1000";
  if (options.live) line += " ! identity sync=true";
  line += " ! tee name=pictures";
  std::string networks_see = "pictures";
  if (options.draws()) {
    line += overlay_line(options) +
            "  pictures. ! queue leaky=downstream max-size-buffers=1 max-size-bytes=0 "
            "max-size-time=0 ! tee name=newest";
    networks_see = "newest";
  }
  if (!options.report.empty())
    line += "  " + networks_see + ". ! queue ! appsink name=begin sync=false";
  line += " " + networks_line(setup, networks, networks_see) +
          " ! tee name=results  results. ! tensor_sink name=out sync=false";
  if (networks_see == "newest") line += "  results. ! overlay.results";
  return line;
}

weir::Error nothing_comes(double seconds) {
  char none[64];
  std::snprintf(none, sizeof none, "none for %g seconds", seconds);
  return {.code = weir::Code::WORKER_TIMEOUT,
          .what = "no results come",
          .offered = none,
          .needed = "one for each picture",
          .fix = "GST_DEBUG=3 examples/mtcnn/run ..."};
}

// For pictures smaller than the smallest face: prints an empty list for each.
weir::Status print_no_faces(const Options& options, weir::Nanoseconds patience) {
  auto made = weir::Pipeline::parse(make_source(options.input) + " ! appsink name=out sync=false");
  if (!made) return made.error();
  if (auto status = made->start(); !status) return status;
  for (;;) {
    const auto frame = made->pull("out", patience);
    if (!frame) return frame.error();
    if (!*frame) {
      const auto ended = made->ended("out");
      if (!ended) return ended.error();
      return *ended ? weir::ok() : weir::Status(nothing_comes(options.patience));
    }
    if (options.json) std::printf("[]\n");
  }
}

weir::Status play(const Options& options) {
  auto networks = find_networks(options.framework, options.models);
  if (!networks) return networks.error();
  std::string& custom = networks->custom;
  custom += (custom.empty() || options.custom.empty() ? "" : ",") + options.custom;
  networks->rounded = options.rounded;
  const auto picture = read_size(options.input);
  if (!picture) return picture.error();
  const Setup setup{*picture, pyramid(*picture, options.min_face), networks->turned};
  const auto patience = std::chrono::duration_cast<weir::Nanoseconds>(
      std::chrono::duration<double>(options.patience));
  if (setup.layers.empty()) return print_no_faces(options, patience);
  StageTimes times;
  [[maybe_unused]] const auto filters = {proposals(setup, &times), refinement(setup, &times),
                                         landmarks(&times)};
  auto made = weir::Pipeline::parse(whole_line(options, setup, *networks));
  if (!made) return made.error();
  weir::Pipeline& pipeline = *made;
  if (!options.report.empty()) {
    auto status = pipeline.on_frame("begin", [&](const weir::Frame& frame) {
      times.reached(Stage::Begin, frame.pts().value_or(-1ns).count());
    });
    if (!status) return status;
  }
  if (options.draws() && !options.show) {
    auto status = pipeline.on_frame("display", [&](const weir::Frame&) { times.shown(); });
    if (!status) return status;
  }
  if (auto status = pipeline.start(); !status) return status;
  for (;;) {
    const auto frame = pipeline.pull<float>("out", patience);
    if (!frame) return frame.error();
    if (!*frame) {
      const auto ended = pipeline.ended("out");
      if (!ended) return ended.error();
      if (!*ended) return nothing_comes(options.patience);
      break;
    }
    if (options.json)
      std::printf("%s\n", faces_text(faces_of_rows(*(**frame)[0].as<float>())).c_str());
  }
  const auto ended = pipeline.wait(patience);
  if (!ended) return ended.error();
  if (!*ended) return nothing_comes(options.patience);
  if (options.report.empty()) return weir::ok();
  times.copied(bytes_copied(pipeline));
  return times.write(options.report);
}

}  // namespace
}  // namespace mtcnn

int main(int argc, char** argv) {
  mtcnn::Options options;
  CLI::App app{"Faces and their landmarks in a photo or a video (MTCNN)"};
  app.add_option("INPUT", options.input, "A photo or a video")->required();
  app.add_flag("--json", options.json, "Print a list of faces for each picture");
  app.add_option("--min-face", options.min_face, "The smallest face in pixels; else 40")
      ->check(CLI::Range(12u, 4096u));
  app.add_option(
      "--framework", options.framework,
      "mtcnn-kernels, onnxruntime, tensorflow-lite, pytorch or caffe; else mtcnn-kernels");
  app.add_option("--models", options.models, "The folder of the networks' files")->required();
  app.add_option("--custom", options.custom, "Options of the engine, as custom= takes them");
  app.add_flag("--rounded", options.rounded,
               "Round what is resized to bytes, as mtcnn-kernels takes it: to compare engines");
  app.add_option("--output", options.output, "A clip (.mkv) with the faces drawn");
  app.add_flag("--draw", options.draw, "Draw, and show it on no screen, at the clip's rate");
  app.add_flag("--show", options.show, "Show it in a window");
  app.add_flag("--live", options.live, "Pictures come at the rate of the clip, as from a camera");
  app.add_option("--rate", options.rate, "Pictures per second, where the clip has more");
  app.add_option("--patience", options.patience,
                 "Seconds without a result that are an error; else 60")
      ->check(CLI::Range(0.001, 86400.));
  app.add_option("--report", options.report, "A file for the times of each picture, as JSON");
  CLI11_PARSE(app, argc, argv);
  const auto status = mtcnn::play(options);
  if (status) return 0;
  std::fprintf(stderr, "mtcnn: %s\n", status.error().message().c_str());
  return 1;
}
