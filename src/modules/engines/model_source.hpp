// ModelSource: reads parts of the one model that a weir_open names.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::engine {

// Reads a file with pread() instead of mapping it, so that truncation is an error and not a signal.
// Thread-safe except for moves.
class ModelSource {
 public:
  static constexpr uint64_t kKeptBytes = uint64_t{64} << 20;

  // MODEL_NOT_FOUND for a missing or non-regular file; MODEL_INVALID for an empty file;
  // SPEC_MISMATCH unless there is exactly one model.
  static Result<ModelSource> open(const weir_open& request);
  // Reads bytes in memory, which must outlive it.
  explicit ModelSource(std::span<const std::byte> bytes) : bytes_(bytes), size_(bytes.size()) {}
  ModelSource(ModelSource&& other) noexcept;
  ModelSource& operator=(ModelSource&& other) = delete;
  ~ModelSource();

  // Reads the file into memory if it has at most kKeptBytes: later reads return the same bytes even
  // if the file changes. False when it was truncated meanwhile; true without effect for a larger
  // file, of which a copy would cost too much memory.
  bool keep_small();

  uint64_t size() const noexcept { return size_; }
  const std::string& path() const noexcept { return path_; }  // "" for bytes in memory
  std::string name() const { return path_.empty() ? "the model given as bytes" : path_; }
  // The bytes in memory; empty for a file that is not kept.
  std::span<const std::byte> memory() const noexcept { return bytes_; }
  // Fills `out` with the bytes at offset `at`. False unless all of them exist.
  bool read(uint64_t at, std::span<std::byte> out) const noexcept;

 private:
  ModelSource(std::string path, int file, uint64_t size)
      : path_(std::move(path)), file_(file), size_(size) {}

  std::string path_;
  int file_ = -1;
  std::vector<std::byte> kept_;
  std::span<const std::byte> bytes_;  // of `kept_`, or the caller's
  uint64_t size_ = 0;
};

}  // namespace weir::engine
