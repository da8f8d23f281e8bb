// Asking the peer.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/output_caps.hpp"

#include "gstcpp/tensor_caps.hpp"

namespace weir {
namespace {

Error refused(GstPad* source, const GstCaps* peer, const FrameSpec& spec) {
  const bool flexible = spec.format == Format::Flexible;
  return gst::refused_behind(
      source, peer,
      flexible ? "format=flexible: the model decides with each frame, or invoke-dynamic=true"
               : spec.to_string(),
      gst::caps_to_paste(spec));
}

}  // namespace

Result<gst::Ref<GstCaps>> choose_output_caps(GstPad* source, const FrameSpec& spec) {
  const auto peer = gst::Ref<GstCaps>::adopt(gst_pad_peer_query_caps(source, nullptr));
  const auto possible = gst::possible_caps(source, spec, peer.get());
  auto meet = gst::Ref<GstCaps>::adopt(
      gst_caps_intersect_full(possible.get(), peer.get(), GST_CAPS_INTERSECT_FIRST));
  if (gst_caps_is_empty(meet.get())) return refused(source, peer.get(), spec);
  return gst::Ref<GstCaps>::adopt(gst_caps_fixate(gst_caps_truncate(meet.release())));
}

gst::Ref<GstCaps> offered_caps(GstPad* pad, const OpenedModel* model, GstCaps* filter) {
  using Caps = gst::Ref<GstCaps>;
  const bool is_sink = GST_PAD_IS_SINK(pad);
  auto caps = Caps::adopt(gst_pad_get_pad_template_caps(pad));
  FrameSpec spec;
  const bool dynamic = model && !is_sink && model->is_dynamic();
  spec.format = dynamic ? Format::Flexible : Format::Static;
  if (model && is_sink && !model->combines_inputs())
    spec.tensors = known_parts(model->inputs());
  else if (model && !is_sink)
    spec.tensors = model->known_outputs();
  if (dynamic || !spec.tensors.empty()) caps = gst::possible_caps(pad, spec, filter);
  if (!filter) return caps;
  const auto narrowed = [filter](GstCaps* wide) {
    return Caps::adopt(gst_caps_intersect_full(filter, wide, GST_CAPS_INTERSECT_FIRST));
  };
  caps = narrowed(caps.get());
  // What does not fit the model is refused when caps come, where the message can say what would.
  if (is_sink && gst_caps_is_empty(caps.get()))
    caps = narrowed(Caps::adopt(gst_pad_get_pad_template_caps(pad)).get());
  return caps;
}

}  // namespace weir
