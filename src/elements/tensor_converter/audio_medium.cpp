// Converts raw audio to tensors (docs/compatibility/converter.md 2.3).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/audio_medium.hpp"

#include <cstring>

#include "core/convert/audio_tensor.hpp"
#include "gstcpp/element/log.hpp"

namespace weir {
namespace {

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
  const std::string format = audio_format_of(peer[0].type);
  return Error{.code = Code::SPEC_MISMATCH,
               .what = "the downstream element needs " + count + " consecutive samples",
               .offered = audio.to_string(),
               .needed = peer[0].to_string(),
               .fix = std::string("audioconvert ! audioresample ! audio/x-raw,") +
                      (format.empty() ? "" : "format=" + format + ",") +
                      "channels=1 ! tensor_converter frames-per-tensor=" + count +
                      " ! tensor_transform mode=transpose option=1:0:2:3"};
}

}  // namespace

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
  const std::string format = audio_format_of(peer.type);
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

}  // namespace weir
