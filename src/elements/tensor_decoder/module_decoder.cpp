// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_decoder/module_decoder.hpp"

#include <gst/gst.h>

#include <optional>
#include <string>
#include <vector>

#include "core/infer/module/host.hpp"
#include "core/ledger/ledger.hpp"
#include "core/limit/buffer_limit.hpp"
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/memory_part.hpp"
#include "gstcpp/buffer/module_values.hpp"

namespace weir {
namespace {

// Receives a decoder's caps and output, and writes them to one GstBuffer.
class BufferSink final : public weir_sink {
 public:
  BufferSink() = default;  // for configure: accepts caps only
  BufferSink(GstBuffer* in, GstBuffer* out, const gst::FrameLayout* reader,
             const BufferLimit& limit, Ledger* ledger)
      : in_(in), out_(out), reader_(reader), limit_(&limit), ledger_(ledger) {}
  ~BufferSink() = default;

  Status set_caps(const std::string& caps) override;
  void* reserve(uint64_t bytes) override;
  Status share_input(uint32_t index) override;
  // Appends the reserved and shared parts to the buffer in order: one memory each; of more than 16,
  // the 16th and all later ones share one. LIMIT_EXCEEDED, OUT_OF_MEMORY, MAPPING_FAILED.
  Status finish();
  const std::string& caps() const noexcept { return caps_; }
  // Why reserve() returned null: LIMIT_EXCEEDED or OUT_OF_MEMORY.
  const std::optional<Error>& refusal() const noexcept { return refusal_; }

 private:
  GstBuffer* in_ = nullptr;   // borrowed
  GstBuffer* out_ = nullptr;  // borrowed; null while configuring
  const gst::FrameLayout* reader_ = nullptr;
  const BufferLimit* limit_ = nullptr;  // borrowed
  Ledger* ledger_ = nullptr;
  uint64_t reserved_ = 0;  // bytes
  std::optional<Error> refusal_;
  std::string caps_;
  std::vector<gst::BufferPart> parts_;   // parts of the output
  std::vector<gst::MappedMemory> maps_;  // of reserved parts, until finish()
};

Status BufferSink::set_caps(const std::string& caps) {
  caps_ = caps;
  return ok();
}

void* BufferSink::reserve(uint64_t bytes) {
  if (!out_ || bytes > G_MAXSSIZE) return nullptr;
  auto allowed = limit_->check(reserved_ + bytes);
  auto memory = allowed ? gst::allocate_memory(bytes) : std::move(allowed).error();
  if (!memory) {
    refusal_ = memory.error();
    return nullptr;
  }
  reserved_ += bytes;
  maps_.emplace_back(memory->get(), GST_MAP_WRITE);
  parts_.push_back({*std::move(memory), {}});
  return maps_.back() ? static_cast<void*>(maps_.back().bytes().data()) : nullptr;
}

Status BufferSink::share_input(uint32_t index) {
  if (!out_ || index >= reader_->tensors().size())
    return Error{.code = Code::CALLBACK_FAILED,
                 .what = "a decoder shares a tensor that does not exist",
                 .offered = std::to_string(index)};
  const auto& view = reader_->tensors()[index];
  if (view.memory < 0) {
    parts_.push_back({{}, view.payload});
    return ok();
  }
  uint64_t copied = 0;
  auto part = gst::make_part(gst_buffer_peek_memory(in_, static_cast<guint>(view.memory)),
                             view.header_bytes, view.payload.size(), &copied);
  if (!part) return part.error();
  if (copied > 0) ledger_->copied(copied);
  parts_.push_back({*std::move(part), {}});
  return ok();
}

Status BufferSink::finish() {
  maps_.clear();
  return gst::append_parts(parts_, out_, [this](size_t bytes) -> Result<gst::Ref<GstMemory>> {
    if (auto status = limit_->check(reserved_ + bytes); !status) return status.error();
    auto memory = gst::allocate_memory(bytes);
    if (!memory) return memory;
    ledger_->copied(bytes);
    reserved_ += bytes;
    return memory;
  });
}

}  // namespace

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

Result<bool> ModuleDecoder::decode(const FrameSpec&, GstBuffer* in, const gst::FrameLayout& reader,
                                   GstBuffer* out, const BufferLimit& limit, Ledger* ledger) {
  BufferSink sink(in, out, &reader, limit, ledger);
  auto kept = decoder_->decode(arguments_.fill(reader, in, decoder_->needs_headers()), &sink);
  if (sink.refusal()) return *sink.refusal();
  if (!kept || !*kept) return kept;
  if (auto status = sink.finish(); !status) return status.error();
  return kept;
}

}  // namespace weir
