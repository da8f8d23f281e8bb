// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_decoder/sub_plugin_decoder.hpp"

#include "core/infer/module/guarded_call.hpp"
#include "core/subplugin/table.hpp"
#include "gstcpp/buffer/c_tensors.hpp"

namespace weir {
namespace {

using gst::Ref;

// The tensors of this frame: those of the stream, or those of its headers.
FrameSpec of_frame(const FrameSpec& stream, const gst::FrameLayout& reader) {
  if (stream.format == Format::Static) return stream;
  FrameSpec frame = stream;
  frame.tensors.clear();
  for (const auto& view : reader.tensors()) frame.tensors.push_back(view.spec);
  return frame;
}

// Maps a flow return and the buffer to a result. False: the frame is dropped.
Result<bool> taken(const std::string& who, int flow, GstBuffer* out) {
  if (flow > 0) return false;
  if (flow < 0)
    return Error{.code = Code::CALLBACK_FAILED,
                 .what = who + " failed on a frame",
                 .offered = gst_flow_get_name(static_cast<GstFlowReturn>(flow)),
                 .needed = "ok",
                 .fix = "read its log lines: GST_DEBUG=weir*:5"};
  if (gst_buffer_n_memory(out) == 0)
    return Error{.code = Code::CALLBACK_FAILED,
                 .what = who + " returned success without an output",
                 .offered = "a buffer without memory",
                 .needed = "memory in the buffer, or a flow return below 0",
                 .fix = "correct " + who};
  return true;
}

}  // namespace

SubPluginDecoder::SubPluginDecoder(const GstTensorDecoderDef& type, void* priv)
    : type_(type), name_("the decoder " + std::string(type.modename)), priv_(priv) {}

SubPluginDecoder::~SubPluginDecoder() {
  if (type_.exit) type_.exit(&priv_);
}

Result<OpenDecoder> SubPluginDecoder::open(const GstTensorDecoderDef& type,
                                           const DecoderOptions& options) {
  void* priv = nullptr;
  if (!type.init(&priv))
    return Error{.code = Code::CALLBACK_FAILED,
                 .what = "the decoder " + std::string(type.modename) + " cannot be opened",
                 .offered = "its init returned FALSE",
                 .needed = "TRUE",
                 .fix = "read its log lines: GST_DEBUG=weir*:5"};
  const std::shared_ptr<SubPluginDecoder> decoder(new SubPluginDecoder(type, priv));
  OpenDecoder out{decoder, decoder, {}};
  for (size_t i = 0; i < options.numbered.size(); ++i) {
    const auto& value = options.numbered[i];
    if (!value) continue;
    if (type.setOption && type.setOption(&decoder->priv_, static_cast<int>(i), value->c_str()))
      continue;
    out.warnings.push_back(
        {.code = Code::OPTION_VALUE,
         .what = decoder->name_ + " does not accept an option and continues without it",
         .offered = "option" + std::to_string(i + 1) + "=" + *value,
         .needed = type.setOption ? "a value that it takes" : "no options: it has none"});
  }
  return out;
}

Result<Ref<GstCaps>> SubPluginDecoder::configure(const FrameSpec& input) {
  gst::CTensors config(input);
  std::lock_guard lock(mutex_);
  auto caps = Ref<GstCaps>::adopt(type_.getOutCaps(&priv_, config.get()));
  if (!caps)
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = name_ + " does not accept these tensors",
                 .offered = input.to_string(),
                 .needed = "tensors that it accepts",
                 .fix = "put tensor_transform before tensor_decoder to convert them"};
  if (!GST_IS_CAPS(caps.get()) || gst_caps_is_empty(caps.get()) || gst_caps_is_any(caps.get()))
    return Error{.code = Code::CALLBACK_FAILED,
                 .what = name_ + " returned caps without any media type",
                 .offered = GST_IS_CAPS(caps.get()) ? gst_caps_is_any(caps.get()) ? "ANY" : "EMPTY"
                                                    : "something else",
                 .needed = "caps, for example text/x-raw,format=(string)utf8",
                 .fix = "correct its getOutCaps"};
  return caps;
}

Result<bool> SubPluginDecoder::decode(const FrameSpec& input, GstBuffer*,
                                      const gst::FrameLayout& reader, GstBuffer* out,
                                      const BufferLimit&, Ledger*) {
  gst::CTensors config(of_frame(input, reader));
  const auto memories = gst::c_memories(reader);
  std::lock_guard lock(mutex_);
  const auto flow = infer::call_guarded(name_, "return a flow below 0", [&] {
    return type_.decode(&priv_, config.get(), memories.data(), out);
  });
  if (!flow) return flow.error();
  return taken(name_, *flow, out);
}

Result<OpenDecoder> CustomCodeDecoder::open(const std::string& name) {
  const auto entry = subplugin::custom_decoders().find(name);
  if (!entry)
    return Error{.code = Code::CALLBACK_UNKNOWN,
                 .what = "no decoder is registered under this name",
                 .offered = "mode=custom-code option1=" + name,
                 .needed = subplugin::custom_decoders().one_of(),
                 .fix = "nnstreamer_decoder_custom_register(\"" + name +
                        "\", function, data) before the pipeline starts"};
  const auto decoder = std::make_shared<CustomCodeDecoder>(
      name, reinterpret_cast<tensor_decoder_custom>(entry->function), entry->data, entry->gate);
  return OpenDecoder{decoder, decoder, {}};
}

Result<Ref<GstCaps>> CustomCodeDecoder::configure(const FrameSpec& input) {
  auto caps = Ref<GstCaps>::adopt(gst_caps_new_empty_simple("application/octet-stream"));
  if (input.rate.valid())
    gst_caps_set_simple(caps.get(), "framerate", GST_TYPE_FRACTION, input.rate.numerator,
                        input.rate.denominator, nullptr);
  return caps;
}

Result<bool> CustomCodeDecoder::decode(const FrameSpec& input, GstBuffer*,
                                       const gst::FrameLayout& reader, GstBuffer* out,
                                       const BufferLimit&, Ledger*) {
  gst::CTensors config(of_frame(input, reader));
  const auto memories = gst::c_memories(reader);
  const auto flow = infer::call_guarded(*gate_, who_, "return a number below 0", [&] {
    return function_(memories.data(), config.get(), data_, out);
  });
  if (!flow) return flow.error();
  return taken(who_, *flow, out);
}

}  // namespace weir
