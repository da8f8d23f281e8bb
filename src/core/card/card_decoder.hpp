// Reads the decoder of a card: a mode that comes with Weir, and values that it may have.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/card/fields.hpp"

namespace weir::card {

// A card comes with a model from anywhere. It chooses among what Weir has; only the user's command
// line can name scripts, libraries and files of other folders.

// Reads the field `decoder`: the name of one of decoder_modes(), "" for none or a faulty one.
std::string decoder_from(Fields* fields);

// Reads the field `decoder_options`: properties of tensor_decoder with this mode. Names of files
// get `folder`.
std::vector<std::pair<std::string, std::string>> decoder_options_from(
    Fields* fields, const std::string& mode, const std::filesystem::path& folder, Faults* faults);

}  // namespace weir::card
