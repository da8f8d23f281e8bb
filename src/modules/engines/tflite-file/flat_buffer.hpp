// FlatFile, FlatTable, FlatVector: read a FlatBuffers file with every access bounds-checked.
// Layout: the FlatBuffers internals page; offsets are little-endian and relative.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

namespace weir::engine {

class FlatTable;

// A read outside the bytes returns an absent value and marks the file as damaged.
class FlatFile {
 public:
  explicit FlatFile(std::span<const std::byte> bytes) noexcept : bytes_(bytes) {}

  bool damaged() const noexcept { return damaged_; }
  FlatTable root() noexcept;

  // For FlatTable and FlatVector.
  bool holds(uint64_t at, uint64_t count) const noexcept {
    return at <= bytes_.size() && count <= bytes_.size() - at;
  }
  template <class T>
  T read(uint64_t at) noexcept {
    T value{};
    if (holds(at, sizeof value))
      std::memcpy(&value, bytes_.data() + at, sizeof value);
    else
      damaged_ = true;
    return value;
  }
  // Counts visited objects: offsets may all point to the same place, so a small file could
  // otherwise cause endless work.
  void visit(uint64_t count) noexcept {
    visited_ += count;
    if (visited_ > kVisitLimit) damaged_ = true;
  }
  void mark_damaged() noexcept { damaged_ = true; }
  const std::byte* data() const noexcept { return bytes_.data(); }

 private:
  static constexpr uint64_t kVisitLimit = uint64_t{1} << 26;
  std::span<const std::byte> bytes_;
  uint64_t visited_ = 0;
  bool damaged_ = false;
};

// A vector of scalars or of offsets to tables; empty when absent or damaged.
class FlatVector {
 public:
  FlatVector() = default;
  FlatVector(FlatFile* file, uint64_t at, uint32_t size) : file_(file), at_(at), size_(size) {}

  explicit operator bool() const noexcept { return file_ != nullptr; }
  uint32_t size() const noexcept { return size_; }
  // Precondition: index < size().
  template <class T>
  T scalar(uint32_t index) const noexcept {
    return file_->read<T>(at_ + uint64_t{index} * sizeof(T));
  }
  FlatTable table(uint32_t index) const noexcept;
  std::span<const std::byte> bytes() const noexcept {  // only for a vector of bytes
    return file_ ? std::span(file_->data() + at_, size_) : std::span<const std::byte>();
  }
  std::string_view text() const noexcept {  // only for a vector of bytes
    return file_ ? std::string_view(reinterpret_cast<const char*>(file_->data()) + at_, size_)
                 : std::string_view();
  }

 private:
  FlatFile* file_ = nullptr;
  uint64_t at_ = 0;
  uint32_t size_ = 0;
};

// Converts to false, with all fields absent, when the table is absent or damaged.
class FlatTable {
 public:
  FlatTable() = default;
  FlatTable(FlatFile* file, uint64_t at) noexcept;

  explicit operator bool() const noexcept { return file_ != nullptr; }
  template <class T>
  T scalar(uint32_t field, T otherwise) const noexcept {
    const uint64_t at = place(field);
    return at ? file_->read<T>(at) : otherwise;
  }
  FlatTable table(uint32_t field) const noexcept;
  // A vector of elements of `element_bytes` each; 4 for offsets.
  FlatVector vector(uint32_t field, uint32_t element_bytes) const noexcept;
  // A vector of bytes with the terminating zero that readers expect.
  FlatVector string(uint32_t field) const noexcept;

 private:
  bool read_vtable(FlatFile* file, uint64_t at, uint64_t vtable) noexcept;
  uint64_t place(uint32_t field) const noexcept;  // 0 = absent
  uint64_t target(uint32_t field) const noexcept;

  FlatFile* file_ = nullptr;
  uint64_t at_ = 0, vtable_ = 0;
  uint16_t vtable_bytes_ = 0, table_bytes_ = 0;
};

}  // namespace weir::engine
