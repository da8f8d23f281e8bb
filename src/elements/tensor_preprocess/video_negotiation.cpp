// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_preprocess/video_negotiation.hpp"

#include <string>
#include <string_view>

#include "gstcpp/buffer/device_caps.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"

namespace weir {

using gst::Ref;
using preprocess::Request;

namespace {

constexpr int kMaxPixels = 65536;  // per side, as in the pad template

// Fixates the caps; prefers other/tensors.
Ref<GstCaps> first_choice(const GstCaps* caps) {
  guint index = 0;
  while (index < gst_caps_get_size(caps) &&
         !gst_structure_has_name(gst_caps_get_structure(caps, index), "other/tensors"))
    ++index;
  if (index == gst_caps_get_size(caps)) index = 0;
  return Ref<GstCaps>::adopt(gst_caps_fixate(gst_caps_copy_nth(caps, index)));
}

Ref<GstCaps> raw_video() {
  return Ref<GstCaps>::adopt(
      gst_caps_merge(gst_caps_new_empty_simple("video/x-raw"), gst::video_of_devices().release()));
}

}  // namespace

Ref<GstCaps> tensors_for(GstPad* source, const GstStructure* video, const Result<Request>& request,
                         const GstCaps* filter) {
  FrameSpec spec;
  gst_structure_get_fraction(video, "framerate", &spec.rate.numerator, &spec.rate.denominator);
  if (!request) {
    spec.format = Format::Static;
    spec.tensors.resize(1);
    return gst::possible_caps(source, spec, filter);
  }
  spec.format = is_flexible(*request) ? Format::Flexible : Format::Static;
  if (spec.format == Format::Flexible) return gst::possible_caps(source, spec, filter);
  auto out = Ref<GstCaps>::adopt(gst_caps_new_empty());
  for (auto& tensors : preprocess::possible_frames(*request)) {
    spec.tensors = std::move(tensors);
    auto caps = gst::possible_caps(source, spec, filter);
    out = Ref<GstCaps>::adopt(gst_caps_merge(out.release(), caps.release()));
  }
  // possible_caps() also lists flexible caps for static tensors, which are not wanted here.
  const auto fixed =
      Ref<GstCaps>::adopt(gst_caps_from_string(WEIR_CAPS_TENSOR "; " WEIR_CAPS_TENSORS("static")));
  return Ref<GstCaps>::adopt(
      gst_caps_intersect_full(out.get(), fixed.get(), GST_CAPS_INTERSECT_FIRST));
}

Ref<GstCaps> video_for(GstPad* sink, const GstStructure* tensors) {
  auto video = Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(sink));
  const GValue* rate = gst_structure_get_value(tensors, "framerate");
  if (!rate) return video;
  video = Ref<GstCaps>::adopt(gst_caps_make_writable(video.release()));
  gst_caps_set_value(video.get(), "framerate", rate);
  return video;
}

Ref<GstCaps> closed(GstPad* source, Ref<GstCaps> open, const Result<Request>& request) {
  if (gst_caps_is_empty(open.get()) || !request) return open;
  const auto one = first_choice(open.get());
  auto spec = gst::spec_from_caps(one.get());
  if (!spec) return open;
  const auto preparations = preprocess::resolve_frame(*request, spec->tensors);
  if (!preparations) return open;
  spec->tensors = preprocess::make_output_specs(*request, *preparations);
  const auto caps = gst::possible_caps(source, *spec, one.get());
  auto meet = Ref<GstCaps>::adopt(gst_caps_intersect(one.get(), caps.get()));
  return gst_caps_is_empty(meet.get()) ? std::move(open) : std::move(meet);
}

Ref<GstCaps> with_other_formats(GstPad* sink, Ref<GstCaps> known, const GstCaps* filter) {
  if (!filter && gst_pad_is_linked(sink)) return known;
  if (filter && !gst_caps_is_empty(known.get())) return known;
  auto rest = raw_video();
  if (filter)
    return Ref<GstCaps>::adopt(gst_caps_intersect_full(const_cast<GstCaps*>(filter), rest.get(),
                                                       GST_CAPS_INTERSECT_FIRST));
  return Ref<GstCaps>::adopt(gst_caps_merge(known.release(), rest.release()));
}

Error unreadable_video(std::string caps) {
  return Error{.code = Code::FORMAT_UNSUPPORTED,
               .what = "the video caps cannot be read",
               .offered = std::move(caps),
               .needed = "a format, a width and a height",
               .fix = "videoconvert ! tensor_preprocess"};
}

Status check_video(const GstCaps* caps) {
  if (gst_caps_is_any(caps) || gst_caps_is_empty(caps)) return ok();
  if (auto status = gst::check_memory(caps, "tensor_preprocess"); !status) return status;
  const GstStructure* first = gst_caps_get_structure(caps, 0);
  if (!gst_structure_has_name(first, "video/x-raw")) return ok();
  const char* format = gst_structure_get_string(first, "format");
  int width = 0, height = 0;
  const bool sized = gst_structure_get_int(first, "width", &width) &&
                     gst_structure_get_int(first, "height", &height);
  if (!format || !sized)
    return unreadable_video(gst::UniqueText(gst_structure_to_string(first)).get());
  if (const auto known = preprocess::picture_format(format); !known) return known.error();
  if (width < 1 || height < 1 || width > kMaxPixels || height > kMaxPixels)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "a picture is too big or has no pixels",
                 .offered = std::to_string(width) + "x" + std::to_string(height),
                 .needed = "1x1 to 65536x65536",
                 .fix = "put videoscale or videocrop upstream of tensor_preprocess"};
  const char* mode = gst_structure_get_string(first, "interlace-mode");
  if (mode && std::string_view(mode) != "progressive")
    return Error{.code = Code::FORMAT_UNSUPPORTED,
                 .what = "interlaced video is not supported",
                 .offered = mode,
                 .needed = "interlace-mode=progressive",
                 .fix = "deinterlace ! tensor_preprocess"};
  return ok();
}

Error tensor_mismatch(const Result<Request>& request, std::string offered, std::string needed,
                      std::string difference) {
  return Error{.code = Code::SPEC_MISMATCH,
               .what = "the element downstream of tensor_preprocess needs another tensor",
               .offered = std::move(offered),
               .needed = std::move(needed),
               .difference = std::move(difference),
               .fix = request && is_flexible(*request)
                          ? "regions=meta max-regions=16 makes a static tensor"
                          : "leave width, height, type and layout unset: they are taken from the "
                            "downstream caps"};
}

std::optional<Error> downstream_mismatch(GstPad* source, const Result<Request>& request,
                                         const GstCaps* ours) {
  const auto theirs = Ref<GstCaps>::adopt(gst_pad_peer_query_caps(source, nullptr));
  if (gst_caps_can_intersect(ours, theirs.get())) return std::nullopt;
  std::string difference;
  const auto offered = gst::spec_from_caps(ours);
  const auto needed = gst::spec_from_caps(theirs.get());
  if (offered && needed && !offered->tensors.empty() && needed->info_valid())
    difference = first_difference(offered->tensors, needed->tensors);
  return tensor_mismatch(request, gst::UniqueText(gst_caps_to_string(ours)).get(),
                         gst::UniqueText(gst_caps_to_string(theirs.get())).get(), difference);
}

}  // namespace weir
