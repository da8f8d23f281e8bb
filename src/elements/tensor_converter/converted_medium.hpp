// ConvertedMedium: tensors made by an external converter module or a registered function; each
// frame carries its own specs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "core/infer/module/converter.hpp"
#include "elements/tensor_converter/medium.hpp"

namespace weir {

class ConvertedMedium final : public Medium {
 public:
  explicit ConvertedMedium(std::unique_ptr<infer::Converter> converter)
      : converter_(std::move(converter)) {}

  Result<StreamPlan> configure(const GstCaps* caps, const Preferences& preferences) override;
  // Uses the converter's memory, or parts of the buffer's, without a copy; with frames-per-tensor,
  // collects that many frames.
  Result<MediumFrames> frames(gst::Ref<GstBuffer> buffer, Ledger* ledger) override;
  MediaType type() const noexcept override { return MediaType::Tensor; }
  void reset() noexcept override { converter_->reset(); }

 private:
  std::unique_ptr<infer::Converter> converter_;
  std::vector<TensorSpec> user_;
  uint32_t frames_per_tensor_ = 1;
};

}  // namespace weir
