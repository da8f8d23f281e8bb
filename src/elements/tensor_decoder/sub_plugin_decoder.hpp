// SubPluginDecoder: an NNStreamer decoder, registered with nnstreamer_decoder_probe;
// CustomCodeDecoder: a function registered with nnstreamer_decoder_custom_register.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <mutex>
#include <string>

#include "core/infer/queue/call_gate.hpp"
#include "elements/tensor_decoder/frame_decoder.hpp"
#include "nnstreamer/nnstreamer_plugin_api_decoder.h"
#include "nnstreamer/tensor_decoder_custom.h"

namespace weir {

// One instance per element, as such decoders expect: they may open resources that allow one user
// only.
class SubPluginDecoder final : public FrameDecoder {
 public:
  // CALLBACK_FAILED when init() fails; rejected options are warnings.
  static Result<OpenDecoder> open(const GstTensorDecoderDef& type, const DecoderOptions& options);
  ~SubPluginDecoder() override;

  Result<gst::Ref<GstCaps>> configure(const FrameSpec& input) override;
  Result<bool> decode(const FrameSpec& input, GstBuffer* in, const gst::FrameLayout& reader,
                      GstBuffer* out, const BufferLimit& limit, Ledger* ledger) override;

 private:
  SubPluginDecoder(const GstTensorDecoderDef& type, void* priv);
  const GstTensorDecoderDef type_;  // a copy: the program may unregister its own meanwhile
  const std::string name_;
  std::mutex mutex_;  // guards the members below and each call; caps queries come from any thread
  void* priv_;
};

class CustomCodeDecoder final : public FrameDecoder {
 public:
  // CALLBACK_UNKNOWN, listing the registered names.
  static Result<OpenDecoder> open(const std::string& name);
  CustomCodeDecoder(const std::string& name, tensor_decoder_custom function, void* data,
                    std::shared_ptr<infer::CallGate> gate)
      : who_("the function " + name), function_(function), data_(data), gate_(std::move(gate)) {}

  Result<gst::Ref<GstCaps>> configure(const FrameSpec& input) override;
  Result<bool> decode(const FrameSpec& input, GstBuffer* in, const gst::FrameLayout& reader,
                      GstBuffer* out, const BufferLimit& limit, Ledger* ledger) override;

 private:
  const std::string who_;
  tensor_decoder_custom function_;
  void* data_;
  const std::shared_ptr<infer::CallGate> gate_;  // closed when the function is unregistered
};

}  // namespace weir
