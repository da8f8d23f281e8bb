// FrameSpec <-> GstCaps, with the outcomes of the specification, section 1.5.
#pragma once
#include <gst/gst.h>

#include <string>

#include "core/tensor/frame_spec.hpp"
#include "gstcpp/ref.hpp"

namespace weir::gst {

#define WEIR_CAPS_RATE "framerate=(fraction)[ 0/1, 2147483647/1 ]"
#define WEIR_CAPS_TENSOR "other/tensor, " WEIR_CAPS_RATE
#define WEIR_CAPS_TENSORS(formats) "other/tensors, format=(string)" formats ", " WEIR_CAPS_RATE

// Reads the first structure. Lenient as the specification says: a missing or unknown field leaves
// its part unknown (format End, empty tensors, rate -1/-1), it is no error. A list that cannot be
// read, or more tensors than allowed, is.
Result<FrameSpec> spec_from_caps(const GstCaps* caps);
// The same, and the caps must be fixed and the spec valid.
Result<FrameSpec> fixed_spec_from_caps(const GstCaps* caps);

// All caps that carry this spec, each kept only if it meets the pad's template, in order:
// other/tensor (static, at most one tensor), other/tensors static, other/tensors flexible.
// Parts that are unknown are left open: an invalid rate, a tensor without type or shape.
// Where `peer` (may be null) spells an equal dimension in its own way, that spelling is used.
Ref<GstCaps> possible_caps(GstPad* pad, const FrameSpec& spec, const GstCaps* peer);

// The same caps with the dimensions left open: as a filter of a caps query they let a peer answer
// with dimensions that are equal and written with more or fewer 1s at the end.
Ref<GstCaps> without_dimensions(Ref<GstCaps> caps);

// Rule A of section 1.5: the one caps that an element which pushes its own caps event sets on its
// source pad. Null when the peer and the pad's template leave nothing.
Ref<GstCaps> choose_caps(GstPad* source_pad, const FrameSpec& spec);
// Sends `caps` on, which are for `spec`. SPEC_MISMATCH with both sides when the elements behind do
// not take them and none of them posts an error of its own; `caps` may be null.
Status send_caps(GstPad* source_pad, const FrameSpec& spec, GstCaps* caps);
// Caps of the spec as a line for a pipeline, quoted where they are lists.
std::string caps_to_paste(const FrameSpec& spec);
// SPEC_MISMATCH: the element behind that of the pad takes `peer` alone, and not its result, which
// is `offered`.
Error refused_behind(GstPad* source_pad, const GstCaps* peer, std::string offered, std::string fix);
// Whether rule A would choose flexible because the peer wants it.
bool peer_wants_flexible(GstPad* source_pad);

}  // namespace weir::gst
