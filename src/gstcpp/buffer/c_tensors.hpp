// CTensors: a stream's tensors as the C structs of include/nnstreamer, validated when read back.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "nnstreamer/tensor_typedef.h"
#include "weir/result.hpp"

namespace weir::gst {

// Owns a GstTensorsConfig and all that it points to, including what a callee allocates (g_malloc).
class CTensors {
 public:
  explicit CTensors(const FrameSpec& spec = {Format::Static, {}, {}});
  ~CTensors();
  CTensors(const CTensors&) = delete;
  CTensors& operator=(const CTensors&) = delete;
  GstTensorsConfig* get() noexcept { return &config_; }
  // Converts to our type. CALLBACK_FAILED, naming `who`, for an invalid count, format, type or
  // dimensions. A flexible stream may have no tensors.
  Result<FrameSpec> spec(const std::string& who) const;

 private:
  GstTensorsConfig config_{};
};

// The bytes of each tensor, borrowed from the reader; in flexible streams with their headers.
std::vector<GstTensorMemory> c_memories(const FrameLayout& reader);

}  // namespace weir::gst
