// SubPluginMedium: a stream converted by an NNStreamer converter: a sub-plugin
// (registerExternalConverter) or a function (nnstreamer_converter_custom_register). Each frame
// carries its own specs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/infer/queue/call_gate.hpp"
#include "elements/tensor_converter/flexible_medium.hpp"
#include "gstcpp/buffer/c_tensors.hpp"
#include "nnstreamer/nnstreamer_plugin_api_converter.h"
#include "nnstreamer/tensor_converter_custom.h"

namespace weir {

class SubPluginMedium final : public Medium {
 public:
  // Passes `script` to the converter unless it is empty. CALLBACK_FAILED when it cannot be opened.
  static Result<std::unique_ptr<Medium>> open(const NNStreamerExternalConverter& type,
                                              const std::optional<std::string>& script = {});
  // For a registered function, which is called through `gate`.
  SubPluginMedium(std::string name, tensor_converter_custom function, void* data,
                  std::shared_ptr<infer::CallGate> gate);
  ~SubPluginMedium() override;

  Result<StreamPlan> configure(const GstCaps* caps, const Preferences& preferences) override;
  // Returns the converter's own buffer, not copied.
  Result<MediumFrames> frames(gst::Ref<GstBuffer> buffer, Ledger* ledger) override;
  MediaType type() const noexcept override { return MediaType::Tensor; }

 private:
  explicit SubPluginMedium(const NNStreamerExternalConverter& type);
  // The output for these caps when the peer does not fix it.
  Result<FrameSpec> first_spec(const GstCaps* caps) const;
  Result<gst::Ref<GstBuffer>> convert(GstBuffer* in, GstTensorsConfig* config);
  Result<MediumFrames> read_tensors(gst::Ref<GstBuffer> made, FrameSpec* spec, Ledger* ledger);

  const std::string name_;
  // A copy: the program may unregister its own meanwhile. nullopt: a function.
  const std::optional<NNStreamerExternalConverter> type_;
  tensor_converter_custom function_ = nullptr;
  std::shared_ptr<infer::CallGate> gate_ = std::make_shared<infer::CallGate>();
  void* data_ = nullptr;  // of the function, or from the converter's open()
  bool opened_ = false;
  std::vector<TensorSpec> user_;
  uint32_t frames_per_tensor_ = 1;
  Fraction rate_;            // of the input
  FlexibleMedium flexible_;  // strips the headers that the converter added
};

// The NNStreamer converter of this name or for caps of it; null if there is none.
Result<std::unique_ptr<Medium>> sub_plugin_medium_for(const char* caps_name);
// The caps that registered NNStreamer converters accept, and those named like a converter.
gst::Ref<GstCaps> caps_of_sub_plugin_converters();

}  // namespace weir
