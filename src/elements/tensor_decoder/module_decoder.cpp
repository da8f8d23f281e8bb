// Through the sink of the C ABI.
#include "elements/tensor_decoder/module_decoder.hpp"

#include "elements/tensor_decoder/buffer_sink.hpp"

namespace weir {

using gst::Ref;

Result<std::shared_ptr<FrameDecoder>> ModuleDecoder::open(const weir_decoder_type& type,
                                                          const DecoderOptions& options) {
  infer::Decoder::Options given;
  for (size_t i = 0; i < options.size(); ++i)
    if (options[i]) given.emplace_back("option" + std::to_string(i + 1), *options[i]);
  auto decoder = infer::Decoder::open(type, given);
  if (!decoder) return decoder.error();
  return std::shared_ptr<FrameDecoder>(std::make_shared<ModuleDecoder>(*std::move(decoder)));
}

Result<Ref<GstCaps>> ModuleDecoder::configure(const FrameSpec& input) {
  std::vector<weir_tensor_info> infos;
  if (input.format == Format::Static)
    for (const auto& tensor : input.tensors) infos.push_back(gst::tensor_info(tensor));
  BufferSink sink;
  if (auto status = decoder_->configure(infos, &sink); !status) return status.error();
  auto caps = Ref<GstCaps>::adopt(sink.caps().empty() ? nullptr
                                                      : gst_caps_from_string(sink.caps().c_str()));
  if (!caps || gst_caps_is_empty(caps.get()) || gst_caps_is_any(caps.get()))
    return Error{Code::CALLBACK_FAILED,
                 "the decoder gives no caps that can be read",
                 "\"" + sink.caps() + "\"",
                 "caps as text, for example text/x-raw,format=(string)utf8",
                 "",
                 "mend the decoder's configure"};
  if (input.rate.valid())
    gst_caps_set_simple(caps.get(), "framerate", GST_TYPE_FRACTION, input.rate.numerator,
                        input.rate.denominator, nullptr);
  return caps;
}

Result<bool> ModuleDecoder::decode(const FrameSpec&, GstBuffer* in, const gst::FrameReader& reader,
                                   GstBuffer* out, const BufferLimit& limit, Ledger* ledger) {
  BufferSink sink(in, out, &reader, limit, ledger);
  auto kept = decoder_->decode(arguments_.fill(reader, in), &sink);
  if (sink.refusal()) return *sink.refusal();
  if (!kept || !*kept) return kept;
  if (auto status = sink.finish(); !status) return status.error();
  return kept;
}

}  // namespace weir
