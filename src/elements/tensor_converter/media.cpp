// Finds the Medium for caps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/media.hpp"

#include <array>
#include <cstring>

#include "core/infer/module/custom_converter.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/subplugin/loader.hpp"
#include "elements/tensor_converter/audio_medium.hpp"
#include "elements/tensor_converter/converted_medium.hpp"
#include "elements/tensor_converter/flexible_medium.hpp"
#include "elements/tensor_converter/octet_medium.hpp"
#include "elements/tensor_converter/sub_plugin_medium.hpp"
#include "elements/tensor_converter/text_medium.hpp"
#include "elements/tensor_converter/video_medium.hpp"
#include "gstcpp/buffer/caps_text.hpp"
#include "gstcpp/buffer/device_caps.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/log.hpp"
#include "weir/join.hpp"

namespace weir {
namespace {

struct Entry {
  const char* name;  // of the caps structure
  const char* caps;
  std::unique_ptr<Medium> (*make)();
};

template <class M>
std::unique_ptr<Medium> make() {
  return std::make_unique<M>();
}

constexpr std::array kMedia{
    Entry{"video/x-raw",
          "video/x-raw, format=(string){ RGB, BGR, RGBx, BGRx, xRGB, xBGR, RGBA, BGRA, ARGB, "
          "ABGR, GRAY8, GRAY16_BE, GRAY16_LE, RGBP, BGRP }, width=(int)[ 1, 2147483647 ], "
          "height=(int)[ 1, 2147483647 ], " WEIR_CAPS_RATE ", interlace-mode=(string)progressive",
          make<VideoMedium>},
    Entry{"audio/x-raw",
          "audio/x-raw, format=(string){ S8, U8, S16LE, S16BE, U16LE, U16BE, S32LE, S32BE, U32LE, "
          "U32BE, F32LE, F32BE, F64LE, F64BE }, rate=(int)[ 1, 2147483647 ], "
          "channels=(int)[ 1, 2147483647 ], layout=(string)interleaved",
          make<AudioMedium>},
    Entry{"text/x-raw", "text/x-raw, format=(string)utf8", make<TextMedium>},
    Entry{"application/octet-stream", "application/octet-stream", make<OctetMedium>},
    Entry{"other/tensors", WEIR_CAPS_TENSORS("flexible"), make<FlexibleMedium>},
};

gst::Ref<GstCaps> caps_of(const weir_converter_type& type) {
  auto caps = gst::caps_from_text(type.caps ? type.caps : "");
  return caps ? *std::move(caps) : gst::Ref<GstCaps>();
}

bool takes(const weir_converter_type& type, const char* name) {
  if (std::strcmp(type.name, name) == 0) return true;
  const auto caps = caps_of(type);
  for (guint i = 0; caps && i < gst_caps_get_size(caps.get()); ++i)
    if (gst_structure_has_name(gst_caps_get_structure(caps.get(), i), name)) return true;
  return false;
}

Result<std::unique_ptr<Medium>> external(const weir_converter_type& type,
                                         const infer::Converter::Options& options) {
  auto converter = infer::Converter::open(type, options);
  if (!converter) return converter.error();
  return std::unique_ptr<Medium>(std::make_unique<ConvertedMedium>(*std::move(converter)));
}

// The converter "python3" runs scripts.
Result<std::unique_ptr<Medium>> scripted(const std::string& path) {
  const auto type = infer::ModuleLibrary::instance().converter("python3");
  if (type) return external(**type, {{"script", path}});
  if (type.error().code != Code::CONVERTER_UNKNOWN) return type.error();
  const auto theirs = subplugin::open(subplugin::Kind::Converter, "python3");
  if (!theirs) return theirs.error();
  if (!*theirs) return type.error();
  return SubPluginMedium::open(*static_cast<const NNStreamerExternalConverter*>(*theirs), path);
}

// Weir's registry has precedence.
std::unique_ptr<Medium> custom_code(const std::string& name) {
  const auto theirs =
      infer::is_custom_converter(name) ? std::nullopt : subplugin::custom_converters().find(name);
  if (!theirs) return std::make_unique<ConvertedMedium>(infer::custom_converter(name));
  return std::make_unique<SubPluginMedium>(
      name, reinterpret_cast<tensor_converter_custom>(theirs->function), theirs->data,
      theirs->gate);
}

}  // namespace

Result<std::unique_ptr<Medium>> medium_for(const GstCaps* caps, const ConverterMode& mode) {
  if (mode.kind == ConverterMode::Kind::CustomScript) return scripted(mode.name);
  if (mode.kind == ConverterMode::Kind::CustomCode) return custom_code(mode.name);
  if (const auto status = gst::check_memory(caps, "tensor_converter"); !status)
    return status.error();
  const char* name = gst_structure_get_name(gst_caps_get_structure(caps, 0));
  for (const auto& entry : kMedia)
    if (std::strcmp(entry.name, name) == 0) return entry.make();
  for (const auto* type : infer::ModuleLibrary::instance().converters())
    if (takes(*type, name)) return external(*type, {});
  if (auto theirs = sub_plugin_medium_for(name); !theirs || *theirs) return theirs;
  const gst::UniqueText known{gst_caps_to_string(caps_of_media().get())};
  return Error{.code = Code::FORMAT_UNSUPPORTED,
               .what = "tensor_converter cannot convert this stream",
               .offered = name,
               .needed = known.get(),
               .fix = "tensor_converter mode=custom-code:NAME, with a function of your own"};
}

bool is_custom_code(const std::string& name) {
  return infer::is_custom_converter(name) || subplugin::custom_converters().find(name);
}

std::set<std::string> converter_names() {
  std::set<std::string> out;
  for (auto& name : infer::ModuleLibrary::instance().converter_names()) out.insert(std::move(name));
  for (auto& name : subplugin::available(subplugin::Kind::Converter)) out.insert(std::move(name));
  return out;
}

gst::Ref<GstCaps> caps_of_media() {
  const std::string text = join(kMedia, "; ", [](const Entry& entry) { return entry.caps; });
  auto all = gst::Ref<GstCaps>::adopt(gst_caps_from_string(text.c_str()));
  for (const auto* type : infer::ModuleLibrary::instance().converters()) {
    auto caps = caps_of(*type);
    if (caps && !gst_caps_is_any(caps.get()))
      all = gst::Ref<GstCaps>::adopt(gst_caps_merge(all.release(), caps.release()));
    else
      GST_CAT_WARNING(gst::library_category(),
                      "the converter %s has no caps that can be read: \"%s\"", type->name,
                      type->caps ? type->caps : "");
  }
  subplugin::open_all(subplugin::Kind::Converter);
  return gst::Ref<GstCaps>::adopt(
      gst_caps_merge(all.release(), caps_of_sub_plugin_converters().release()));
}

std::string caps_of_media_for(const TensorSpec& peer, const Fraction& rate) {
  return VideoMedium::caps_for(peer, rate) + AudioMedium::caps_for(peer, rate) +
         "application/octet-stream";
}

}  // namespace weir
