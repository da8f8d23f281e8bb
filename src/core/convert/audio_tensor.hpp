// AudioTensor: the tensor of raw interleaved audio (docs/compatibility/converter.md 2.3).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "core/tensor/frame_spec.hpp"

namespace weir {

struct AudioTensor {
  TensorSpec spec;           // channels:frames
  uint64_t frame_bytes = 0;  // one sample of every channel
};

// `format` is GStreamer's name, such as "S16LE". FORMAT_UNSUPPORTED, with an audioconvert line, for
// the other byte order and for formats without an element type.
Result<AudioTensor> audio_tensor(std::string_view format, uint32_t channels,
                                 uint32_t frames_per_tensor);

// The format with samples of this type in native byte order; "" if there is none.
std::string to_audio_format(ElementType type);

}  // namespace weir
