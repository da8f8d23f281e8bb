// What tensor_converter answers to caps queries, and what it wishes from the next element.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "elements/tensor_converter/converter_settings.hpp"
#include "elements/tensor_converter/medium.hpp"

namespace weir {

// DIMENSION_SYNTAX, TYPE_SYNTAX, or OPTION_VALUE when the two lists differ in number.
Result<Wishes> wishes(const ConverterSettings& settings, GstPad* source);

// Whether downstream takes caps of `spec`.
bool is_taken(GstPad* source, const FrameSpec& spec);

// What the sink pad takes: first what fits the next element (specification 2, "Caps query"), then
// all else of the template: the message of the element that refuses it says more than a pipeline
// that cannot be linked. For the same reason, where nothing of that fits `filter` (may be null),
// media in formats that no tensor has are offered too: their caps bring an error with the line that
// mends it. With `any_media`, as a mode makes them, everything is.
gst::Ref<GstCaps> offered_caps(GstPad* sink, GstPad* source, const GstCaps* filter, bool any_media);

// Whether caps come to the element at all: taken there, or refused by name.
bool come_to_the_element(const GstCaps* caps, bool any_media);

}  // namespace weir
