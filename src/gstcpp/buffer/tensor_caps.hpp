// Converts FrameSpec to GstCaps and back, and chooses caps (docs/compatibility/types-and-caps.md
// 1.5).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>

#include "core/tensor/frame_spec.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::gst {

#define WEIR_CAPS_RATE "framerate=(fraction)[ 0/1, 2147483647/1 ]"
#define WEIR_CAPS_TENSOR "other/tensor, " WEIR_CAPS_RATE
#define WEIR_CAPS_TENSORS(formats) "other/tensors, format=(string)" formats ", " WEIR_CAPS_RATE

// Reads the first structure. As docs/compatibility/types-and-caps.md 1.5 requires, a missing or
// unknown field is not an error and leaves its part unknown (format End, empty tensors, rate
// -1/-1). A list that cannot be parsed, or too many tensors, is an error.
Result<FrameSpec> spec_from_caps(const GstCaps* caps);
// The same for fixed caps with a valid spec; anything else is an error.
Result<FrameSpec> fixed_spec_from_caps(const GstCaps* caps);

// What the tensors are, by the fields of weir/results.h; empty for streams without results. The
// functions above leave it out of the spec: only elements that pass tensors on as they are keep it.
ResultRoles roles_from_caps(const GstCaps* caps);
// The caps with these fields, or without them if there are no roles. `caps` must be writable.
Ref<GstCaps> with_roles(Ref<GstCaps> caps, const ResultRoles& roles);

// All caps for this spec that intersect the pad's template, in order: other/tensor (static, at most
// one tensor), other/tensors static, other/tensors flexible. Unknown parts stay open: an invalid
// rate, a tensor without type or shape. If `peer` (may be null) spells equal dimensions or types
// differently, its spelling is used.
Ref<GstCaps> possible_caps(GstPad* pad, const FrameSpec& spec, const GstCaps* peer);

// Removes the dimensions: as the filter of a caps query, the result lets a peer answer with equal
// dimensions that have more or fewer trailing 1s.
Ref<GstCaps> without_dimensions(Ref<GstCaps> caps);

// What the peer of a source pad accepts, of one caps query, which walks the rest of the pipeline:
// asked once per negotiation.
struct PeerCaps {
  explicit PeerCaps(GstPad* source_pad);

  Ref<GstCaps> caps;
  bool takes_single = false;  // accepts other/tensor
  bool flexible = false;      // prefers flexible tensors: they are first
};

// Rule A of docs/compatibility/types-and-caps.md 1.5: the caps that an element which sends its own
// caps event sets on its source pad. Null when peer and pad template have none in common.
// `may_add_headers`: static frames can be sent as flexible ones to a peer that prefers those.
Ref<GstCaps> choose_caps(GstPad* source_pad, const PeerCaps& peer, const FrameSpec& spec,
                         bool may_add_headers = true);
// Pushes `caps`, made for `spec`. SPEC_MISMATCH with both sides when downstream does not accept
// them and no downstream element posts its own error; `caps` may be null.
Status send_caps(GstPad* source_pad, const FrameSpec& spec, GstCaps* caps);
// Whether nothing is linked, or the downstream element accepts `caps`: one of its structures, or
// the whole if it is fixed. False for null.
bool downstream_accepts(GstPad* source_pad, const PeerCaps& peer, GstCaps* caps);
// The same as an error, SPEC_MISMATCH with both sides. An empty `fix` becomes the caps themselves.
Status check_downstream(GstPad* source_pad, GstCaps* caps, std::string fix);
// The same for the caps that choose_caps() returns for `spec`.
Status check_downstream(GstPad* source_pad, const FrameSpec& spec, std::string fix);
// The spec as caps for a pipeline description; lists are quoted.
std::string caps_to_paste(const FrameSpec& spec);
// SPEC_MISMATCH: the downstream element accepts only `peer` and not the result `offered`.
Error downstream_mismatch(GstPad* source_pad, const GstCaps* peer, std::string offered,
                          std::string fix);
// The same; `name`, of the element or pad, is part of the message.
Error downstream_mismatch(const std::string& name, const GstCaps* peer, std::string offered,
                          std::string fix);

}  // namespace weir::gst
