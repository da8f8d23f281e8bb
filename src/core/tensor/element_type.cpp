// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/element_type.hpp"

#include <array>

#include "core/text/text.hpp"

namespace weir {
namespace {

constexpr std::array<std::string_view, 11> kNames{"int32", "uint32", "int16",   "uint16",
                                                  "int8",  "uint8",  "float64", "float32",
                                                  "int64", "uint64", "float16"};
constexpr std::array<size_t, 11> kSizes{4, 4, 2, 2, 1, 1, 8, 4, 8, 8, 2};

}  // namespace

size_t element_size(ElementType type) noexcept {
  const auto i = static_cast<size_t>(type);
  return i < kSizes.size() ? kSizes[i] : 0;
}

std::string_view to_string(ElementType type) noexcept {
  const auto i = static_cast<size_t>(type);
  return i < kNames.size() ? kNames[i] : "invalid";
}

ElementType parse_element_type(std::string_view text) noexcept {
  const auto word = strip(text);
  for (size_t i = 0; i < kNames.size(); ++i)
    if (equal_ignoring_case(word, kNames[i])) return static_cast<ElementType>(i);
  return ElementType::End;
}

}  // namespace weir
