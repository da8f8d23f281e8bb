// Which media there are: by the name of their caps, and as caps of the sink pad.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <set>
#include <string>

#include "core/convert/converter_mode.hpp"
#include "elements/tensor_converter/medium.hpp"

namespace weir {

// The medium for these caps, an external converter's last; FORMAT_UNSUPPORTED when there is none.
// A mode makes any caps a medium.
Result<std::unique_ptr<Medium>> medium_for(const GstCaps* caps, const ConverterMode& mode);

// Whether a function of the program has this name, by Weir's interface or NNStreamer's.
bool is_custom_code(const std::string& name);

// External converters that are installed or registered; nothing is opened.
std::set<std::string> converter_names();

// Every stream that can be converted; those of external converters are last.
gst::Ref<GstCaps> caps_of_media();
// What becomes the tensors `peer`, best first; "" when nothing is known to. Bytes always can.
std::string caps_of_media_for(const TensorSpec& peer, const Fraction& rate);

}  // namespace weir
