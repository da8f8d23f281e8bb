// Chooses output caps with the peer and answers caps queries.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/output_caps.hpp"

#include "gstcpp/buffer/tensor_caps.hpp"

namespace weir {
namespace {

Error refused(GstPad* source, const GstCaps* peer, const FrameSpec& spec) {
  const bool flexible = spec.format == Format::Flexible;
  return gst::downstream_mismatch(
      source, peer,
      flexible ? "format=flexible: the model decides with each frame, or invoke-dynamic=true"
               : spec.to_string(),
      gst::caps_to_paste(spec));
}

gst::Ref<GstCaps> offered_caps(GstPad* pad, const OpenModel* model, GstCaps* filter) {
  using Caps = gst::Ref<GstCaps>;
  const bool is_sink = GST_PAD_IS_SINK(pad);
  auto caps = Caps::adopt(gst_pad_get_pad_template_caps(pad));
  if (model) {
    const auto spec =
        is_sink ? model->description().sink_spec() : model->description().source_spec();
    if (spec.format == Format::Flexible || !spec.tensors.empty())
      caps = gst::possible_caps(pad, spec, filter);
  }
  if (!filter) return caps;
  const auto narrowed = [filter](GstCaps* wide) {
    return Caps::adopt(gst_caps_intersect_full(filter, wide, GST_CAPS_INTERSECT_FIRST));
  };
  caps = narrowed(caps.get());
  // Caps that do not fit the model are rejected in the caps event, where an error can explain it.
  if (is_sink && gst_caps_is_empty(caps.get()))
    caps = narrowed(Caps::adopt(gst_pad_get_pad_template_caps(pad)).get());
  return caps;
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

bool answer_caps_query(GstPad* pad, const OpenModel* model, GstQuery* query) {
  GstCaps* caps = nullptr;
  if (GST_QUERY_TYPE(query) == GST_QUERY_CAPS) {
    gst_query_parse_caps(query, &caps);
    gst_query_set_caps_result(query, offered_caps(pad, model, caps).get());
    return true;
  }
  if (GST_QUERY_TYPE(query) != GST_QUERY_ACCEPT_CAPS || !GST_PAD_IS_SINK(pad)) return false;
  gst_query_parse_accept_caps(query, &caps);
  const auto ours = gst::Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(pad));
  // Wrong sizes are rejected in the caps event, where an error can name the needed ones.
  gst_query_set_accept_caps_result(query, gst_caps_can_intersect(caps, ours.get()));
  return true;
}

}  // namespace weir
