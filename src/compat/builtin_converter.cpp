// A converter descriptor that calls a converter module.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "compat/builtin.hpp"
#include "compat/descriptor_slots.hpp"
#include "compat/guard.hpp"
#include "compat/spec.hpp"
#include "core/infer/module/converter.hpp"
#include "core/infer/module/module_library.hpp"
#include "gstcpp/buffer/caps_text.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/module_values.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::compat {
namespace {

using gst::Ref;
using infer::Converter;

struct OpenConverter {
  std::unique_ptr<Converter> converter;
  std::string script;
};

Fraction get_rate(const GstCaps* caps) {
  Fraction rate{0, 1};
  if (gst_caps_get_size(caps) > 0)
    gst_structure_get_fraction(gst_caps_get_structure(caps, 0), "framerate", &rate.numerator,
                               &rate.denominator);
  return rate;
}

bool takes(const weir_converter_type& type, const GstCaps* caps) {
  const auto own = gst::caps_from_text(type.caps);
  return own && gst_caps_can_intersect(own->get(), caps);
}

// Returns the tensors of each frame; none if unknown before the first frame. A converter that
// cannot open without a script learns them from the script's frames.
Result<std::vector<TensorSpec>> output_tensors(const weir_converter_type& type,
                                               const GstCaps* caps) {
  const auto converter = Converter::open(type, {});
  if (!converter && converter.error().code == Code::OPTION_VALUE && takes(type, caps))
    return std::vector<TensorSpec>{};
  if (!converter) return converter.error();
  const gst::UniqueText text{gst_caps_to_string(caps)};
  return (*converter)->configure(text.get());
}

gboolean output_config(const weir_converter_type& type, const GstCaps* caps,
                       GstTensorsConfig* config) {
  if (!given("get_out_config", {caps, config})) return FALSE;
  gst_tensors_config_init(config);
  return or_else("get_out_config", FALSE, [&]() -> gboolean {
    auto tensors = output_tensors(type, caps);
    if (!tensors) {
      warn("get_out_config", tensors.error());
      return FALSE;
    }
    // Until the first buffer (docs/compatibility/converter.md 2.8).
    if (tensors->empty()) *tensors = {{ElementType::UInt8, Shape{1, 1, 1, 1}, ""}};
    write(FrameSpec{Format::Static, *std::move(tensors), get_rate(caps)}, config);
    return TRUE;
  });
}

Result<Ref<GstBuffer>> converted(Converter& converter, GstBuffer* in, GstTensorsConfig* config) {
  std::vector<gst::MappedMemory> maps;
  std::vector<weir_tensor> inputs;
  for (guint i = 0; i < gst_buffer_n_memory(in); ++i) {
    maps.emplace_back(gst_buffer_peek_memory(in, i), GST_MAP_READ);
    if (!maps.back()) return gst::memory_not_mapped();
    inputs.push_back(gst::byte_tensor(maps.back()));
  }
  weir_frame frame{};
  frame.struct_size = sizeof frame;
  frame.n_tensors = static_cast<uint32_t>(inputs.size());
  frame.tensors = inputs.data();
  frame.pts = gst::abi_time(GST_BUFFER_PTS(in));
  frame.duration = gst::abi_time(GST_BUFFER_DURATION(in));
  frame.deadline = -1;
  auto made = converter.convert(frame);
  if (!made) return made.error();
  if (made->tensors.empty())
    return Error{.code = Code::CALLBACK_FAILED,
                 .what = "the converter returned no tensors for this buffer"};
  auto out = Ref<GstBuffer>::adopt(gst_buffer_new());
  gst_buffer_copy_into(out.get(), in, GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
  const Format format = made->is_flexible ? Format::Flexible : Format::Static;
  FrameSpec spec{format, {}, made->rate.value_or(Fraction{config->rate_n, config->rate_d})};
  for (auto& tensor : made->tensors) {
    spec.tensors.push_back(tensor.spec());
    auto memory = gst::make_memory(tensor, nullptr);
    if (!memory) return memory.error();
    GstTensorInfo info{};
    write(tensor.spec(), &info);
    const bool room = gst_tensor_buffer_append_memory(out.get(), memory->release(), &info);
    gst_tensor_info_free(&info);
    if (!room)
      return Error{.code = Code::LIMIT_EXCEEDED,
                   .what = "the converter returned too many tensors for one buffer",
                   .needed = "at most 256"};
  }
  gst_tensors_config_free(config);
  write(spec, config);
  return out;
}

// Without open(), opens a converter for this buffer only.
GstBuffer* convert(const weir_converter_type& type, GstBuffer* in, GstTensorsConfig* config,
                   void* priv) {
  if (!given("convert", {in, config})) return nullptr;
  return or_else<GstBuffer*>("convert", nullptr, [&]() -> GstBuffer* {
    std::unique_ptr<Converter> own;
    if (!priv) {
      auto opened = Converter::open(type, {});
      if (!opened) {
        warn("convert", opened.error());
        return nullptr;
      }
      own = *std::move(opened);
    }
    auto out = converted(own ? *own : *static_cast<OpenConverter*>(priv)->converter, in, config);
    if (out) return out->release();
    warn("convert", out.error());
    return nullptr;
  });
}

int open(const weir_converter_type& type, const char* script, void** priv) {
  if (!given("open", {script, priv})) return -EINVAL;
  return or_else("open", -EINVAL, [&] {
    if (const auto* before = static_cast<OpenConverter*>(*priv)) {
      if (before->script == script) return 1;
      delete before;
      *priv = nullptr;
    }
    auto opened = Converter::open(type, {{"script", script}});
    if (opened) {
      *priv = new OpenConverter{*std::move(opened), script};
      return 0;
    }
    warn("open", opened.error());
    return -EINVAL;
  });
}

Slots<NNStreamerExternalConverter, weir_converter_type>& converter_slots();

template <size_t Number>
struct ConverterFunctions {
  static NNStreamerExternalConverter descriptor() {
    NNStreamerExternalConverter converter{};
    converter.convert = [](GstBuffer* in, GstTensorsConfig* config, void* priv) {
      return convert(converter_slots().type(Number), in, config, priv);
    };
    converter.get_out_config = [](const GstCaps* caps, GstTensorsConfig* config) {
      return output_config(converter_slots().type(Number), caps, config);
    };
    converter.query_caps = [](const GstTensorsConfig*) {
      auto caps = gst::caps_from_text(converter_slots().type(Number).caps);
      return caps ? caps->release() : nullptr;
    };
    converter.open = [](const char* script, void** priv) {
      return open(converter_slots().type(Number), script, priv);
    };
    converter.close = [](void** priv) {
      if (!priv) return;
      const std::unique_ptr<OpenConverter> closed(
          static_cast<OpenConverter*>(std::exchange(*priv, nullptr)));
    };
    return converter;
  }
};

Slots<NNStreamerExternalConverter, weir_converter_type>& converter_slots() {
  using All = Slots<NNStreamerExternalConverter, weir_converter_type>;
  const auto make = []<size_t Number>() { return ConverterFunctions<Number>::descriptor(); };
  static auto& all = *new All(slot_table(make, std::make_index_sequence<All::kMax>()));
  return all;
}

}  // namespace

Result<const NNStreamerExternalConverter*> builtin_converter(const char* name) {
  const auto type = infer::ModuleLibrary::instance().converter(name);
  if (!type) return type.error();
  return converter_slots().of(**type, [&](NNStreamerExternalConverter& converter, size_t) {
    converter.name = (*type)->name;
  });
}

}  // namespace weir::compat
