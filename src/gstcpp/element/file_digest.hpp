// The SHA-256 digest of a file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

namespace weir::gst {

// 64 lower-case hexadecimal digits. A file that cannot be read has the digest of an empty one.
std::string compute_sha256(const std::string& path);
// The same, computed once in this process as long as the file keeps its size and time.
std::string known_sha256(const std::string& path);

}  // namespace weir::gst
