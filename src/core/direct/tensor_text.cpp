// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/direct/tensor_text.hpp"

#include <algorithm>
#include <span>

#include "core/tensor/element_type.hpp"
#include "weir/join.hpp"

namespace weir::direct {
namespace {

// Keeps every product far from overflow.
constexpr uint64_t kBytesLimit = uint64_t{1} << 48;

std::string extent_text(int64_t extent) {
  return extent < 0 ? "?" : std::to_string(extent);
}

}  // namespace

bool is_fixed(const weir_tensor_info& info) noexcept {
  return info.type < WEIR_TYPE_END && info.rank <= WEIR_RANK_LIMIT &&
         std::all_of(info.shape, info.shape + info.rank, [](int64_t d) { return d >= 0; });
}

std::optional<uint64_t> count_bytes(const weir_tensor_info& info) noexcept {
  if (!is_fixed(info)) return std::nullopt;
  uint64_t bytes = element_size(static_cast<ElementType>(info.type));
  for (uint32_t i = 0; i < info.rank; ++i) {
    const auto extent = static_cast<uint64_t>(info.shape[i]);
    if (extent != 0 && bytes > kBytesLimit / extent) return std::nullopt;
    bytes *= extent;
  }
  return bytes;
}

std::string shape_text(const weir_tensor_info& info) {
  if (info.rank > WEIR_RANK_LIMIT) return "any shape";
  const std::string out = join(std::span(info.shape, info.rank), ", ",
                               [](int64_t extent) { return extent_text(extent); });
  return "(" + out + (info.rank == 1 ? ",)" : ")");
}

std::string to_string(const weir_tensor_info& info) {
  std::string out = info.type < WEIR_TYPE_END
                        ? std::string(to_string(static_cast<ElementType>(info.type)))
                        : "any type";
  out += " " + shape_text(info);
  if (info.name && *info.name) out += std::string(" ") + info.name;
  return out;
}

std::string place_text(const char* role, size_t index, const weir_tensor_info& info) {
  std::string out = std::string(role) + " " + std::to_string(index);
  if (info.name && *info.name) out += std::string(" (") + info.name + ")";
  return out;
}

std::string shape_difference(const weir_tensor_info& given, const weir_tensor_info& wanted) {
  if (wanted.rank > WEIR_RANK_LIMIT) return "";
  if (given.rank != wanted.rank)
    return "rank " + std::to_string(given.rank) + " instead of " + std::to_string(wanted.rank);
  for (uint32_t i = 0; i < wanted.rank; ++i)
    if (wanted.shape[i] >= 0 && given.shape[i] != wanted.shape[i])
      return "axis " + std::to_string(i) + " is " + extent_text(given.shape[i]) + " instead of " +
             std::to_string(wanted.shape[i]);
  return "";
}

}  // namespace weir::direct
