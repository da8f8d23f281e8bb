// Determines the kind of a .pt file from its bytes before libtorch reads it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "model_source.hpp"
#include "weir/result.hpp"

namespace weir::engine {

// Returns 0 to 100: the confidence that libtorch writes files with these first bytes.
int torch_score(std::span<const unsigned char> head) noexcept;

// The checksum of zip archives; `before` is the checksum of the preceding bytes.
uint32_t crc32(std::span<const std::byte> bytes, uint32_t before = 0) noexcept;

// A compressed entry: its checksum must be compared with the decompressed content.
struct CompressedEntry {
  std::string name;  // without the folder with the model's name
  uint32_t crc = 0;
};

// Checks a zip archive with TorchScript code and returns its compressed entries. MODEL_UNSUPPORTED
// names a state dict or a pickled Python object. MODEL_INVALID for an archive that is truncated,
// damaged, of another format, or has entries that share a name or bytes, which no writer produces:
// so each byte is read at most once. Reads the zip format of PKWARE's appnote, with ZIP64, and
// compares the checksums of stored entries, because libtorch 1.13 ignores checksums and its parser
// aborts the process on some damaged code.
Result<std::vector<CompressedEntry>> check_torch_file(const ModelSource& file);

}  // namespace weir::engine
