// Caps of pictures in a device's memory: refused by the line that brings them into the system's.
#pragma once
#include <string>

#include "gstcpp/ref.hpp"
#include "weir/result.hpp"

namespace weir::gst {

// Raw video in memories for which a line is known: on the GPU (GL, CUDA, VA, NVMM), and DMABuf
// where the caps say that mapping shows no pixels. They come to an element only to be refused with
// words.
Ref<GstCaps> video_of_devices();

// FORMAT_UNSUPPORTED when the first of the caps is such video; `element` ends the line to paste.
Status check_memory(const GstCaps* caps, const std::string& element);

}  // namespace weir::gst
