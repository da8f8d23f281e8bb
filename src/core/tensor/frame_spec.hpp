// TensorSpec and FrameSpec: the type and shape of one tensor, and the contents of each frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/tensor/element_type.hpp"
#include "core/tensor/result_roles.hpp"
#include "core/tensor/shape.hpp"
#include "weir/result.hpp"

namespace weir {

inline constexpr size_t kTensorLimit = 256;  // tensors in a frame
inline constexpr size_t kMemoryLimit = 16;   // memories in a buffer

enum class Format : uint32_t { Static = 0, Flexible = 1, Sparse = 2, End = 3 };
std::string_view to_string(Format format) noexcept;   // "static", ...
Format parse_format(std::string_view text) noexcept;  // case ignored; End when unknown

enum class MediaType : int32_t {
  Invalid = -1,
  Video = 0,
  Audio,
  Text,
  Octet,
  Tensor,
  Any = 0x1000
};
// Returns the type of a caps name: docs/compatibility/types-and-caps.md 1.3.
MediaType media_type_of_caps_name(std::string_view name) noexcept;

struct TensorSpec {
  ElementType type = ElementType::End;
  Shape shape;
  std::string name;  // never in caps; "" = none

  bool valid() const noexcept { return type != ElementType::End && shape.valid(); }
  // Size of a dense tensor; nullopt when invalid or beyond 63 bits.
  std::optional<uint64_t> bytes() const noexcept;
  bool same_layout(const TensorSpec& other) const noexcept {  // ignores names
    return type == other.type && shape == other.shape;
  }
  std::string to_string() const;  // "uint8 3:224:224:1"
};

// Lists as written in properties and caps: "3:224:224:1,1001:1", "uint8.float32", "a,b". More than
// kTensorLimit entries are an error, and so is an unreadable entry; the error gives its position.
Result<std::vector<Shape>> parse_shape_list(std::string_view text);
Result<std::vector<ElementType>> parse_type_list(std::string_view text);
std::vector<std::string> parse_name_list(std::string_view text);
std::string join_shapes(const std::vector<TensorSpec>& tensors, size_t min_entries = 0);
std::string join_types(const std::vector<TensorSpec>& tensors);
std::string join_names(const std::vector<TensorSpec>& tensors);

struct Fraction {
  int numerator = -1;
  int denominator = -1;
  bool valid() const noexcept { return numerator >= 0 && denominator > 0; }
  bool operator==(const Fraction& other) const noexcept;  // as reduced fractions
};

struct FrameSpec {
  Format format = Format::End;
  std::vector<TensorSpec> tensors;  // empty unless static
  Fraction rate;
  ResultRoles roles = {};  // not compared: results are tensors like others

  // docs/compatibility/types-and-caps.md 1.5 says when they are valid and when equal.
  bool valid() const noexcept;
  bool info_valid() const noexcept;  // the same without the rate
  bool operator==(const FrameSpec& other) const noexcept;
  std::optional<uint64_t> bytes() const noexcept;  // of all tensors, static only
  std::string to_string() const;                   // "2 tensors: uint8 3:224:224:1, float32 10:1"
};

// Describes the first difference between two lists of tensors, "" if they are equal: "tensor 0:
// type is uint8, needed is float32".
std::string first_difference(const std::vector<TensorSpec>& offered,
                             const std::vector<TensorSpec>& needed);

}  // namespace weir
