// Reads and writes the files of samples at any offset, without loading them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "machine/descriptor.hpp"
#include "weir/result.hpp"

namespace weir::dataset {

// A regular file that is read. Errors name the file and the reason of the system.
class SampleFile {
 public:
  SampleFile() = default;
  // `what` is the property that names the file. FILE_NOT_FOUND; does not wait for a FIFO.
  static Result<SampleFile> open(const std::string& what, const std::string& path);
  uint64_t bytes() const noexcept { return bytes_; }  // when it was opened
  // Fills `out` from `offset` on. FILE_NOT_FOUND if it cannot be read, SAMPLES_INVALID if the file
  // ends before.
  Status read(uint64_t offset, std::span<std::byte> out) const;

 private:
  std::string path_;
  io::Descriptor file_;
  uint64_t bytes_ = 0;
};

// A file that is created, or truncated, and then appended to.
class SampleWriter {
 public:
  SampleWriter() = default;
  // Mode 0644, which the umask of the process may restrict. FILE_NOT_WRITTEN.
  static Result<SampleWriter> create(const std::string& what, const std::string& path);
  explicit operator bool() const noexcept { return static_cast<bool>(file_); }
  uint64_t bytes() const noexcept { return bytes_; }
  // FILE_NOT_WRITTEN, for example when the disk is full.
  Status append(std::span<const std::byte> bytes);
  // Removes what follows the first `bytes` bytes: an incomplete sample.
  void cut(uint64_t bytes) noexcept;
  // FILE_NOT_WRITTEN if the system reports only now that a write has failed.
  Status close();

 private:
  Error error_of_system(int reason) const;

  std::string what_, path_;
  io::Descriptor file_;
  uint64_t bytes_ = 0;
};

// Reads a whole text of at most `limit` bytes. FILE_NOT_FOUND, LIMIT_EXCEEDED.
Result<std::string> read_text(const std::string& what, const std::string& path, uint64_t limit);
// Creates or replaces the file. FILE_NOT_WRITTEN.
Status write_text(const std::string& what, const std::string& path, std::string_view text);
// FILE_NOT_WRITTEN if write_text() could not create the file, as far as can be seen without it.
Status check_writable(const std::string& what, const std::string& path);

}  // namespace weir::dataset
