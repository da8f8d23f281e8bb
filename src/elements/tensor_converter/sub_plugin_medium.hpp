// SubPluginMedium: a stream that a converter for NNStreamer makes into tensors: one that was
// registered with registerExternalConverter, or a function of the program
// (nnstreamer_converter_custom_register). Each frame says its own tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/infer/call_gate.hpp"
#include "elements/tensor_converter/flexible_medium.hpp"
#include "gstcpp/c_tensors.hpp"
#include "nnstreamer/nnstreamer_plugin_api_converter.h"
#include "nnstreamer/tensor_converter_custom.h"

namespace weir {

class SubPluginMedium final : public Medium {
 public:
  // Is told `script` where there is one. CALLBACK_FAILED when it cannot be opened.
  static Result<std::unique_ptr<Medium>> open(const NNStreamerExternalConverter& type,
                                              const std::optional<std::string>& script = {});
  // Of a function of the program, which is called through `gate`.
  SubPluginMedium(std::string name, tensor_converter_custom function, void* data,
                  std::shared_ptr<infer::CallGate> gate);
  ~SubPluginMedium() override;

  Result<StreamPlan> configure(const GstCaps* caps, const Wishes& wishes) override;
  // The converter's own buffer, not copied.
  Result<MediumFrames> frames(gst::Ref<GstBuffer> buffer, Ledger* ledger) override;
  MediaType type() const noexcept override { return MediaType::Tensor; }

 private:
  explicit SubPluginMedium(const NNStreamerExternalConverter& type);
  // What comes of these caps, where the next element does not say it.
  Result<FrameSpec> first_spec(const GstCaps* caps) const;
  Result<gst::Ref<GstBuffer>> convert(GstBuffer* in, GstTensorsConfig* config);

  const std::string name_;
  // A copy: the program may take its own back while this one runs. None: a function.
  const std::optional<NNStreamerExternalConverter> type_;
  tensor_converter_custom function_ = nullptr;
  std::shared_ptr<infer::CallGate> gate_ = std::make_shared<infer::CallGate>();
  void* data_ = nullptr;  // of the function, or what the converter's open gave
  bool opened_ = false;
  std::vector<TensorSpec> user_;
  uint32_t frames_per_tensor_ = 1;
  Fraction rate_;            // of the input
  FlexibleMedium flexible_;  // takes the headers off what the converter put them on
};

// The converter for NNStreamer that has this name or takes caps of it; null: there is none.
Result<std::unique_ptr<Medium>> sub_plugin_medium_for(const char* caps_name);
// The caps that registered converters for NNStreamer take, and their names where those are of caps.
gst::Ref<GstCaps> caps_of_sub_plugin_converters();

}  // namespace weir
