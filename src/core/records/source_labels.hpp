// Names of classes by the name of their source, as streams of results carry them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <string>
#include <vector>

namespace weir::records {

using LabelsBySource = std::map<std::string, std::vector<std::string>>;

// The names of `sources`, in their order; empty if none is known.
std::vector<std::vector<std::string>> labels_of_sources(const LabelsBySource& labels,
                                                        const std::vector<std::string>& sources);

}  // namespace weir::records
