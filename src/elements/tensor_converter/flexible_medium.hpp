// FlexibleMedium: converts flexible tensors to static ones; each frame's headers give its specs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "elements/tensor_converter/medium.hpp"
#include "gstcpp/buffer/frame_layout.hpp"

namespace weir {

class FlexibleMedium final : public Medium {
 public:
  Result<StreamPlan> configure(const GstCaps* caps, const Preferences& preferences) override;
  // The payloads without headers, sharing memory.
  Result<MediumFrames> frames(gst::Ref<GstBuffer> buffer, Ledger* ledger) override;
  MediaType type() const noexcept override { return MediaType::Tensor; }

 private:
  Result<std::vector<TensorSpec>> read(GstBuffer* buffer);

  std::vector<TensorSpec> user_;
  gst::FrameLayout reader_;
};

}  // namespace weir
