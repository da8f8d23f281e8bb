// ProtobufReader: the fields of one protobuf message, never read past its end.
// Encoding: protobuf.dev/programming-guides/encoding.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace weir::engine {

class ProtobufReader {
 public:
  struct Field {
    uint32_t number = 0;
    uint64_t value = 0;                // of a varint
    std::span<const std::byte> bytes;  // of a length-delimited field
    bool delimited = false;
    std::string_view text() const noexcept {
      return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
  };

  explicit ProtobufReader(std::span<const std::byte> message) noexcept : message_(message) {}

  // False at the end and at the first damage; good() tells which.
  bool next(Field* field) noexcept;
  bool good() const noexcept { return good_; }
  // How many bytes a field would reach beyond the end; 0 when the damage is of another kind.
  uint64_t missing() const noexcept { return missing_; }

 private:
  bool varint(uint64_t* value) noexcept;
  bool skip(uint64_t bytes) noexcept;
  bool damaged() noexcept {
    good_ = false;
    return false;
  }

  std::span<const std::byte> message_;
  size_t at_ = 0;
  bool good_ = true;
  uint64_t missing_ = 0;
};

// Whether a message can begin with these bytes: it is good up to where they end.
bool can_begin_message(std::span<const std::byte> head) noexcept;

}  // namespace weir::engine
