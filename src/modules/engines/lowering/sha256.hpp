// SHA-256 (FIPS 180-4).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace weir::engine {

using Digest = std::array<std::byte, 32>;

Digest sha256(std::span<const std::byte> bytes);
std::string hexadecimal(const Digest& digest);

}  // namespace weir::engine
