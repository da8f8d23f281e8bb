// ConvertedMedium: a stream that an external converter, or a function of the process, makes into
// tensors; each frame says its own.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "core/infer/converter.hpp"
#include "elements/tensor_converter/medium.hpp"

namespace weir {

class ConvertedMedium final : public Medium {
 public:
  explicit ConvertedMedium(std::unique_ptr<infer::Converter> converter)
      : converter_(std::move(converter)) {}

  Result<StreamPlan> configure(const GstCaps* caps, const Wishes& wishes) override;
  // The memory that the converter allocated, not copied; the tensors of frames-per-tensor frames.
  Result<MediumFrames> frames(gst::Ref<GstBuffer> buffer, Ledger* ledger) override;
  MediaType type() const noexcept override { return MediaType::Tensor; }
  void reset() noexcept override { converter_->reset(); }

 private:
  std::unique_ptr<infer::Converter> converter_;
  std::vector<TensorSpec> user_;
  uint32_t frames_per_tensor_ = 1;
};

}  // namespace weir
