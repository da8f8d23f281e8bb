// ModelSource: the one model that a weir_open names, read in pieces.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::engine {

// A file is read with pread(), never mapped: one that is cut meanwhile is an error, not a signal.
// Thread-safe but for moves.
class ModelSource {
 public:
  // MODEL_NOT_FOUND for a file that is missing or not a regular one; MODEL_INVALID for an empty
  // file; SPEC_MISMATCH unless there is exactly one model.
  static Result<ModelSource> open(const weir_open& request);
  // Of bytes in memory, which outlive it.
  explicit ModelSource(std::span<const std::byte> bytes) : bytes_(bytes), size_(bytes.size()) {}
  ModelSource(ModelSource&& other) noexcept;
  ModelSource& operator=(ModelSource&& other) = delete;
  ~ModelSource();

  uint64_t size() const noexcept { return size_; }
  const std::string& path() const noexcept { return path_; }  // "" for bytes in memory
  std::string name() const { return path_.empty() ? "the model given as bytes" : path_; }
  // The bytes in memory; empty for a file.
  std::span<const std::byte> memory() const noexcept { return bytes_; }
  // Fills `out` with the bytes from `at` on. False when they are not all there.
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
