// Fuzz target: converts raw video and audio of any format and size to tensors, also several frames
// to one tensor. The tensor's bytes are those of the medium.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <array>

#include "core/convert/audio_tensor.hpp"
#include "core/convert/stacked_tensor.hpp"
#include "core/convert/video_tensor.hpp"
#include "fuzz_input.hpp"

namespace {

using weir::fuzz::FuzzInput;
using weir::fuzz::multiplies_to;
using weir::fuzz::require;

// Sizes with all 32 bits, or close to each other.
uint32_t number(FuzzInput* input) {
  return input->flag() ? input->take<uint32_t>() : input->take<uint16_t>();
}

void check_video(std::string_view format, FuzzInput* input) {
  const uint32_t width = number(input), height = number(input), frames = number(input);
  const auto video = weir::video_tensor(format, width, height, frames);
  if (!video) return require(!video.error().what.empty(), "an error has a text");
  const auto bytes = video->spec.bytes();
  require(bytes.has_value(), "a tensor has a size");
  require(multiplies_to(video->row_bytes * video->rows, frames, *bytes), "rows fill the tensor");
}

void check_audio(std::string_view format, FuzzInput* input) {
  const uint32_t channels = number(input), frames = number(input);
  const auto audio = weir::audio_tensor(format, channels, frames);
  if (!audio) return require(!audio.error().what.empty(), "an error has a text");
  const auto bytes = audio->spec.bytes();
  require(bytes.has_value(), "a tensor has a size");
  require(multiplies_to(audio->frame_bytes, frames, *bytes), "samples fill the tensor");
}

void check_gathered(FuzzInput* input) {
  std::array<uint32_t, weir::kRankLimit> dims{};
  const size_t rank = input->below(weir::kRankLimit + 1);
  weir::TensorSpec frame;
  frame.type = static_cast<weir::ElementType>(input->below(11));
  for (size_t i = 0; i < rank; ++i) dims[i] = number(input);
  frame.shape = weir::Shape(std::span<const uint32_t>(dims).first(rank));
  if (!frame.valid() || !frame.bytes()) return;
  const uint32_t frames = number(input);
  if (frames == 0) return;
  const auto gathered = weir::stacked_tensor(frame, frames);
  if (!gathered) return require(!gathered.error().what.empty(), "an error has a text");
  require(multiplies_to(*frame.bytes(), frames, gathered->bytes().value_or(0)),
          "frames fill the tensor");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzInput input(data, size);
  const auto kind = input.below(3);
  const auto format = input.line();
  if (kind == 0) check_video(format, &input);
  if (kind == 1) check_audio(format, &input);
  if (kind == 2) check_gathered(&input);
  return 0;
}
