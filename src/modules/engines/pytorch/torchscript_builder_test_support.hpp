// Builds small TorchScript archives for tests, entry by entry: a zip archive of stored files.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace weir::engine_test {

using ZipEntries = std::vector<std::pair<std::string, std::string>>;  // name, content
std::vector<std::byte> zip(const ZipEntries& entries);

// A module without weights. `methods`: the lines of its methods, from "def forward(self, ..." on,
// as in Python, without leading indentation.
std::vector<std::byte> torchscript(const std::string& methods, const std::string& version = "3");
// The entries of that archive.
ZipEntries torchscript_entries(const std::string& methods, const std::string& version = "3");

}  // namespace weir::engine_test
