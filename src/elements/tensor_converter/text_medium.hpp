// TextMedium: UTF-8 text; each buffer is one frame of the size that the user sets.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "elements/tensor_converter/medium.hpp"

namespace weir {

class TextMedium final : public Medium {
 public:
  Result<StreamPlan> configure(const GstCaps* caps, const Preferences& preferences) override;
  // Pads shorter text with zeros, by a copy; cuts longer text, with one warning.
  Result<MediumFrames> frames(gst::Ref<GstBuffer> buffer, Ledger* ledger) override;
  MediaType type() const noexcept override { return MediaType::Text; }

 private:
  Result<MediumFrames> padded(GstBuffer* buffer, size_t size, Ledger* ledger) const;
  MediumFrames cut(GstBuffer* buffer, size_t size);

  size_t frame_bytes_ = 0;
  bool cut_reported_ = false;
  const BufferLimit* limit_ = nullptr;  // borrowed; set by configure()
};

}  // namespace weir
