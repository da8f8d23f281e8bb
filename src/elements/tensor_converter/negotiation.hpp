// How tensor_converter handles caps queries, and the preferences that its peer gives.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "elements/tensor_converter/converter_settings.hpp"
#include "elements/tensor_converter/medium.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"

namespace weir {

// DIMENSION_SYNTAX, TYPE_SYNTAX, or OPTION_VALUE when the two lists have different lengths.
Result<Preferences> read_preferences(const ConverterSettings& settings);
// The same, with those of the peer.
Result<Preferences> read_preferences(const ConverterSettings& settings, const gst::PeerCaps& peer);

// The caps of the sink pad: first those that fit the peer (docs/compatibility/converter.md 2.3),
// then the rest of the template, because the error of the element that rejects them explains more
// than a failed link. For the same reason, if none of them intersect `filter` (may be null), media
// in unsupported formats are offered too: their caps produce an error with a fix. With `any_media`,
// as a mode requires, all media are offered.
gst::Ref<GstCaps> offered_caps(GstPad* sink, GstPad* source, const GstCaps* filter, bool any_media);

// What the source pad will have, with any framerate, for such an input. Null where that is not
// known: where the stream, a converter of its own or the peer decides, or more than the framerate
// is open.
gst::Ref<GstCaps> expected_caps(const GstCaps* input, GstPad* source,
                                const ConverterSettings& settings);

// Whether these caps may reach the element, to be accepted or rejected with an error.
bool is_accepted_by_element(const GstCaps* caps, bool any_media);

}  // namespace weir
