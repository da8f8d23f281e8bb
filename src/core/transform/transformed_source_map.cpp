// Computes the source map after each operation.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/transformed_source_map.hpp"

namespace weir::transform {
namespace {

SourceMap after(const Transpose& transpose, SourceMap map) noexcept {
  const SourceMap before = map;
  for (size_t i = 0; i < transpose.order.size(); ++i) {
    if (transpose.order[i] == before.x_dimension) map.x_dimension = static_cast<uint8_t>(i);
    if (transpose.order[i] == before.y_dimension) map.y_dimension = static_cast<uint8_t>(i);
  }
  return map;
}

SourceMap after(const Dimchg& dimchg, SourceMap map) noexcept {
  const auto moved = [&dimchg](uint8_t dimension) -> uint8_t {
    const auto [from, to] = dimchg;
    if (dimension == from) return to;
    if (dimension > from && dimension <= to) return static_cast<uint8_t>(dimension - 1);
    if (dimension < from && dimension >= to) return static_cast<uint8_t>(dimension + 1);
    return dimension;
  };
  map.x_dimension = moved(map.x_dimension);
  map.y_dimension = moved(map.y_dimension);
  return map;
}

SourceMap after(const Padding& padding, const SourceMap& map) noexcept {
  const auto at = [](const std::array<uint32_t, 3>& sides, uint8_t dimension) {
    return dimension < sides.size() ? sides[dimension] : 0;
  };
  const uint32_t left = at(padding.before, map.x_dimension),
                 top = at(padding.before, map.y_dimension);
  return map.of_part(1, -static_cast<double>(left), 1, -static_cast<double>(top),
                     map.width + left + at(padding.after, map.x_dimension),
                     map.height + top + at(padding.after, map.y_dimension));
}

template <class Other>
SourceMap after(const Other&, const SourceMap& map) noexcept {
  return map;
}

}  // namespace

SourceMap transform_source_map(const Operation& operation, const SourceMap& in) {
  return std::visit([&in](const auto& op) { return after(op, in); }, operation.what);
}

}  // namespace weir::transform
