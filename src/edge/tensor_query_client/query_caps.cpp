// Compares caps as NNStreamer's query client does: without frame rates.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/tensor_query_client/query_caps.hpp"

#include <string>

#include "core/wire/peer_error.hpp"
#include "gstcpp/buffer/caps_text.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"

namespace weir {
namespace {

using gst::Ref;

constexpr char kRate[] = "framerate";

std::string text_of(const GstCaps* caps) {
  const gst::UniqueText text{gst_caps_to_string(caps)};
  return text.get();
}

Ref<GstCaps> without_rate(const GstCaps* caps) {
  auto out = Ref<GstCaps>::adopt(gst_caps_copy(caps));
  for (guint i = 0; i < gst_caps_get_size(out.get()); ++i)
    gst_structure_remove_field(gst_caps_get_structure(out.get(), i), kRate);
  return out;
}

// The same static tensors may be written in several ways: as other/tensor and other/tensors, and
// with more or fewer trailing 1s in their dimensions.
bool are_same_tensors(const GstCaps* a, const GstCaps* b) {
  const auto left = gst::spec_from_caps(a), right = gst::spec_from_caps(b);
  return left && right && left->format == Format::Static && left->info_valid() &&
         right->format == Format::Static && right->info_valid() &&
         first_difference(left->tensors, right->tensors).empty();
}

Result<Ref<GstCaps>> parse(const std::string& text, const char* which) {
  const std::string what = std::string("the query server announces invalid caps for ") + which;
  auto caps = gst::caps_from_text(text);
  if (!caps) return wire::peer_error(what, caps.error());
  if (!gst_caps_is_empty(caps->get())) return caps;
  return wire::peer_error(what, wire::quoted_text(text), "valid caps");
}

}  // namespace

Result<Ref<GstCaps>> answer_caps(const wire::QueryCapability& capability, const GstCaps* input) {
  const auto taken = parse(capability.source_caps, "its input");
  if (!taken) return taken.error();
  const auto offered = without_rate(input), needed = without_rate(taken->get());
  if (!gst_caps_can_intersect(offered.get(), needed.get()) &&
      !are_same_tensors(offered.get(), needed.get()))
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the query server does not accept this stream",
                 .offered = text_of(input),
                 .needed = text_of(taken->get()),
                 .fix = "convert the stream upstream of tensor_query_client"};
  auto out = parse(capability.sink_caps, "its answers");
  if (!out) return out;
  if (gst_caps_is_fixed(out->get())) return out;
  *out = Ref<GstCaps>::adopt(gst_caps_make_writable(out->release()));
  const GValue* rate = gst_structure_get_value(gst_caps_get_structure(input, 0), kRate);
  GstStructure* const answer = gst_caps_get_structure(out->get(), 0);
  if (rate && gst_structure_has_field(answer, kRate)) gst_structure_set_value(answer, kRate, rate);
  if (gst_caps_is_fixed(out->get())) return out;
  return wire::peer_error("the query server announces several caps for its answers",
                          wire::quoted_text(capability.sink_caps), "one: fixed caps",
                          "put a capsfilter upstream of its tensor_query_serversink");
}

}  // namespace weir
