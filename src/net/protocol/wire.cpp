// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/protocol/wire.hpp"

#include <algorithm>
#include <cstring>

namespace weir::net {

void put_varint(std::string* to, uint64_t value) {
  for (; value >= 0x80; value >>= 7) to->push_back(static_cast<char>(value | 0x80));
  to->push_back(static_cast<char>(value));
}

void put_bytes_header(std::string* to, uint32_t field, size_t bytes) {
  put_varint(to, uint64_t{field} << 3 | static_cast<uint32_t>(WireType::Bytes));
  put_varint(to, bytes);
}

void put_bytes(std::string* to, uint32_t field, std::string_view bytes) {
  put_bytes_header(to, field, bytes.size());
  *to += bytes;
}

void put_number(std::string* to, uint32_t field, uint64_t value) {
  if (value == 0) return;
  put_varint(to, uint64_t{field} << 3 | static_cast<uint32_t>(WireType::Varint));
  put_varint(to, value);
}

void put_text(std::string* to, uint32_t field, std::string_view text) {
  if (!text.empty()) put_bytes(to, field, text);
}

Chunks::Chunks(std::vector<Chunk> chunks) : chunks_(std::move(chunks)) {
  std::erase_if(chunks_, [](const auto& chunk) { return chunk.empty(); });
  for (const auto& chunk : chunks_) {
    begins_.push_back(size_);
    size_ += chunk.size();
  }
}

Chunks::Chunk Chunks::from(size_t offset) const noexcept {
  if (offset >= size_) return {};
  const auto after = std::upper_bound(begins_.begin(), begins_.end(), offset);
  const auto index = static_cast<size_t>(after - begins_.begin()) - 1;
  return chunks_[index].subspan(offset - begins_[index]);
}

void Chunks::copy(Range range, void* to) const noexcept {
  auto* at = static_cast<std::byte*>(to);
  while (range.begin < range.end) {
    const Chunk piece = from(range.begin);
    const size_t bytes = std::min(piece.size(), range.size());
    std::memcpy(at, piece.data(), bytes);
    at += bytes;
    range.begin += bytes;
  }
}

bool Cursor::byte(uint8_t* out) noexcept {
  if (at_end()) return false;
  if (piece_.empty()) piece_ = chunks_.from(range_.begin);
  if (piece_.empty()) return false;
  *out = static_cast<uint8_t>(piece_.front());
  piece_ = piece_.subspan(1);
  ++range_.begin;
  return true;
}

std::optional<uint64_t> Cursor::varint() noexcept {
  uint64_t value = 0;
  for (int shift = 0; shift < 70; shift += 7) {
    uint8_t next = 0;
    if (!byte(&next)) return std::nullopt;
    value |= shift < 64 ? uint64_t{next & 0x7Fu} << shift : 0;
    if (next < 0x80) return value;
  }
  return std::nullopt;
}

std::optional<uint64_t> Cursor::fixed(size_t bytes) noexcept {
  uint64_t value = 0;
  for (size_t i = 0; i < bytes; ++i) {
    uint8_t next = 0;
    if (!byte(&next)) return std::nullopt;
    value |= uint64_t{next} << (8 * i);
  }
  return value;
}

bool Cursor::skip(uint64_t bytes) noexcept {
  if (bytes > range_.size()) return false;
  range_.begin += bytes;
  piece_ = bytes < piece_.size() ? piece_.subspan(bytes) : Chunks::Chunk{};
  return true;
}

bool FieldReader::next(Field* field) {
  if (failed_ || cursor_.at_end()) return false;
  const auto tag = cursor_.varint();
  if (!tag || *tag >> 3 == 0 || *tag >> 3 > 0x1FFFFFFF) return fail();
  field->number = static_cast<uint32_t>(*tag >> 3);
  field->type = static_cast<WireType>(*tag & 7);
  field->value = 0;
  field->range.begin = cursor_.offset();
  std::optional<uint64_t> value;
  switch (field->type) {
    case WireType::Varint:
      value = cursor_.varint();
      break;
    case WireType::Fixed64:
      value = cursor_.fixed(8);
      break;
    case WireType::Fixed32:
      value = cursor_.fixed(4);
      break;
    case WireType::Bytes: {
      const auto bytes = cursor_.varint();
      field->range.begin = cursor_.offset();
      if (!bytes || !cursor_.skip(*bytes)) return fail();
      value = 0;
      break;
    }
    default:
      return fail();
  }
  if (!value) return fail();
  field->value = *value;
  field->range.end = cursor_.offset();
  return true;
}

std::string FieldReader::text(const Field& field, size_t max_bytes) {
  if (field.type != WireType::Bytes || field.range.size() > max_bytes || field.range.end > end_) {
    fail();
    return {};
  }
  std::string out(field.range.size(), '\0');
  chunks_.copy(field.range, out.data());
  return out;
}

}  // namespace weir::net
