// AudioMedium: raw interleaved audio as tensors that share the buffer's memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "elements/tensor_converter/medium.hpp"

namespace weir {

class AudioMedium final : public Medium {
 public:
  Result<StreamPlan> configure(const GstCaps* caps, const Preferences& preferences) override;
  Result<MediumFrames> frames(gst::Ref<GstBuffer> buffer, Ledger* ledger) override;
  MediaType type() const noexcept override { return MediaType::Audio; }

  // The audio format whose tensor is `peer`, as caps text; "" if there is none.
  static std::string caps_for(const TensorSpec& peer, const Fraction& rate);

 private:
  StreamPlan plan_;
};

}  // namespace weir
