// Caps of video in device memory; the error gives the element that downloads it to system memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir::gst {

// Raw video in memory for which a download element is known: on the GPU (GL, CUDA, VA, NVMM), and
// DMABuf caps whose mapping does not show pixels. Elements accept these caps only to reject them
// with a useful error.
Ref<GstCaps> video_of_devices();

// FORMAT_UNSUPPORTED when the first structure is such video; `element` ends the pipeline text of
// the fix.
Status check_memory(const GstCaps* caps, const std::string& element);

}  // namespace weir::gst
