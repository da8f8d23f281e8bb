// Runs a module's decoder with an output sink of the C ABI.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_decoder/module_decoder.hpp"

#include "elements/tensor_decoder/buffer_sink.hpp"
#include "gstcpp/buffer/module_values.hpp"

namespace weir {

using gst::Ref;

Result<std::shared_ptr<FrameDecoder>> ModuleDecoder::open(const weir_decoder_type& type,
                                                          const DecoderOptions& options) {
  infer::Decoder::Options given;
  for (size_t i = 0; i < options.numbered.size(); ++i)
    if (const auto& value = options.numbered[i])
      given.emplace_back("option" + std::to_string(i + 1), *value);
  for (const auto& option : options.named) given.emplace_back(option.key, option.value);
  auto decoder = infer::Decoder::open(type, given);
  if (!decoder) return decoder.error();
  return std::shared_ptr<FrameDecoder>(std::make_shared<ModuleDecoder>(*std::move(decoder)));
}

Result<Ref<GstCaps>> ModuleDecoder::configure(const FrameSpec& input) {
  std::vector<weir_tensor_info> infos;
  if (input.format == Format::Static)
    for (const auto& tensor : input.tensors) infos.push_back(gst::tensor_info(tensor));
  BufferSink sink;
  decoder_->set_stream(input.rate, input.format);
  AbiModel model;
  decoder_->set_model(model_ && has_outputs(*model_, input) ? &model.fill(*model_) : nullptr);
  if (auto status = decoder_->configure(infos, &sink); !status) return status.error();
  return gst::caps_of_decoder(sink.caps(), input.rate);
}

void ModuleDecoder::set_caps(const GstCaps* caps) {
  infer::Decoder::Options fields;
  const GstStructure* structure = gst_caps_get_structure(caps, 0);
  for (int i = 0; i < gst_structure_n_fields(structure); ++i) {
    const char* name = gst_structure_nth_field_name(structure, static_cast<guint>(i));
    if (const char* text = gst_structure_get_string(structure, name))
      fields.emplace_back(name, text);
  }
  decoder_->set_caps(fields);
}

Result<bool> ModuleDecoder::decode(const FrameSpec&, GstBuffer* in, const gst::FrameReader& reader,
                                   GstBuffer* out, const BufferLimit& limit, Ledger* ledger) {
  BufferSink sink(in, out, &reader, limit, ledger);
  auto kept = decoder_->decode(arguments_.fill(reader, in, decoder_->needs_headers()), &sink);
  if (sink.refusal()) return *sink.refusal();
  if (!kept || !*kept) return kept;
  if (auto status = sink.finish(); !status) return status.error();
  return kept;
}

}  // namespace weir
