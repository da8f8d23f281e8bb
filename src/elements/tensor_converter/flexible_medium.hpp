// FlexibleMedium: flexible tensors become static ones; each frame's headers say what it is.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "elements/tensor_converter/medium.hpp"
#include "gstcpp/frame_reader.hpp"

namespace weir {

class FlexibleMedium final : public Medium {
 public:
  Result<StreamPlan> configure(const GstCaps* caps, const Wishes& wishes) override;
  // The payloads without headers, shared.
  Result<MediumFrames> frames(gst::Ref<GstBuffer> buffer, Ledger* ledger) override;
  MediaType type() const noexcept override { return MediaType::Tensor; }

 private:
  Result<std::vector<TensorSpec>> read(GstBuffer* buffer);

  std::vector<TensorSpec> user_;
  gst::FrameReader reader_;
};

}  // namespace weir
