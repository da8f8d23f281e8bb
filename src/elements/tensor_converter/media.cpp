// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/media.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "core/convert/audio_tensor.hpp"
#include "core/infer/module/custom_converter.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/subplugin/loader.hpp"
#include "core/text/text_file.hpp"
#include "elements/tensor_converter/converted_medium.hpp"
#include "elements/tensor_converter/flexible_medium.hpp"
#include "elements/tensor_converter/medium.hpp"
#include "elements/tensor_converter/sub_plugin_medium.hpp"
#include "elements/tensor_converter/video_medium.hpp"
#include "gstcpp/buffer/caps_text.hpp"
#include "gstcpp/buffer/device_caps.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/memory_part.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/log.hpp"
#include "weir/join.hpp"

namespace weir {
namespace {

// Raw interleaved audio as tensors that share the buffer's memory.
class AudioMedium final : public Medium {
 public:
  Result<StreamPlan> configure(const GstCaps* caps, const Preferences& preferences) override;
  Result<MediumFrames> frames(gst::Ref<GstBuffer> buffer, Ledger* ledger) override;
  MediaType type() const noexcept override { return MediaType::Audio; }

  // The audio format whose tensor is `peer`, as caps text; "" if there is none.
  static std::string caps_for(const TensorSpec& peer, const Fraction& rate);

 private:
  StreamPlan plan_;
};

// Bytes as tensors that the user or the peer specifies, or, for flexible tensors, one
// byte tensor per buffer.
class OctetMedium final : public Medium {
 public:
  Result<StreamPlan> configure(const GstCaps* caps, const Preferences& preferences) override;
  Status accepts(const GstBuffer* buffer) const override;
  Result<MediumFrames> frames(gst::Ref<GstBuffer> buffer, Ledger* ledger) override;
  MediaType type() const noexcept override { return MediaType::Octet; }

 private:
  StreamPlan plan_;
};

// UTF-8 text; each buffer is one frame of the size that the user sets.
class TextMedium final : public Medium {
 public:
  Result<StreamPlan> configure(const GstCaps* caps, const Preferences& preferences) override;
  // Pads shorter text with zeros, by a copy; cuts longer text, with one warning.
  Result<MediumFrames> frames(gst::Ref<GstBuffer> buffer, Ledger* ledger) override;
  MediaType type() const noexcept override { return MediaType::Text; }

 private:
  Result<MediumFrames> padded(GstBuffer* buffer, size_t size, Ledger* ledger) const;
  MediumFrames cut(GstBuffer* buffer, size_t size);

  size_t frame_bytes_ = 0;
  bool cut_reported_ = false;
  const BufferLimit* limit_ = nullptr;  // borrowed; set by configure()
};

constexpr char kLine[] = "audioconvert ! audio/x-raw,layout=interleaved ! tensor_converter";

Error caps_unreadable(const GstStructure* s) {
  const gst::UniqueText text{gst_structure_to_string(s)};
  return Error{.code = Code::FORMAT_UNSUPPORTED,
               .what = "the audio caps cannot be read",
               .offered = text.get(),
               .needed = "a format, a rate, channels and the layout interleaved",
               .fix = kLine};
}

// GStreamer has positions for up to 64 channels, and audioconvert fails an assertion for more. More
// are seldom meant.
constexpr int kUsual = 64;

std::optional<Error> many_channels(int channels) {
  if (channels <= kUsual) return std::nullopt;
  const std::string count = std::to_string(channels);
  return Error{
      .code = Code::SPEC_MISMATCH,
      .what =
          "the audio has " + count + " channels, so each tensor has one sample of every channel",
      .offered = "channels=" + count,
      .needed = "at most " + std::to_string(kUsual) +
                " channels; the dimensions of consecutive samples of one channel are 1:" + count,
      .fix = "audio/x-raw,channels=1 ! tensor_converter frames-per-tensor=" + count};
}

// The error for a model of consecutive samples, as 16000, that gets each moment of the audio as a
// tensor.
std::optional<Error> rows_of_samples(const TensorSpec& audio, const std::vector<TensorSpec>& peer) {
  const bool is_row = peer.size() == 1 && peer[0].shape.min_rank() <= 1 &&
                      peer[0].shape[0] > static_cast<uint32_t>(kUsual);
  if (!is_row || peer[0].shape == audio.shape) return std::nullopt;
  const std::string count = std::to_string(peer[0].shape[0]);
  const std::string format = to_audio_format(peer[0].type);
  return Error{.code = Code::SPEC_MISMATCH,
               .what = "the downstream element needs " + count + " consecutive samples",
               .offered = audio.to_string(),
               .needed = peer[0].to_string(),
               .fix = std::string("audioconvert ! audioresample ! audio/x-raw,") +
                      (format.empty() ? "" : "format=" + format + ",") +
                      "channels=1 ! tensor_converter frames-per-tensor=" + count +
                      " ! tensor_transform mode=transpose option=1:0:2:3"};
}

// The bytes of a frame, if those of `frames` of them can be counted.
Result<uint64_t> count_bytes(const FrameSpec& spec, uint32_t frames) {
  const auto bytes = spec.bytes();
  uint64_t gathered = 0;
  if (bytes && !__builtin_mul_overflow(*bytes, frames, &gathered) && gathered <= INT64_MAX)
    return *bytes;
  return Error{
      .code = Code::LIMIT_EXCEEDED, .what = "the tensors are too big", .offered = spec.to_string()};
}

Result<StreamPlan> AudioMedium::configure(const GstCaps* caps, const Preferences& preferences) {
  const GstStructure* s = gst_caps_get_structure(caps, 0);
  const char* format = gst_structure_get_string(s, "format");
  const char* layout = gst_structure_get_string(s, "layout");
  int channels = 0, rate = 0;
  const bool there = gst_structure_get_int(s, "channels", &channels) &&
                     gst_structure_get_int(s, "rate", &rate) && channels > 0 && rate > 0;
  if (!format || !layout || !there) return caps_unreadable(s);
  if (std::strcmp(layout, "interleaved") != 0)
    return Error{.code = Code::FORMAT_UNSUPPORTED,
                 .what = "the channels of this audio are not interleaved",
                 .offered = std::string("layout=") + layout,
                 .needed = "layout=interleaved",
                 .fix = kLine};
  const auto tensor =
      audio_tensor(format, static_cast<uint32_t>(channels), preferences.frames_per_tensor);
  if (!tensor) return tensor.error();
  plan_ = {};
  plan_.spec.format = Format::Static;
  plan_.spec.tensors = {tensor->spec};
  plan_.spec.rate = {rate, 1};
  plan_.frame_bytes = tensor->frame_bytes;
  plan_.frames_out = preferences.frames_per_tensor;
  plan_.warning = many_channels(channels);
  if (auto status = agree(plan_.spec, preferences.tensors, "audio"); !status) return status.error();
  if (const auto error = rows_of_samples(tensor->spec, preferences.peer)) return *error;
  return plan_;
}

Result<MediumFrames> AudioMedium::frames(gst::Ref<GstBuffer> buffer, Ledger*) {
  if (auto status = whole_frames(buffer.get(), plan_, "check the upstream element"); !status)
    return status.error();
  return MediumFrames{std::move(buffer), {}, {}};
}

std::string AudioMedium::caps_for(const TensorSpec& peer, const Fraction& rate) {
  const bool any_format = peer.type == ElementType::End;
  const std::string format = to_audio_format(peer.type);
  if (format.empty() && !any_format) {
    if (peer.type == ElementType::Float16)
      GST_CAT_WARNING(gst::library_category(),
                      "the downstream element needs float16, which no audio format has");
    return "";
  }
  if (peer.shape[0] > static_cast<uint32_t>(kUsual) || peer.shape.min_rank() > 2) return "";
  const bool rate_known = rate.valid() && rate.numerator > 0 && rate.denominator == 1;
  return "audio/x-raw, " + (any_format ? "" : "format=(string)" + format + ", ") +
         "layout=(string)interleaved, channels=(int)" + std::to_string(peer.shape[0]) +
         ", rate=(int)" + (rate_known ? std::to_string(rate.numerator) : "[ 1, 2147483647 ]") +
         "; ";
}

Result<StreamPlan> OctetMedium::configure(const GstCaps* caps, const Preferences& preferences) {
  plan_ = {};
  plan_.spec.rate = get_rate(caps);
  plan_.spec.tensors = preferences.tensors.empty() ? preferences.peer : preferences.tensors;
  const size_t count = plan_.spec.tensors.size();
  if (count == 0 && !preferences.peer_is_flexible)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "the tensors in the byte stream are unknown",
                 .needed = "input-dim and input-type",
                 .fix = "tensor_converter input-dim=3:224:224:1 input-type=uint8"};
  if (count != 1 || preferences.peer_is_flexible) {
    const char* what = count > 1    ? "several tensors"
                       : count == 0 ? "buffers of any size"
                                    : "bytes for flexible tensors";
    if (auto status = one_frame_each(preferences, what); !status) return status.error();
  }
  plan_.spec.format = count == 0 ? Format::Flexible : Format::Static;
  if (count == 0) return plan_;
  const auto bytes = count_bytes(plan_.spec, preferences.frames_per_tensor);
  if (!bytes) return bytes.error();
  plan_.frame_bytes = *bytes;
  plan_.frames_out = preferences.frames_per_tensor;
  return plan_;
}

Status OctetMedium::accepts(const GstBuffer* buffer) const {
  if (plan_.spec.format != Format::Static) return ok();
  return whole_frames(buffer, plan_,
                      "set blocksize=" + std::to_string(plan_.frame_bytes) + " on the source");
}

Result<MediumFrames> OctetMedium::frames(gst::Ref<GstBuffer> buffer, Ledger*) {
  const size_t size = gst_buffer_get_size(buffer.get());
  if (auto status = accepts(buffer.get()); !status) return status.error();
  if (plan_.spec.format == Format::Static) return MediumFrames{std::move(buffer), {}, {}};
  if (size > UINT32_MAX)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "a buffer is too big for a dimension",
                 .offered = std::to_string(size),
                 .needed = "at most " + std::to_string(UINT32_MAX) + " bytes",
                 .fix = "set blocksize on the source"};
  return MediumFrames{
      std::move(buffer), {{ElementType::UInt8, Shape{static_cast<uint32_t>(size)}, ""}}, {}};
}

Result<StreamPlan> TextMedium::configure(const GstCaps* caps, const Preferences& preferences) {
  const char* format = gst_structure_get_string(gst_caps_get_structure(caps, 0), "format");
  if (!format || std::strcmp(format, "utf8") != 0)
    return Error{.code = Code::FORMAT_UNSUPPORTED,
                 .what = "this text format cannot be a tensor",
                 .offered = format ? std::string("format=") + format : "no format",
                 .needed = "format=utf8",
                 .fix = "text/x-raw,format=utf8 ! tensor_converter input-dim=300"};
  if (preferences.shapes.size() != 1)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "the size of a text is unknown",
                 .offered = std::to_string(preferences.shapes.size()) + " dimensions in input-dim",
                 .needed = "one: the bytes of each text",
                 .fix = "tensor_converter input-dim=300"};
  const uint32_t size = preferences.shapes[0][0];
  StreamPlan plan;
  plan.spec.format = Format::Static;
  plan.spec.tensors = {{ElementType::UInt8, Shape{size, preferences.frames_per_tensor}, ""}};
  plan.spec.rate = get_rate(caps);
  plan.frame_bytes = frame_bytes_ = size;
  plan.frames_out = preferences.frames_per_tensor;
  cut_reported_ = false;
  limit_ = preferences.limit;
  if (auto status = agree(plan.spec, preferences.tensors, "text"); !status) return status.error();
  return plan;
}

Result<MediumFrames> TextMedium::frames(gst::Ref<GstBuffer> buffer, Ledger* ledger) {
  const size_t size = gst_buffer_get_size(buffer.get());
  if (size < frame_bytes_) return padded(buffer.get(), size, ledger);
  if (size > frame_bytes_) return cut(buffer.get(), size);
  return MediumFrames{std::move(buffer), {}, {}};
}

Result<MediumFrames> TextMedium::padded(GstBuffer* buffer, size_t size, Ledger* ledger) const {
  if (auto status = limit_->check(frame_bytes_); !status) return status.error();
  auto allocated = gst::allocate_buffer(frame_bytes_);
  if (!allocated) return allocated.error();
  auto out = *std::move(allocated);
  gst_buffer_copy_into(out.get(), buffer, GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
  {
    const gst::Mapped to(out.get(), GST_MAP_WRITE);
    if (!to || gst_buffer_extract(buffer, 0, to.bytes().data(), size) != size)
      return gst::memory_not_mapped();
    std::ranges::fill(to.bytes().subspan(size), std::byte{0});
  }
  ledger->copied(size);
  return MediumFrames{std::move(out), {}, {}};
}

MediumFrames TextMedium::cut(GstBuffer* buffer, size_t size) {
  constexpr auto kParts = GstBufferCopyFlags(GST_BUFFER_COPY_METADATA | GST_BUFFER_COPY_MEMORY);
  MediumFrames out;
  out.buffer = gst::Ref<GstBuffer>::adopt(gst_buffer_copy_region(buffer, kParts, 0, frame_bytes_));
  // A region of a buffer loses the duration; the text has the duration of the whole.
  GST_BUFFER_DURATION(out.buffer.get()) = GST_BUFFER_DURATION(buffer);
  if (!std::exchange(cut_reported_, true))
    out.warning = Error{.code = Code::FRAME_SIZE,
                        .what =
                            "a text is longer than input-dim and is truncated; later ones are "
                            "truncated without a warning",
                        .offered = std::to_string(size) + " bytes",
                        .needed = std::to_string(frame_bytes_) + " bytes",
                        .fix = "tensor_converter input-dim=" + std::to_string(size)};
  return out;
}

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

gst::Ref<GstCaps> make_caps(const weir_converter_type& type) {
  auto caps = gst::caps_from_text(type.caps ? type.caps : "");
  return caps ? *std::move(caps) : gst::Ref<GstCaps>();
}

bool takes(const weir_converter_type& type, const char* name) {
  if (std::strcmp(type.name, name) == 0) return true;
  const auto caps = make_caps(type);
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

Status check_script(const std::string& path) {
  if (!infer::ModuleLibrary::instance().converter("python3")) return ok();
  std::string reason = why_unreadable(path);
  if (reason.empty()) return ok();
  return Error{.code = Code::FILE_NOT_FOUND,
               .what = "the script of the mode cannot be read: " + std::move(reason),
               .offered = path,
               .needed = "a Python file with the class CustomConverter",
               .fix = "tensor_converter mode=custom-script:/path/to/script.py"};
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
    auto caps = make_caps(*type);
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
