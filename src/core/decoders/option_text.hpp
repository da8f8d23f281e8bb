// Readers of option texts that several decoders share. They throw Failure with the option's name.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "core/tensor/geometry.hpp"
#include "weir/module.hpp"

namespace weir::decoders {

// Reads "W:H", pixels of at least 1. `meaning` is the option's purpose for errors: "the size of the
// output". A missing or empty option is an error too.
Size read_size(const Options& options, const char* option, const char* meaning);
// Reads "0" or "1"; false if the option is missing or empty.
bool read_switch(const Options& options, const char* option);

}  // namespace weir::decoders
