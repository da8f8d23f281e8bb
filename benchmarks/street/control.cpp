// The control: the same without Weir's elements, as a team would write it: one loop with OpenCV's
// VideoCapture, which decodes in threads of its own, and its DNN module. It shares the code of the
// tracker and the zones with the pipeline, and the network's weights.
//
//   street-control MODEL.onnx ZONES.json VIDEO [DRAWN.avi]
//
// Results as JSON Lines on the standard output. Every picture is drawn, also without DRAWN.avi.
// INPUTS=FILE gives the network the float32 tensors of that file, one for each frame, instead of
// the pictures: the results then differ only by what comes after the pictures are prepared.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <opencv2/videoio.hpp>

#include "core/track/tracker.hpp"
#include "core/zone/zone_file.hpp"
#include "detector.hpp"
#include "drawing.hpp"
#include "results_text.hpp"

namespace {

constexpr int kThreads = 2;
constexpr int kPerson = 0;  // of COCO's classes
constexpr float kThreshold = 0.25f;

int fail(const std::string& text) {
  std::fprintf(stderr, "street-control: %s\n", text.c_str());
  return 1;
}

// Finds, follows, counts, writes and draws.
class Street {
 public:
  // `inputs` may be null; it is read until this ends.
  Street(const std::string& model, std::shared_ptr<const weir::zone::ZoneSet> zones,
         std::istream* inputs)
      : detector_(model), inputs_(inputs) {
    counter_.set_zones(std::move(zones));
  }

  void see(int64_t time, cv::Mat* picture) {
    auto people = detector_.find(*picture, kPerson, kThreshold, inputs_);
    follow(time, &people);
    sightings_.clear();
    for (const auto& person : people)
      sightings_.push_back(
          {.track = person.track, .class_index = person.class_index, .box = person.box});
    counter_.update(time, sightings_);
    std::fputs(street::results_text(time, people, counter_).c_str(), stdout);
    std::fflush(stdout);
    street::draw_people(people, picture);
    street::draw_zones(counter_, picture);
  }

 private:
  void follow(int64_t time, std::vector<street::Detection>* people) {
    boxes_.clear();
    for (const auto& person : *people) boxes_.push_back({.box = person.box, .score = person.score});
    const auto& numbers = tracker_.follow(boxes_, static_cast<double>(time) / 1e9, {});
    for (size_t i = 0; i < people->size(); ++i) (*people)[i].track = numbers[i];
  }

  street::Detector detector_;
  std::istream* const inputs_;
  weir::track::Tracker tracker_;
  std::vector<weir::track::Observation> boxes_;
  weir::zone::ZoneCounter counter_;
  std::vector<weir::zone::Sighting> sightings_;
};

int run(const std::string& model, const std::string& zone_file, const std::string& video,
        const std::string& drawn) {
  auto zones = weir::zone::read_zones(zone_file);
  if (!zones) return fail(zones.error().message());
  const char* const input_file = std::getenv("INPUTS");
  std::ifstream inputs;
  if (input_file) inputs.open(input_file, std::ios::binary);
  if (input_file && !inputs)
    return fail(std::string(input_file) + ": the file with the network's inputs cannot be read");
  Street street(model, std::make_shared<const weir::zone::ZoneSet>(*std::move(zones)),
                input_file ? &inputs : nullptr);
  cv::VideoCapture capture(video);
  if (!capture.isOpened()) return fail(video + ": OpenCV cannot open this video");
  const double rate = capture.get(cv::CAP_PROP_FPS);
  if (!(rate > 0)) return fail(video + ": the video has no frame rate");
  cv::VideoWriter writer;
  cv::Mat picture;
  for (int64_t frame = 0; capture.read(picture); ++frame) {
    street.see(static_cast<int64_t>(1e9 * static_cast<double>(frame) / rate), &picture);
    if (input_file && !inputs)
      return fail(std::string(input_file) + ": has no input for frame " + std::to_string(frame));
    if (drawn.empty()) continue;
    if (!writer.isOpened() &&
        !writer.open(drawn, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), rate, picture.size()))
      return fail(drawn + ": cannot be written");
    writer.write(picture);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4 && argc != 5)
    return fail("usage: street-control MODEL.onnx ZONES.json VIDEO [DRAWN.avi]");
  cv::setNumThreads(kThreads);
  try {
    return run(argv[1], argv[2], argv[3], argc == 5 ? argv[4] : "");
  } catch (const cv::Exception& error) {
    return fail(std::string(argv[1]) + ": " + error.what());
  }
}
