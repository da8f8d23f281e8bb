// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tflite-file/flat_buffer.hpp"

namespace weir::engine {

FlatTable FlatFile::root() noexcept {
  return {this, read<uint32_t>(0)};
}

FlatTable::FlatTable(FlatFile* file, uint64_t at) noexcept {
  file->visit(1);
  const int64_t vtable = static_cast<int64_t>(at) - file->read<int32_t>(at);
  const bool aligned = at % 4 == 0 && vtable >= 0 && vtable % 2 == 0;
  if (!aligned || !read_vtable(file, at, static_cast<uint64_t>(vtable))) {
    file->mark_damaged();
    return;
  }
  file_ = file;
  at_ = at;
  vtable_ = static_cast<uint64_t>(vtable);
}

bool FlatTable::read_vtable(FlatFile* file, uint64_t at, uint64_t vtable) noexcept {
  vtable_bytes_ = file->read<uint16_t>(vtable);
  table_bytes_ = file->read<uint16_t>(vtable + 2);
  if (vtable_bytes_ < 4 || vtable_bytes_ % 2 != 0 || table_bytes_ < 4 ||
      !file->holds(vtable, vtable_bytes_) || !file->holds(at, table_bytes_))
    return false;
  // Also checks fields that we do not know: other readers follow them and must stay in the table.
  for (uint32_t entry = 4; entry < vtable_bytes_; entry += 2)
    if (file->read<uint16_t>(vtable + entry) >= table_bytes_) return false;
  return !file->damaged();
}

uint64_t FlatTable::place(uint32_t field) const noexcept {
  const uint32_t entry = 4 + 2 * field;
  if (!file_ || entry >= vtable_bytes_) return 0;
  const auto offset = file_->read<uint16_t>(vtable_ + entry);
  return offset ? at_ + offset : 0;
}

uint64_t FlatTable::target(uint32_t field) const noexcept {
  const uint64_t at = place(field);
  return at ? at + file_->read<uint32_t>(at) : 0;
}

FlatTable FlatTable::table(uint32_t field) const noexcept {
  const uint64_t at = target(field);
  return at ? FlatTable(file_, at) : FlatTable();
}

FlatVector FlatTable::vector(uint32_t field, uint32_t element_bytes) const noexcept {
  const uint64_t at = target(field);
  if (!at) return {};
  const auto size = file_->read<uint32_t>(at);
  if (at % 4 != 0 || file_->damaged() || !file_->holds(at + 4, uint64_t{size} * element_bytes)) {
    file_->mark_damaged();
    return {};
  }
  return {file_, at + 4, size};
}

FlatVector FlatTable::string(uint32_t field) const noexcept {
  const FlatVector out = vector(field, 1);
  if (!out) return out;
  const auto* end = reinterpret_cast<const std::byte*>(out.text().data()) + out.size();
  if (!file_->holds(static_cast<uint64_t>(end - file_->data()), 1) || *end != std::byte{0}) {
    file_->mark_damaged();
    return {};
  }
  return out;
}

FlatTable FlatVector::table(uint32_t index) const noexcept {
  const uint64_t at = at_ + uint64_t{index} * 4;
  return {file_, at + file_->read<uint32_t>(at)};
}

}  // namespace weir::engine
