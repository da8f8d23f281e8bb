// A decoder descriptor that calls a decoder module.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <array>
#include <list>
#include <memory>
#include <optional>

#include "compat/builtin.hpp"
#include "compat/descriptor_slots.hpp"
#include "compat/guard.hpp"
#include "compat/spec.hpp"
#include "core/infer/module/decoder.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/tensor/tensor_header.hpp"
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/module_values.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::compat {
namespace {

using gst::Ref;
constexpr int kOptions = 9;

// Receives a decoder's caps, or the memories of one frame.
class Sink final : public weir_sink {
 public:
  explicit Sink(GstBuffer* out = nullptr, const std::vector<weir_tensor>* inputs = nullptr)
      : out_(out), inputs_(inputs) {}

  Status set_caps(const std::string& text) override {
    caps = text;
    return ok();
  }
  void* reserve(uint64_t bytes) override {
    if (!out_ || bytes > G_MAXSSIZE) return nullptr;
    auto memory = gst::allocate_memory(bytes);
    if (!memory) return nullptr;
    maps_.emplace_back(memory->get(), GST_MAP_WRITE);
    parts_.push_back({*std::move(memory), {}});
    return maps_.back() ? maps_.back().bytes().data() : nullptr;
  }
  // Copies, because the caller keeps its memory.
  Status share_input(uint32_t index) override {
    if (!out_ || !inputs_ || index >= inputs_->size())
      return Error{.code = Code::CALLBACK_FAILED,
                   .what = "the decoder cannot share this input",
                   .offered = "input " + std::to_string(index)};
    const weir_tensor& input = (*inputs_)[index];
    parts_.push_back({{}, {static_cast<const std::byte*>(input.data), input.bytes}});
    return ok();
  }
  // Appends the reserved and shared parts to the buffer.
  Status finish() {
    maps_.clear();
    return gst::append_parts(parts_, out_,
                             [](size_t bytes) { return gst::allocate_memory(bytes); });
  }

  std::string caps;

 private:
  GstBuffer* out_;
  const std::vector<weir_tensor>* inputs_;
  std::vector<gst::BufferPart> parts_;  // parts of the output
  std::list<gst::MappedMemory> maps_;   // of reserved parts, until finish()
};

class BuiltinDecoder {
 public:
  explicit BuiltinDecoder(const weir_decoder_type& type) : type_(type) {}

  // Takes effect at the next stream or frame: the decoder is reopened.
  void set_option(size_t index, const char* value) {
    options_[index] = value;
    decoder_.reset();
  }
  Result<Ref<GstCaps>> configure(const FrameSpec& spec) {
    if (!decoder_) {
      infer::Decoder::Options options;
      for (size_t i = 0; i < options_.size(); ++i)
        if (options_[i]) options.emplace_back("option" + std::to_string(i + 1), *options_[i]);
      auto opened = infer::Decoder::open(type_, options);
      if (!opened) return opened.error();
      decoder_ = *std::move(opened);
    }
    std::vector<weir_tensor_info> infos;
    if (spec.format == Format::Static)
      for (const auto& tensor : spec.tensors) infos.push_back(gst::tensor_info(tensor));
    Sink sink;
    configured_.reset();
    decoder_->set_stream(spec.rate, spec.format);
    if (auto status = decoder_->configure(infos, &sink); !status) return status.error();
    auto caps = gst::caps_of_decoder(sink.caps, spec.rate);
    if (!caps) return caps;
    configured_ = spec;
    return caps;
  }
  Result<bool> decode(const FrameSpec& spec, std::vector<weir_tensor> tensors, GstBuffer* out) {
    if (!decoder_ || !configured_ || !(*configured_ == spec))
      if (auto caps = configure(spec); !caps) return caps.error();
    if (spec.format == Format::Flexible && decoder_->needs_headers())
      for (auto& tensor : tensors) {  // make_tensors() found the header in front of the payload
        tensor.data = static_cast<std::byte*>(tensor.data) - kTensorHeaderBytes;
        tensor.bytes = tensor.capacity = tensor.bytes + kTensorHeaderBytes;
      }
    weir_frame frame{};
    frame.struct_size = sizeof frame;
    frame.n_tensors = static_cast<uint32_t>(tensors.size());
    frame.tensors = tensors.data();
    frame.pts = frame.duration = frame.deadline = -1;
    Sink sink(out, &tensors);
    auto kept = decoder_->decode(frame, &sink);
    if (kept && *kept)
      if (auto status = sink.finish(); !status) return status.error();
    return kept;
  }

 private:
  const weir_decoder_type& type_;
  std::array<std::optional<std::string>, kOptions> options_;
  std::unique_ptr<infer::Decoder> decoder_;
  std::optional<FrameSpec> configured_;
};

BuiltinDecoder* opened_decoder(void** priv) {
  return static_cast<BuiltinDecoder*>(*priv);
}

// Whether programs may call the decoder without init(), as it keeps nothing between frames.
bool is_stateless(const weir_decoder_type& type) {
  static constexpr std::string_view kMessages[] = {"flatbuf", "flexbuf", "protobuf"};
  return std::find(std::begin(kMessages), std::end(kMessages), type.name) != std::end(kMessages);
}

// The decoder between init() and exit(), or one for this call. Null, with a line in the log, if it
// is not open.
class CalledDecoder {
 public:
  CalledDecoder(const char* function, const weir_decoder_type& type, void** priv)
      : opened_(priv ? opened_decoder(priv) : nullptr) {
    if (opened_) return;
    if (is_stateless(type))
      opened_ = &own_.emplace(type);
    else
      warn(function,
           "the decoder is not open: call init() first, and no other function after exit()");
  }
  explicit operator bool() const noexcept { return opened_ != nullptr; }
  BuiltinDecoder* operator->() const noexcept { return opened_; }

 private:
  BuiltinDecoder* opened_;
  std::optional<BuiltinDecoder> own_;
};

weir_tensor make_tensor(const TensorSpec& spec, void* data, size_t bytes) {
  weir_tensor tensor{};
  tensor.data = data;
  tensor.bytes = tensor.capacity = bytes;
  tensor.flags = WEIR_TENSOR_READONLY;
  tensor.fence_fd = -1;
  tensor.info = gst::tensor_info(spec);
  return tensor;
}

// In a flexible stream each tensor starts with its header.
Result<std::vector<weir_tensor>> make_tensors(const FrameSpec& spec, const GstTensorsConfig& config,
                                              const GstTensorMemory* input) {
  std::vector<weir_tensor> out;
  for (size_t i = 0; i < config.info.num_tensors; ++i) {
    if (spec.format == Format::Static) {
      const auto bytes = spec.tensors[i].bytes();
      if (!bytes || !input[i].data || input[i].size != *bytes)
        return Error{.code = Code::FRAME_SIZE,
                     .what = "the size of a tensor does not match the stream",
                     .offered = "tensor " + std::to_string(i) + ": " +
                                std::to_string(input[i].size) + " bytes",
                     .needed = spec.tensors[i].to_string()};
      out.push_back(make_tensor(spec.tensors[i], input[i].data, input[i].size));
      continue;
    }
    auto* bytes = static_cast<std::byte*>(input[i].data);
    const auto header = read_tensor_chunk({bytes, bytes ? input[i].size : 0});
    if (!header) return header.error();
    out.push_back(make_tensor(header->spec, bytes + kTensorHeaderBytes,
                              static_cast<size_t>(header->payload_bytes().value_or(0))));
  }
  return out;
}

void leave(void** priv) {
  if (!priv) return;
  const std::unique_ptr<BuiltinDecoder> owner(
      static_cast<BuiltinDecoder*>(std::exchange(*priv, nullptr)));
}

int set_option(const weir_decoder_type& type, void** priv, int number, const char* value) {
  if (!given("setOption", {value}) || number < 0 || number >= kOptions) return FALSE;
  return or_else("setOption", FALSE, [&]() -> int {
    const CalledDecoder decoder("setOption", type, priv);
    if (!decoder) return FALSE;
    decoder->set_option(static_cast<size_t>(number), value);
    return TRUE;
  });
}

GstCaps* output_caps(const weir_decoder_type& type, void** priv, const GstTensorsConfig* config) {
  if (!given("getOutCaps", {config})) return nullptr;
  if (!can_be("getOutCaps", config->info)) return nullptr;
  return or_else<GstCaps*>("getOutCaps", nullptr, [&]() -> GstCaps* {
    const CalledDecoder decoder("getOutCaps", type, priv);
    if (!decoder) return nullptr;
    auto caps = decoder->configure(to_spec(*config));
    if (caps) return caps->release();
    warn("getOutCaps", caps.error());
    return nullptr;
  });
}

GstFlowReturn decode(const weir_decoder_type& type, void** priv, const GstTensorsConfig* config,
                     const GstTensorMemory* input, GstBuffer* outbuf) {
  if (!given("decode", {config, input, outbuf})) return GST_FLOW_ERROR;
  if (!can_be("decode", config->info)) return GST_FLOW_ERROR;
  return or_else("decode", GST_FLOW_ERROR, [&] {
    const CalledDecoder decoder("decode", type, priv);
    if (!decoder) return GST_FLOW_ERROR;
    const auto spec = to_spec(*config);
    auto tensors = make_tensors(spec, *config, input);
    gst_buffer_remove_all_memory(outbuf);
    const auto kept = tensors ? decoder->decode(spec, *std::move(tensors), outbuf)
                              : Result<bool>(tensors.error());
    if (kept) return *kept ? GST_FLOW_OK : GST_FLOW_CUSTOM_SUCCESS;
    warn("decode", kept.error());
    return GST_FLOW_ERROR;
  });
}

Slots<GstTensorDecoderDef, weir_decoder_type>& decoder_slots();

template <size_t Number>
struct DecoderFunctions {
  static GstTensorDecoderDef descriptor() {
    GstTensorDecoderDef decoder{};
    decoder.init = [](void** priv) -> int {
      if (!given("init", {priv})) return FALSE;
      return or_else("init", FALSE, [&] {
        const auto& type = decoder_slots().type(Number);
        *priv = is_stateless(type) ? nullptr : new BuiltinDecoder(type);
        return TRUE;
      });
    };
    decoder.exit = leave;
    decoder.setOption = [](void** priv, int number, const char* value) {
      return set_option(decoder_slots().type(Number), priv, number, value);
    };
    decoder.getOutCaps = [](void** priv, const GstTensorsConfig* config) {
      return output_caps(decoder_slots().type(Number), priv, config);
    };
    decoder.decode = [](void** priv, const GstTensorsConfig* config, const GstTensorMemory* input,
                        GstBuffer* outbuf) {
      return decode(decoder_slots().type(Number), priv, config, input, outbuf);
    };
    decoder.getTransformSize = [](void**, const GstTensorsConfig*, GstCaps*, size_t, GstCaps*,
                                  GstPadDirection) -> size_t { return 0; };
    return decoder;
  }
};

Slots<GstTensorDecoderDef, weir_decoder_type>& decoder_slots() {
  using All = Slots<GstTensorDecoderDef, weir_decoder_type>;
  const auto make = []<size_t Number>() { return DecoderFunctions<Number>::descriptor(); };
  static auto& all = *new All(slot_table(make, std::make_index_sequence<All::kMax>()));
  return all;
}

}  // namespace

Result<const GstTensorDecoderDef*> builtin_decoder(const char* name) {
  const auto type = infer::ModuleLibrary::instance().decoder(name);
  if (!type) return type.error();
  return decoder_slots().of(**type, [&](GstTensorDecoderDef& decoder, size_t) {
    decoder.modename = const_cast<char*>((*type)->name);
  });
}

}  // namespace weir::compat
