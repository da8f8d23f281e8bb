// Descriptors through which programs call Weir's own engines, decoders and converters.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "nnstreamer_plugin_api_converter.h"
#include "nnstreamer_plugin_api_decoder.h"
#include "nnstreamer_plugin_api_filter.h"
#include "weir/result.hpp"

namespace weir::compat {

// Find by name or alias; errors are those of the module library.
Result<const GstTensorFilterFramework*> builtin_filter(const char* name);
Result<const GstTensorDecoderDef*> builtin_decoder(const char* name);
Result<const NNStreamerExternalConverter*> builtin_converter(const char* name);

}  // namespace weir::compat
