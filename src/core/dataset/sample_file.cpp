// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/dataset/sample_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>

#include "core/text/shell_quote.hpp"

namespace weir::dataset {
namespace {

constexpr mode_t kMode = 0644;
constexpr size_t kOneCall = size_t{1} << 30;  // bytes; Linux transfers at most 2 GiB - 4096

std::string text_of(int reason) {
  return std::generic_category().message(reason);
}

Error not_read(const std::string& what, const std::string& path, const std::string& reason) {
  return Error{.code = Code::FILE_NOT_FOUND,
               .what = "the file of " + what + " cannot be read: " + reason,
               .offered = path,
               .needed = "a regular file that can be read",
               .fix = "ls -l " + shell_word(path)};
}

Error not_written(const std::string& what, const std::string& path, int reason) {
  const std::string folder = std::filesystem::path(path).parent_path();
  return Error{.code = Code::FILE_NOT_WRITTEN,
               .what = "the file of " + what + " cannot be written: " + text_of(reason),
               .offered = path,
               .needed = "a folder that exists and can be written, with space for the file",
               .fix = reason == ENOENT && !folder.empty()
                          ? "mkdir -p " + shell_word(folder)
                          : "df -h " + shell_word(folder.empty() ? "." : folder)};
}

// Calls `f` again if a signal interrupts it.
template <class F>
auto without_interruption(F&& f) {
  auto out = f();
  while (out < 0 && errno == EINTR) out = f();
  return out;
}

}  // namespace

Result<SampleFile> SampleFile::open(const std::string& what, const std::string& path) {
  SampleFile out;
  out.path_ = path;
  out.file_ = io::Descriptor(without_interruption(
      [&] { return ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK); }));
  struct stat about {};
  if (!out.file_ || fstat(out.file_.get(), &about) < 0) return not_read(what, path, text_of(errno));
  if (!S_ISREG(about.st_mode))
    return not_read(what, path,
                    S_ISDIR(about.st_mode) ? "it is a folder" : "it is no regular file");
  out.bytes_ = static_cast<uint64_t>(about.st_size);
  return out;
}

Status SampleFile::read(uint64_t offset, std::span<std::byte> out) const {
  const uint64_t end = offset + out.size();
  if (end < offset || end > INT64_MAX)
    return Error{.code = Code::SAMPLES_INVALID,
                 .what = "a sample lies beyond the end of any file",
                 .offered = path_ + ": offset " + std::to_string(offset)};
  while (!out.empty()) {
    const ssize_t got = without_interruption([&] {
      return pread(file_.get(), out.data(), std::min(out.size(), kOneCall),
                   static_cast<off_t>(offset));
    });
    if (got < 0) return not_read("the samples", path_, text_of(errno));
    if (got == 0)
      return Error{.code = Code::SAMPLES_INVALID,
                   .what = "a sample is cut off by the end of the file",
                   .offered = path_ + ": " + std::to_string(offset) + " bytes",
                   .needed = std::to_string(end) + " bytes",
                   .fix = "record the file again, or set stop-sample-index to a complete sample"};
    offset += static_cast<uint64_t>(got);
    out = out.subspan(static_cast<size_t>(got));
  }
  return ok();
}

Result<SampleWriter> SampleWriter::create(const std::string& what, const std::string& path) {
  SampleWriter out;
  out.what_ = what;
  out.path_ = path;
  out.file_ = io::Descriptor(without_interruption(
      [&] { return ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kMode); }));
  if (!out.file_) return out.error_of_system(errno);
  return out;
}

Error SampleWriter::error_of_system(int reason) const {
  return not_written(what_, path_, reason);
}

Status SampleWriter::append(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = without_interruption(
        [&] { return ::write(file_.get(), bytes.data(), std::min(bytes.size(), kOneCall)); });
    if (written < 0) return error_of_system(errno);
    bytes_ += static_cast<uint64_t>(written);
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
  return ok();
}

void SampleWriter::cut(uint64_t bytes) noexcept {
  const auto length = static_cast<off_t>(bytes);
  if (ftruncate(file_.get(), length) == 0 && lseek(file_.get(), length, SEEK_SET) == length)
    bytes_ = bytes;
}

Status SampleWriter::close() {
  // Linux closes the descriptor also if it reports EINTR.
  if (file_ && ::close(file_.release()) < 0 && errno != EINTR) return error_of_system(errno);
  return ok();
}

Result<std::string> read_text(const std::string& what, const std::string& path, uint64_t limit) {
  const auto file = SampleFile::open(what, path);
  if (!file) return file.error();
  if (file->bytes() > limit)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "the file of " + what + " is too long",
                 .offered = path + ": " + std::to_string(file->bytes()) + " bytes",
                 .needed = "at most " + std::to_string(limit) + " bytes",
                 .fix = "record fewer samples into one file"};
  std::string text(file->bytes(), '\0');
  if (auto status = file->read(0, std::as_writable_bytes(std::span(text))); !status)
    return status.error();
  return text;
}

Status write_text(const std::string& what, const std::string& path, std::string_view text) {
  auto file = SampleWriter::create(what, path);
  if (!file) return file.error();
  if (auto status = file->append(std::as_bytes(std::span(text))); !status) return status;
  return file->close();
}

Status check_writable(const std::string& what, const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const auto folder = fs::path(path).parent_path();
  const bool exists = fs::exists(path, ignored);
  if (exists && fs::is_directory(path, ignored)) return not_written(what, path, EISDIR);
  const std::string asked = exists ? path : folder.empty() ? "." : folder.string();
  if (access(asked.c_str(), W_OK) < 0) return not_written(what, path, errno);
  if (!exists && !fs::is_directory(asked, ignored)) return not_written(what, path, ENOTDIR);
  return ok();
}

}  // namespace weir::dataset
