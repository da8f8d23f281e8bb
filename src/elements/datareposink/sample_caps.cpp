// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/datareposink/sample_caps.hpp"

#include <gst/video/video.h>

#include <optional>
#include <string>
#include <string_view>

#include "core/text/text.hpp"
#include "gstcpp/buffer/caps_text.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"

namespace weir {
namespace {

using Medium = SampleCaps::Medium;

std::optional<Medium> medium_of(std::string_view name) {
  if (name == "other/tensors" || name == "other/tensor") return Medium::StaticTensors;
  if (name == "video/x-raw") return Medium::Video;
  if (name == "audio/x-raw") return Medium::Audio;
  if (name.starts_with("image/")) return Medium::Image;
  if (name == "text/x-raw" || name == "application/octet-stream") return Medium::Bytes;
  return std::nullopt;
}

Error unusable(const GstCaps* caps, std::string what, std::string needed) {
  return Error{.code = Code::FORMAT_UNSUPPORTED,
               .what = "the caps do not describe samples: " + std::move(what),
               .offered = gst::to_string(caps),
               .needed = std::move(needed),
               .fix =
                   "other/tensors,format=static,num_tensors=1,dimensions=(string)3:224:224:1,"
                   "types=(string)uint8,framerate=30/1"};
}

Status read_tensors(GstCaps* caps, SampleCaps* out) {
  auto spec = gst::spec_from_caps(caps);
  if (!spec) return spec.error();
  if (!spec->info_valid())
    return unusable(caps, "the tensors are not complete",
                    "format, and for static tensors num_tensors, dimensions and types");
  out->tensors = *std::move(spec);
  if (out->tensors.format != Format::Static) {
    out->medium = Medium::HeaderedTensors;
    return ok();
  }
  const auto bytes = out->tensors.bytes();
  if (!bytes) return unusable(caps, "the tensors are too large", "less than 2^63 bytes");
  out->bytes = *bytes;
  return ok();
}

Status read_video(GstCaps* caps, SampleCaps* out) {
  GstVideoInfo info;
  if (!gst_video_info_from_caps(&info, caps) || GST_VIDEO_INFO_SIZE(&info) == 0)
    return unusable(caps, "the picture is not complete", "format, width and height");
  out->bytes = GST_VIDEO_INFO_SIZE(&info);
  return ok();
}

// Returns the bytes of one sample of one channel: 2 of "S16LE", 3 of "S20LE", 4 of "S24_32LE".
uint64_t bytes_of_format(std::string_view format) {
  const size_t stored = format.find('_');
  const auto digits = format.substr(stored == std::string_view::npos ? 1 : stored + 1);
  const auto bits = parse_unsigned(digits.substr(0, digits.find_first_not_of("0123456789")));
  return bits && *bits <= 64 ? (*bits + 7) / 8 : 0;
}

Status read_audio(GstCaps* caps, SampleCaps* out) {
  const GstStructure* fields = gst_caps_get_structure(caps, 0);
  const char* format = gst_structure_get_string(fields, "format");
  int rate = 0, channels = 0;
  gst_structure_get_int(fields, "rate", &rate);
  gst_structure_get_int(fields, "channels", &channels);
  const uint64_t bytes = format && *format ? bytes_of_format(format) : 0;
  if (bytes == 0 || rate <= 0 || channels <= 0)
    return unusable(caps, "the audio is not complete", "format, rate and channels");
  // At most 8 * 2^31 * 2^31 bytes: the product of two int fits, that of three values may not.
  if (__builtin_mul_overflow(bytes * static_cast<uint64_t>(rate), static_cast<uint64_t>(channels),
                             &out->bytes))
    return unusable(caps, "a second of the audio is too large", "less than 2^63 bytes");
  return ok();
}

Status read_size(GstCaps* caps, SampleCaps* out) {
  switch (out->medium) {
    case Medium::StaticTensors:
    case Medium::HeaderedTensors:
      return read_tensors(caps, out);
    case Medium::Video:
      return read_video(caps, out);
    case Medium::Audio:
      return read_audio(caps, out);
    case Medium::Image:
    case Medium::Bytes:
      break;
  }
  return ok();
}

}  // namespace

Result<SampleCaps> read_sample_caps(GstCaps* caps) {
  if (!gst_caps_is_fixed(caps))
    return unusable(caps, "they are not fixed", "one value for each field");
  const GstStructure* fields = gst_caps_get_structure(caps, 0);
  const auto medium = medium_of(gst_structure_get_name(fields));
  if (!medium)
    return unusable(caps, "the medium is unknown",
                    "other/tensors, video/x-raw, audio/x-raw, image/*, text/x-raw or "
                    "application/octet-stream");
  SampleCaps out{.medium = *medium, .caps = gst::Ref<GstCaps>::share(caps)};
  gst_structure_get_fraction(fields, "framerate", &out.rate.numerator, &out.rate.denominator);
  if (auto status = read_size(caps, &out); !status) return status.error();
  return out;
}

}  // namespace weir
