// What raw interleaved audio is as a tensor (specification 2).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "core/tensor/frame_spec.hpp"

namespace weir {

struct AudioTensor {
  TensorSpec spec;           // channels:frames
  uint64_t frame_bytes = 0;  // of one sample of every channel
};

// `format` is GStreamer's name, such as "S16LE". FORMAT_UNSUPPORTED with the audioconvert line for
// the other byte order and for formats that no tensor has.
Result<AudioTensor> audio_tensor(std::string_view format, uint32_t channels,
                                 uint32_t frames_per_tensor);

// The format whose samples are of this type, in this machine's byte order; "" when there is none.
std::string audio_format_of(ElementType type);

}  // namespace weir
