// A stream's tensors in the C structs of include/nnstreamer, and back, checked.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "gstcpp/frame_reader.hpp"
#include "nnstreamer/tensor_typedef.h"
#include "weir/result.hpp"

namespace weir::gst {

// Owns a GstTensorsConfig with what it points to; what a callee puts there (g_malloc) too.
class CTensors {
 public:
  explicit CTensors(const FrameSpec& spec = {Format::Static, {}, {}});
  ~CTensors();
  CTensors(const CTensors&) = delete;
  CTensors& operator=(const CTensors&) = delete;
  GstTensorsConfig* get() noexcept { return &config_; }
  // As ours. CALLBACK_FAILED, naming `who`, for a count, format, type or dimensions that cannot be;
  // a flexible stream may have no tensors.
  Result<FrameSpec> spec(const std::string& who) const;

 private:
  GstTensorsConfig config_{};
};

// The bytes of each tensor, borrowed from the reader; of flexible streams with their headers.
std::vector<GstTensorMemory> c_memories(const FrameReader& reader);

}  // namespace weir::gst
