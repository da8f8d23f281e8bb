// ElementType: the eleven element types of a tensor. The values are part of wire formats.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>

#include "core/tensor/float16.hpp"

namespace weir {

enum class ElementType : uint32_t {
  Int32 = 0,
  UInt32,
  Int16,
  UInt16,
  Int8,
  UInt8,
  Float64,
  Float32,
  Int64,
  UInt64,
  Float16,
  End  // not a type
};

// Bytes of one element; 0 for End.
size_t element_size(ElementType type) noexcept;
// "uint8", "float32", ...; "invalid" for End.
std::string_view to_string(ElementType type) noexcept;
// Ignores case and surrounding blanks; returns End for anything but an exact name.
ElementType parse_element_type(std::string_view text) noexcept;

// Calls f(std::type_identity<T>{}) with the C++ type of `type`: the only type switch in Weir.
// Precondition: type != End. All calls of f return the same type.
template <class F>
decltype(auto) visit_type(ElementType type, F&& f) {
  switch (type) {
    case ElementType::Int32:
      return f(std::type_identity<int32_t>{});
    case ElementType::UInt32:
      return f(std::type_identity<uint32_t>{});
    case ElementType::Int16:
      return f(std::type_identity<int16_t>{});
    case ElementType::UInt16:
      return f(std::type_identity<uint16_t>{});
    case ElementType::Int8:
      return f(std::type_identity<int8_t>{});
    case ElementType::UInt8:
      return f(std::type_identity<uint8_t>{});
    case ElementType::Float64:
      return f(std::type_identity<double>{});
    case ElementType::Float32:
      return f(std::type_identity<float>{});
    case ElementType::Int64:
      return f(std::type_identity<int64_t>{});
    case ElementType::UInt64:
      return f(std::type_identity<uint64_t>{});
    case ElementType::Float16:
      return f(std::type_identity<float16>{});
    case ElementType::End:
      break;
  }
  __builtin_unreachable();
}

}  // namespace weir
