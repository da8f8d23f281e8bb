// ProtobufReader: iterates over the fields of one protobuf message and never reads past its end.
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
    uint64_t value = 0;                // for a varint
    std::span<const std::byte> bytes;  // for a length-delimited field
    bool delimited = false;
    std::string_view text() const noexcept {
      return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
  };

  explicit ProtobufReader(std::span<const std::byte> message) noexcept : message_(message) {}

  // False at the end and at the first damage; good() distinguishes the two.
  bool next(Field* field) noexcept;
  bool good() const noexcept { return good_; }
  // How many bytes a field would extend past the end; 0 for any other damage.
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

// Whether a message can begin with these bytes: they are valid up to their end.
bool can_begin_message(std::span<const std::byte> head) noexcept;

}  // namespace weir::engine
