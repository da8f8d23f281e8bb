// Folders with annotation files: of COCO and of MOTChallenge.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <filesystem>
#include <string>

#include "evaluate/labelled_folder.hpp"

namespace weir::app {

// The one JSON file of the folder or of its folder annotations/; "" if there is none. OPTION_VALUE
// if there are several.
Result<std::string> annotation_file_of(const std::filesystem::path& folder);
// Pictures are looked for in the folder, in its folder images/ and in the other folders below it.
Result<LabelledFolder> read_annotated(const std::filesystem::path& folder,
                                      const std::string& annotations);

bool is_sequence(const std::filesystem::path& folder);  // it has seqinfo.ini
bool has_sequences(const std::filesystem::path& folder);
Result<LabelledFolder> read_sequences(const std::filesystem::path& folder);

}  // namespace weir::app
