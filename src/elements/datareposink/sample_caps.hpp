// SampleCaps: what a sample of a data repository is, by the caps of its stream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "core/tensor/frame_spec.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir {

struct SampleCaps {
  enum class Medium {
    StaticTensors,
    HeaderedTensors,  // flexible and sparse: each tensor has a header, and samples differ in size
    Video,
    Audio,
    Image,  // encoded; a file for each sample
    Bytes,  // text, application/octet-stream
  };

  Medium medium = Medium::Bytes;
  gst::Ref<GstCaps> caps{};
  FrameSpec tensors{};  // of the first two media
  uint64_t bytes = 0;   // of a sample of audio (one second), video and static tensors; else 0
  Fraction rate{};      // of samples; not valid if the caps have none
};

// FORMAT_UNSUPPORTED for caps of other media, and for caps that are not fixed or not complete.
Result<SampleCaps> read_sample_caps(GstCaps* caps);

}  // namespace weir
