// OctetMedium: bytes as tensors that the user or the peer specifies, or, for flexible tensors, one
// byte tensor per buffer.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "elements/tensor_converter/medium.hpp"

namespace weir {

class OctetMedium final : public Medium {
 public:
  Result<StreamPlan> configure(const GstCaps* caps, const Preferences& preferences) override;
  Status accepts(const GstBuffer* buffer) const override;
  Result<MediumFrames> frames(gst::Ref<GstBuffer> buffer, Ledger* ledger) override;
  MediaType type() const noexcept override { return MediaType::Octet; }

 private:
  StreamPlan plan_;
};

}  // namespace weir
