// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/negotiation.hpp"

#include <algorithm>

#include "core/convert/converter_mode.hpp"
#include "elements/tensor_converter/media.hpp"
#include "elements/tensor_converter/sub_plugin_medium.hpp"
#include "gstcpp/buffer/device_caps.hpp"

namespace weir {
namespace {

using gst::Ref;

// The static tensors whose dimensions, and possibly types, the peer fixes; without tensors if it
// does not fix them.
FrameSpec fixed_by_peer(const gst::PeerCaps& peer) {
  const auto spec = gst::spec_from_caps(peer.caps.get());  // an error for ANY and EMPTY
  if (!spec || spec->format != Format::Static || spec->tensors.empty()) return {};
  const auto shape_is_known = [](const TensorSpec& tensor) { return tensor.shape.valid(); };
  return std::all_of(spec->tensors.begin(), spec->tensors.end(), shape_is_known) ? *spec
                                                                                 : FrameSpec{};
}

// All media that reach the element, in any format and memory.
Ref<GstCaps> media_in_any_format(bool any_media) {
  if (any_media) return Ref<GstCaps>::adopt(gst_caps_new_any());
  return Ref<GstCaps>::adopt(
      gst_caps_merge(gst_caps_from_string("video/x-raw; audio/x-raw; text/x-raw; other/tensors"),
                     gst::video_of_devices().release()));
}

// `all` with the structures of `best` in place of those of the same media in system memory.
Ref<GstCaps> narrowed(const GstCaps* all, Ref<GstCaps> best) {
  const auto is_in_best = [&best](const char* name) {
    for (guint i = 0; i < gst_caps_get_size(best.get()); ++i)
      if (gst_structure_has_name(gst_caps_get_structure(best.get(), i), name)) return true;
    return false;
  };
  auto others = Ref<GstCaps>::adopt(gst_caps_new_empty());
  for (guint i = 0; i < gst_caps_get_size(all); ++i) {
    const GstStructure* structure = gst_caps_get_structure(all, i);
    const GstCapsFeatures* memory = gst_caps_get_features(all, i);
    if (is_in_best(gst_structure_get_name(structure)) &&
        gst_caps_features_is_equal(memory, GST_CAPS_FEATURES_MEMORY_SYSTEM_MEMORY))
      continue;
    gst_caps_append_structure_full(others.get(), gst_structure_copy(structure),
                                   gst_caps_features_copy(memory));
  }
  return Ref<GstCaps>::adopt(gst_caps_merge(best.release(), others.release()));
}

// The part of `caps` that fits the filter, in its order.
Ref<GstCaps> fitting(const GstCaps* caps, const GstCaps* filter) {
  return Ref<GstCaps>::adopt(gst_caps_intersect_full(
      const_cast<GstCaps*>(filter), const_cast<GstCaps*>(caps), GST_CAPS_INTERSECT_FIRST));
}

}  // namespace

Result<Preferences> read_preferences(const ConverterSettings& settings) {
  auto shapes = parse_shape_list(settings.input_dim);
  if (!shapes) return shapes.error();
  auto types = parse_type_list(settings.input_type);
  if (!types) return types.error();
  if (!shapes->empty() && !types->empty() && shapes->size() != types->size())
    return Error{.code = Code::OPTION_VALUE,
                 .what = "input-dim and input-type differ in number",
                 .offered = settings.input_dim + " and " + settings.input_type,
                 .needed = "as many types as dimensions"};
  Preferences out;
  for (size_t i = 0; i < std::min(shapes->size(), types->size()); ++i)
    out.tensors.push_back({(*types)[i], (*shapes)[i], ""});
  out.shapes = *std::move(shapes);
  out.frames_per_tensor = settings.frames_per_tensor;
  return out;
}

Result<Preferences> read_preferences(const ConverterSettings& settings, const gst::PeerCaps& peer) {
  auto out = read_preferences(settings);
  if (!out) return out;
  if (const FrameSpec fixed = fixed_by_peer(peer); fixed.info_valid()) out->peer = fixed.tensors;
  out->peer_is_flexible = peer.flexible;
  return out;
}

Ref<GstCaps> offered_caps(GstPad* sink, GstPad* source, const GstCaps* filter, bool any_media) {
  // Converters registered after the class was initialised are not in the template.
  auto all = Ref<GstCaps>::adopt(gst_caps_merge(gst_pad_get_pad_template_caps(sink),
                                                caps_of_sub_plugin_converters().release()));
  const FrameSpec peer = fixed_by_peer(gst::PeerCaps(source));
  if (peer.tensors.size() == 1) {
    auto best = Ref<GstCaps>::adopt(
        gst_caps_from_string(caps_of_media_for(peer.tensors[0], peer.rate).c_str()));
    auto only_best = narrowed(all.get(), Ref<GstCaps>::share(best.get()));
    // A stream that cannot become what the peer needs gets an error that names both.
    if (!filter && gst_pad_is_linked(sink)) return only_best;
    if (auto meet = filter ? fitting(only_best.get(), filter) : Ref<GstCaps>();
        meet && !gst_caps_is_empty(meet.get()))
      return meet;
    all = Ref<GstCaps>::adopt(gst_caps_merge(best.release(), all.release()));
  }
  auto rest = media_in_any_format(any_media);
  if (!filter) {
    // During linking no source fixates from this list, so the formats that get an error can be
    // added.
    if (gst_pad_is_linked(sink)) return all;
    return Ref<GstCaps>::adopt(gst_caps_merge(all.release(), rest.release()));
  }
  auto meet = fitting(all.get(), filter);
  return gst_caps_is_empty(meet.get()) ? fitting(rest.get(), filter) : std::move(meet);
}

Ref<GstCaps> expected_caps(const GstCaps* input, GstPad* source,
                           const ConverterSettings& settings) {
  const auto mode = parse_converter_mode(settings.mode);
  const auto preferences = read_preferences(settings);
  if (!mode || mode->kind != ConverterMode::Kind::ByCaps || !preferences) return {};
  if (!gst_caps_is_fixed(input)) return {};
  const auto medium = medium_for(input, *mode);
  if (!medium) return {};
  auto plan = (*medium)->configure(input, *preferences);
  if (!plan || plan->first_frame_decides || plan->frames_have_rates) return {};
  plan->spec.rate = {-1, -1};  // open
  return gst::possible_caps(source, plan->spec, nullptr);
}

bool is_accepted_by_element(const GstCaps* caps, bool any_media) {
  if (gst_caps_can_intersect(caps, caps_of_sub_plugin_converters().get())) return true;
  return gst_caps_can_intersect(caps, media_in_any_format(any_media).get());
}

}  // namespace weir
