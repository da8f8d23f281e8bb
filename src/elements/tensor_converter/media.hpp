// Lists the media: by caps name, and as caps of the sink pad.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <set>
#include <string>

#include "core/convert/converter_mode.hpp"
#include "elements/tensor_converter/medium.hpp"

namespace weir {

// Returns the medium for these caps, external converters last; FORMAT_UNSUPPORTED when there is
// none. With a mode, any caps have a medium.
Result<std::unique_ptr<Medium>> medium_for(const GstCaps* caps, const ConverterMode& mode);

// FILE_NOT_FOUND for a script that Weir's Python cannot read. A converter python3 of others may
// give the text another meaning.
Status check_script(const std::string& path);
// Whether a function of this name was registered through Weir's or NNStreamer's API.
bool is_custom_code(const std::string& name);

// Names of installed or registered external converters; opens none.
std::set<std::string> converter_names();

// Caps of every stream that can be converted; external converters' last.
gst::Ref<GstCaps> caps_of_media();
// Caps that convert to `peer`, best first; "" when none are known. Bytes always convert.
std::string caps_of_media_for(const TensorSpec& peer, const Fraction& rate);

}  // namespace weir
