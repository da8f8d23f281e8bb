// Fuzz target: decodes tensors of any shape and content with image_segment, pose_estimation and
// tensor_region, and reads key point files and prior boxes. Pixels have the colours of the mode,
// and regions have a header.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <array>
#include <string>

#include "core/tensor/tensor_header.hpp"
#include "decoder_fuzz.hpp"
#include "memory_file.hpp"

namespace {

using weir::fuzz::decode_frames;
using weir::fuzz::FuzzInput;
using weir::fuzz::MemoryFile;
using weir::fuzz::require;
using Words = std::span<const uint32_t>;

constexpr std::array<int64_t, 10> kExtents{1, 2, 3, 4, 5, 6, 8, 14, 21, 28};

// The next line, in which semicolons end lines.
std::string make_lines(FuzzInput* input) {
  std::string text(input->line());
  std::replace(text.begin(), text.end(), ';', '\n');
  return text;
}

// A size from the input, unless its frames take long to look at.
std::string small_size(FuzzInput* input) {
  std::string size(input->line());
  return size.size() > 5 ? "32:32" : size;
}

void segment(FuzzInput* input) {
  static constexpr std::array kKinds{"tflite-deeplab", "snpe-deeplab", "snpe-depth"};
  const std::string kind = kKinds[input->below(uint32_t{kKinds.size()})];
  decode_frames("image_segment", {{"option1", kind}, {"option2", std::string(input->line())}},
                kExtents, input, [](Words pixels) {
                  for (const uint32_t pixel : pixels)
                    require(pixel == 0 || pixel >> 24 == 0xFF, "a pixel is opaque or transparent");
                });
}

void find_pose(FuzzInput* input) {
  const MemoryFile body(make_lines(input));
  weir::infer::Decoder::Options options{
      {"option1", small_size(input)},
      {"option2", std::string(input->line())},
      {"option4", input->flag() ? "heatmap-offset" : "heatmap-only"}};
  if (input->flag()) options.emplace_back("option3", body.path());
  decode_frames("pose_estimation", options, kExtents, input, [](Words pixels) {
    for (const uint32_t pixel : pixels)
      require(pixel == 0 || pixel == 0xFFFFFFFF, "a pixel is white or transparent");
  });
}

void find_regions(FuzzInput* input) {
  const MemoryFile priors(make_lines(input));
  const MemoryFile labels("background\na\nb\n");
  const std::string count(input->line());
  decode_frames("tensor_region",
                {{"option1", count},
                 {"option2", labels.path()},
                 {"option3", priors.path() + std::string(input->line())},
                 {"option4", std::string(input->line())}},
                kExtents, input, [](Words words) {
                  const auto header = weir::read_tensor_chunk(std::as_bytes(words));
                  require(header && header->spec.shape[0] == 4, "regions have a header");
                  require(words.size() == 32 + *header->spec.shape.count(),
                          "a region is four numbers");
                });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzInput input(data, size);
  const uint32_t mode = input.below(3);
  if (mode == 0)
    segment(&input);
  else if (mode == 1)
    find_pose(&input);
  else
    find_regions(&input);
  return 0;
}
