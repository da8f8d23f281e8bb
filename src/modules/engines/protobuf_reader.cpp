// SPDX-License-Identifier: LGPL-2.1-or-later
#include "protobuf_reader.hpp"

namespace weir::engine {

bool ProtobufReader::varint(uint64_t* value) noexcept {
  *value = 0;
  for (unsigned shift = 0; shift < 70; shift += 7) {
    if (at_ >= message_.size()) {
      missing_ = 1;
      return damaged();
    }
    const auto byte = static_cast<uint64_t>(message_[at_++]);
    if (shift < 64) *value |= (byte & 0x7F) << shift;
    if (byte < 0x80) return true;
  }
  return damaged();
}

bool ProtobufReader::skip(uint64_t bytes) noexcept {
  const uint64_t left = message_.size() - at_;
  if (bytes > left) {
    missing_ = bytes - left;
    return damaged();
  }
  at_ += bytes;
  return true;
}

bool ProtobufReader::next(Field* field) noexcept {
  if (!good_ || at_ == message_.size()) return false;
  uint64_t tag = 0;
  if (!varint(&tag)) return false;
  *field = {};
  field->number = static_cast<uint32_t>(tag >> 3);
  if (tag >> 32 != 0 || field->number == 0) return damaged();
  switch (tag & 7) {
    case 0:
      return varint(&field->value);
    case 1:
      return skip(8);
    case 2: {
      uint64_t size = 0;
      if (!varint(&size)) return false;
      const size_t begin = at_;
      if (!skip(size)) return false;
      field->delimited = true;
      field->bytes = message_.subspan(begin, size);
      return true;
    }
    case 5:
      return skip(4);
    default:  // groups, which ONNX does not use
      return damaged();
  }
}

bool can_begin_message(std::span<const std::byte> head) noexcept {
  ProtobufReader reader(head);
  for (ProtobufReader::Field field; reader.next(&field);) {
  }
  return reader.good() || reader.missing() > 0;
}

}  // namespace weir::engine
