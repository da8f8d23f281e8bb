// Which key points of a body or hand are connected, by their number.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <span>
#include <utility>

namespace weir::draw {

using Connection = std::pair<uint8_t, uint8_t>;

// 17: COCO's key points, in its order (cocodataset.org, person key points). 33: MediaPipe's pose
// landmarks. 21: its hand landmarks. Empty for other numbers.
std::span<const Connection> connections_of(size_t points) noexcept;

}  // namespace weir::draw
