// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/convert/audio_tensor.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "weir/join.hpp"

namespace weir {
namespace {

struct Sample {
  std::string_view format;  // without byte order
  ElementType type;
};
constexpr std::array kSamples{
    Sample{"S8", ElementType::Int8},     Sample{"U8", ElementType::UInt8},
    Sample{"S16", ElementType::Int16},   Sample{"U16", ElementType::UInt16},
    Sample{"S32", ElementType::Int32},   Sample{"U32", ElementType::UInt32},
    Sample{"F32", ElementType::Float32}, Sample{"F64", ElementType::Float64}};
constexpr const char* kNative = std::endian::native == std::endian::little ? "LE" : "BE";

std::string spelled(const Sample& sample) {
  return std::string(sample.format) + (element_size(sample.type) > 1 ? kNative : "");
}

}  // namespace

Result<AudioTensor> audio_tensor(std::string_view format, uint32_t channels,
                                 uint32_t frames_per_tensor) {
  const auto sample = std::find_if(kSamples.begin(), kSamples.end(),
                                   [&](const auto& s) { return spelled(s) == format; });
  if (sample == kSamples.end()) {
    const std::string needed = join(kSamples, ", ", [](const auto& s) { return spelled(s); });
    return Error{.code = Code::FORMAT_UNSUPPORTED,
                 .what = "this audio format cannot be a tensor",
                 .offered = std::string(format),
                 .needed = needed,
                 .fix = "audioconvert ! audio/x-raw,format=S16" + std::string(kNative) +
                        ",layout=interleaved ! tensor_converter"};
  }
  AudioTensor out;
  out.spec = {sample->type, Shape{channels, frames_per_tensor}, ""};
  out.frame_bytes = uint64_t{channels} * element_size(sample->type);
  if (frames_per_tensor == 0 || !out.spec.valid() || !out.spec.bytes())
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "an audio tensor is too big or empty",
                 .offered = out.spec.to_string(),
                 .needed = "at least one channel and one frame"};
  return out;
}

std::string to_audio_format(ElementType type) {
  const auto sample =
      std::find_if(kSamples.begin(), kSamples.end(), [&](const auto& s) { return s.type == type; });
  return sample == kSamples.end() ? "" : spelled(*sample);
}

}  // namespace weir
