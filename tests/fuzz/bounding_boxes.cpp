// Fuzz target: decodes tensors of any shape and content with every scheme of bounding_boxes. A
// frame has the size of its caps, and its pixels are red or transparent.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <array>
#include <string>

#include "decoder_fuzz.hpp"
#include "memory_file.hpp"

namespace {

using weir::fuzz::FuzzInput;
using weir::fuzz::require;

constexpr std::array<int64_t, 12> kExtents{1, 2, 3, 4, 5, 6, 7, 18, 21, 63, 200, 2016};
constexpr std::array kSchemes{
    "mobilenet-ssd", "tf-ssd",  "ov-person-detection", "yolov5",        "yolov8",
    "yolov8-obb",    "yolov10", "mp-palm-detection",   "no-such-scheme"};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzInput input(data, size);
  const std::string scheme = kSchemes[input.below(uint32_t{kSchemes.size()})];
  std::string parameters(input.line());
  std::string prior_lines(input.line());
  std::replace(prior_lines.begin(), prior_lines.end(), ';', '\n');
  const weir::fuzz::MemoryFile priors(prior_lines);
  const weir::fuzz::MemoryFile labels("a\nb\n");
  if (scheme == "mobilenet-ssd") parameters = priors.path() + parameters;
  weir::infer::Decoder::Options options{{"option1", scheme},
                                        {"option3", parameters},
                                        {"option4", std::string(input.line())},
                                        {"option5", std::string(input.line())},
                                        {"option6", input.flag() ? "1" : "0"}};
  if (input.flag()) options.emplace_back("option2", labels.path());
  // Large frames take long to look at.
  if (options[2].second.size() > 5) options[2].second = "32:32";
  weir::fuzz::decode_frames(
      "bounding_boxes", options, kExtents, &input, [](std::span<const uint32_t> pixels) {
        for (const uint32_t pixel : pixels)
          require(pixel == 0 || pixel == 0xFF0000FF, "a pixel is red or transparent");
      });
  return 0;
}
