// Fuzz target: reads truth of labelled folders: annotations of COCO, sequences of MOTChallenge, and
// run lengths of masks. Accepted truth has boxes with an area, categories and frames that exist.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>
#include <numeric>
#include <string>

#include "core/evaluate/coco_truth.hpp"
#include "core/evaluate/mot_truth.hpp"
#include "core/records/run_lengths.hpp"
#include "fuzz_input.hpp"

namespace {

using namespace weir;
using fuzz::require;

void read_coco(const std::string& text) {
  const auto truth = evaluate::parse_coco_truth("fuzz", text);
  if (!truth) {
    require(!truth.error().what.empty() && !truth.error().needed.empty(), "an error has a text");
    return;
  }
  require(!truth->categories.empty() && !truth->pictures.empty(), "there is something to find");
  for (const auto& picture : truth->pictures)
    for (const auto& object : picture.objects) {
      require(object.category < truth->categories.size(), "a category exists");
      require(object.box.area() > 0 && std::isfinite(object.box.area()), "a box has an area");
      require(std::isfinite(object.area) && object.area >= 0, "an object has an area");
      require(object.points.empty() || object.points.size() == truth->key_points,
              "objects have the same key points");
    }
}

void read_mot(const std::string& text) {
  const size_t end = text.find("---\n");
  const auto info = evaluate::parse_sequence_info("fuzz", text.substr(0, end));
  evaluate::SequenceInfo used{"fuzz", "img1", ".jpg", 30, 5, 640, 480};
  if (info) {
    require(info->frames > 0 && info->width > 0 && info->height > 0, "a sequence has pictures");
    require(info->frame_rate > 0 && std::isfinite(info->frame_rate), "a sequence has a rate");
  }
  if (end == std::string::npos) return;
  const auto truth = evaluate::parse_mot_truth("fuzz", text.substr(end + 4), used);
  if (!truth) return;
  require(truth->size() == used.frames, "each frame has a list");
  for (const auto& frame : *truth)
    for (const auto& box : frame.counted)
      require(box.box.width > 0 && box.box.height > 0, "a box has an area");
}

void read_runs(const std::string& text) {
  constexpr uint64_t kPixels = 1000;
  const auto runs = records::runs_of_text(text, kPixels);
  if (runs)
    require(std::accumulate(runs->begin(), runs->end(), uint64_t{0}) == kPixels,
            "the runs are the pixels");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  read_coco(text);
  read_mot(text);
  read_runs(text);
  return 0;
}
