// FlexValue: a value in a FlexBuffers buffer. It never reads outside of the buffer, whatever the
// bytes say. Format: flatbuffers.dev, "FlexBuffers", internals.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace weir::messages {

class FlexElements;

class FlexValue {
 public:
  // The value that the buffer ends in; nullopt when there is none.
  static std::optional<FlexValue> root(std::span<const std::byte> buffer) noexcept;

  bool is_map() const noexcept;
  // The elements of a map or vector; nullopt for other values and when they do not lie in the
  // buffer.
  std::optional<FlexElements> elements() const noexcept;
  // An integer, stored in the parent or elsewhere.
  std::optional<int64_t> integer() const noexcept;
  std::optional<std::span<const std::byte>> blob() const noexcept;

 private:
  friend class FlexElements;
  FlexValue(std::span<const std::byte> buffer, size_t at, size_t parent_width, uint8_t type)
      : buffer_(buffer), at_(at), parent_width_(parent_width), packed_type_(type) {}
  uint8_t type() const noexcept { return packed_type_ >> 2; }
  size_t width() const noexcept { return size_t{1} << (packed_type_ & 3); }
  std::optional<uint64_t> number(size_t at, size_t width) const noexcept;
  std::optional<int64_t> signed_number(size_t at, size_t width) const noexcept;
  // Where the offset at `at` leads to.
  std::optional<size_t> follow(size_t at, size_t width) const noexcept;
  std::optional<size_t> target() const noexcept { return follow(at_, parent_width_); }
  bool has(size_t at, uint64_t bytes) const noexcept {
    return at <= buffer_.size() && bytes <= buffer_.size() - at;
  }
  // The number of elements in front of `first`, if they lie in the buffer.
  std::optional<size_t> length_before(size_t first, uint64_t element_bytes) const noexcept;

  std::span<const std::byte> buffer_;
  size_t at_, parent_width_;
  uint8_t packed_type_;
};

// The elements of a map or vector, all inside of the buffer.
class FlexElements {
 public:
  size_t size() const noexcept { return count_; }
  // Precondition of both: index < size().
  FlexValue at(size_t index) const noexcept;
  // The key of an element of a map, without its terminating zero; its first 32 bytes if it is
  // longer. Nullopt for vectors and damaged keys.
  std::optional<std::string_view> key_at(size_t index) const noexcept;
  // Copies the elements; false unless all are integers from 0 to 2^32 - 1. Precondition: `out` has
  // at least size() elements.
  bool copy_to(std::span<uint32_t> out) const noexcept;

 private:
  friend class FlexValue;
  FlexElements(const FlexValue& of, size_t first, size_t count, uint8_t type)
      : of_(of), first_(first), count_(count), type_(type) {}
  void find_keys() noexcept;

  FlexValue of_;
  size_t first_, count_;
  uint8_t type_;                          // of each element; 0: types follow the elements
  size_t first_key_ = 0, key_width_ = 0;  // 0: no keys
};

}  // namespace weir::messages
