// Protobuf's encoding: written into strings, and read from a message that lies in several pieces of
// memory, as gRPC receives it. Nothing is copied but what the caller asks for.
//
//   Field field;
//   for (FieldReader reader(chunks, {0, chunks.size()}); reader.next(&field);)
//     if (field.number == 1) name = reader.text(field, 256);
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace weir::net {

// ---- Writing -----------------------------------------------------------------------------------

enum class WireType : uint32_t { Varint = 0, Fixed64 = 1, Bytes = 2, Fixed32 = 5 };

void put_varint(std::string* to, uint64_t value);
// The tag and the length of a field whose bytes follow.
void put_bytes_header(std::string* to, uint32_t field, size_t bytes);
void put_bytes(std::string* to, uint32_t field, std::string_view bytes);
// Write nothing for the default of proto3: 0, and an empty text.
void put_number(std::string* to, uint32_t field, uint64_t value);
void put_text(std::string* to, uint32_t field, std::string_view text);

// ---- Reading -----------------------------------------------------------------------------------

struct Range {
  size_t begin = 0, end = 0;
  size_t size() const noexcept { return end - begin; }
};

// The pieces of one message. Borrows their memory.
class Chunks {
 public:
  using Chunk = std::span<const std::byte>;
  Chunks() = default;
  explicit Chunks(std::vector<Chunk> chunks);
  size_t size() const noexcept { return size_; }
  // Copies the bytes of `range`, which must be within size().
  void copy(Range range, void* to) const noexcept;
  // The rest of the chunk that has the byte at `offset`; empty at the end.
  Chunk from(size_t offset) const noexcept;

 private:
  std::vector<Chunk> chunks_;   // none is empty
  std::vector<size_t> begins_;  // the offset of each chunk
  size_t size_ = 0;
};

// Reads the numbers of a range one after the other.
class Cursor {
 public:
  Cursor(const Chunks& chunks, Range range) noexcept : chunks_(chunks), range_(range) {}
  size_t offset() const noexcept { return range_.begin; }
  bool at_end() const noexcept { return range_.begin == range_.end; }
  // nullopt when the range ends first, or after ten bytes.
  std::optional<uint64_t> varint() noexcept;
  // Little-endian, of 4 or 8 bytes.
  std::optional<uint64_t> fixed(size_t bytes) noexcept;
  bool skip(uint64_t bytes) noexcept;

 private:
  bool byte(uint8_t* out) noexcept;

  const Chunks& chunks_;
  Range range_;
  Chunks::Chunk piece_;  // unread bytes at range_.begin; may be empty
};

struct Field {
  uint32_t number = 0;
  WireType type = WireType::Varint;
  uint64_t value = 0;  // of a varint or a fixed number
  Range range;         // of the bytes, or of the encoded number
};

// Reads the fields of one message. Groups, which proto3 does not have, are errors.
class FieldReader {
 public:
  FieldReader(const Chunks& chunks, Range range) noexcept
      : chunks_(chunks), end_(range.end), cursor_(chunks, range) {}
  // Returns false at the end and at the first error.
  bool next(Field* field);
  bool failed() const noexcept { return failed_; }
  // Returns the bytes of a field as text; marks the message as failed when there are more than
  // `max_bytes`.
  std::string text(const Field& field, size_t max_bytes);

 private:
  bool fail() noexcept {
    failed_ = true;
    return false;
  }

  const Chunks& chunks_;
  size_t end_;
  Cursor cursor_;
  bool failed_ = false;
};

}  // namespace weir::net
