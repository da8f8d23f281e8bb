// ModelSource: reads parts of the one model that a weir_open names.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::engine {

// Reads a file with pread() instead of mapping it, so that truncation is an error and not a signal.
// Thread-safe except for moves.
class ModelSource {
 public:
  // MODEL_NOT_FOUND for a missing or non-regular file; MODEL_INVALID for an empty file;
  // SPEC_MISMATCH unless there is exactly one model.
  static Result<ModelSource> open(const weir_open& request);
  // Reads bytes in memory, which must outlive it.
  explicit ModelSource(std::span<const std::byte> bytes) : bytes_(bytes), size_(bytes.size()) {}
  ModelSource(ModelSource&& other) noexcept;
  ModelSource& operator=(ModelSource&& other) = delete;
  ~ModelSource();

  uint64_t size() const noexcept { return size_; }
  const std::string& path() const noexcept { return path_; }  // "" for bytes in memory
  std::string name() const { return path_.empty() ? "the model given as bytes" : path_; }
  // The bytes in memory; empty for a file.
  std::span<const std::byte> memory() const noexcept { return bytes_; }
  // Fills `out` with the bytes at offset `at`. False unless all of them exist.
  bool read(uint64_t at, std::span<std::byte> out) const noexcept;

 private:
  ModelSource(std::string path, int file, uint64_t size)
      : path_(std::move(path)), file_(file), size_(size) {}

  std::string path_;
  int file_ = -1;
  std::span<const std::byte> bytes_;
  uint64_t size_ = 0;
};

}  // namespace weir::engine
