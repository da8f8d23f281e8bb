// ModuleDecoder: a FrameDecoder for a decoder module of Weir.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "core/infer/module/decoder.hpp"
#include "elements/tensor_decoder/frame_decoder.hpp"
#include "gstcpp/buffer/module_values.hpp"

namespace weir {

class ModuleDecoder final : public FrameDecoder {
 public:
  static Result<std::shared_ptr<FrameDecoder>> open(const weir_decoder_type& type,
                                                    const DecoderOptions& options);
  explicit ModuleDecoder(std::unique_ptr<infer::Decoder> decoder) : decoder_(std::move(decoder)) {}

  void set_model(const std::shared_ptr<const DescribedModel>& model) override { model_ = model; }
  bool uses_model() const noexcept override { return decoder_->uses_model(); }
  Result<gst::Ref<GstCaps>> configure(const FrameSpec& input) override;
  Result<bool> decode(const FrameSpec& input, GstBuffer* in, const gst::FrameLayout& reader,
                      GstBuffer* out, const BufferLimit& limit, Ledger* ledger) override;
  std::optional<Error> warning() const override { return decoder_->warning(); }
  void set_caps(const GstCaps* caps) override;
  std::vector<std::string> labels() const override { return decoder_->labels(); }
  bool reads_results() const noexcept override { return decoder_->reads_results(); }
  size_t classes() const noexcept override { return decoder_->classes(); }
  void set_labels(const gst::LabelsOfSource& of) override {
    decoder_->set_labels(of.source, of.labels);
  }
  void set_times(int64_t running_time, int64_t unix_time) noexcept override {
    decoder_->set_times(running_time, unix_time);
  }
  void reset() noexcept override { decoder_->reset(); }

 private:
  std::unique_ptr<infer::Decoder> decoder_;
  std::shared_ptr<const DescribedModel> model_;
  gst::FrameArguments arguments_;
};

}  // namespace weir
