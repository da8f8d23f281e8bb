// VideoMedium: raw video as tensors; shares dense rows and copies padded ones.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "elements/tensor_converter/dense_video.hpp"
#include "elements/tensor_converter/medium.hpp"

namespace weir {

class VideoMedium final : public Medium {
 public:
  Result<StreamPlan> configure(const GstCaps* caps, const Preferences& preferences) override;
  Result<MediumFrames> frames(gst::Ref<GstBuffer> buffer, Ledger* ledger) override;
  MediaType type() const noexcept override { return MediaType::Video; }
  void allocate_as(const gst::Allocation& wanted) override;
  void defer_with(const std::shared_ptr<gst::DeferredCounts>& counts) override {
    video_.defer_with(counts);
  }
  void offer(GstQuery* query) const override;

  // The video formats whose tensor is `peer`, as caps text; "" when there are none.
  static std::string caps_for(const TensorSpec& peer, const Fraction& rate);

 private:
  DenseVideo video_;
  gst::Allocation allocation_;
};

}  // namespace weir
