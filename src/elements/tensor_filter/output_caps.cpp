// Asking the peer.
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

}  // namespace weir
