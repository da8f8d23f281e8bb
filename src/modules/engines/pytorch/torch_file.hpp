// What kind of file a .pt is, told from its bytes before libtorch sees it.
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

// How sure the first bytes make one that libtorch writes such files: 0 to 100.
int torch_score(std::span<const unsigned char> head) noexcept;

// The checksum of zip archives: of these bytes, after others that have the checksum `before`.
uint32_t crc32(std::span<const std::byte> bytes, uint32_t before = 0) noexcept;

// An entry that is compressed: its checksum is to be held against what comes out of it.
struct CompressedEntry {
  std::string name;  // without the folder that bears the model's name
  uint32_t crc = 0;
};

// The compressed entries of a whole zip archive with TorchScript's code in it. MODEL_UNSUPPORTED
// names a state dict or a pickled Python object; MODEL_INVALID what is cut, damaged or of another
// format, or has entries that share a name or bytes, which no writer makes: each byte is read at
// most once. The archive is the zip of PKWARE's appnote, ZIP64 too; the checksums of stored entries
// are compared: libtorch 1.13 does not look at checksums, and its parser ends the process over some
// damaged code.
Result<std::vector<CompressedEntry>> check_torch_file(const ModelSource& file);

}  // namespace weir::engine
