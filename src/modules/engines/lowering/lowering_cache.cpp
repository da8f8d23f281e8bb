// Loads cache files only after checks; stores them under a temporary name and renames them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lowering/lowering_cache.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "environment.hpp"
#include "lowering/sha256.hpp"

namespace weir::engine {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMark = "WEIRLOW1";
constexpr int64_t kMostBytes = int64_t{1} << 31;

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  explicit operator bool() const { return number_ >= 0; }
  int get() const { return number_; }

 private:
  int number_;
};

std::string cache_folder() {
  const auto absolute = [](const char* path) { return path && path[0] == '/'; };
  if (const char* chosen = environment_variable("XDG_CACHE_HOME"); absolute(chosen))
    return std::string(chosen) + "/weir/lowered";
  const char* home = environment_variable("HOME");
  return absolute(home) ? std::string(home) + "/.cache/weir/lowered" : "";
}

bool is_ours_alone(const struct stat& status) {
  return status.st_uid == geteuid() && (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

bool read_all(int file, std::string* out) {
  for (size_t at = 0; at < out->size();) {
    const ssize_t got = read(file, out->data() + at, out->size() - at);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    at += static_cast<size_t>(got);
  }
  return true;
}

bool write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t put = write(file, bytes.data(), bytes.size());
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return false;
    bytes.remove_prefix(static_cast<size_t>(put));
  }
  return true;
}

std::string digest_of(std::string_view bytes) {
  const Digest digest = sha256(std::as_bytes(std::span(bytes)));
  return {reinterpret_cast<const char*>(digest.data()), digest.size()};
}

// The graph in a file of the cache; nullopt: the file was truncated or changed.
std::optional<std::string> read_graph(int file, int64_t size) {
  constexpr auto kHead = static_cast<int64_t>(kMark.size() + sizeof(Digest));
  if (size < kHead || size > kMostBytes) return std::nullopt;
  std::string bytes(static_cast<size_t>(size), '\0');
  const std::string_view whole = bytes;
  if (!read_all(file, &bytes) || !whole.starts_with(kMark) ||
      whole.substr(kMark.size(), sizeof(Digest)) != digest_of(whole.substr(kHead)))
    return std::nullopt;
  return bytes.substr(kHead);
}

}  // namespace

LoweringCache::LoweringCache(std::span<const std::byte> made_of) : folder_(cache_folder()) {
  if (!folder_.empty()) path_ = folder_ + "/" + hexadecimal(sha256(made_of)) + ".onnx";
}

std::optional<std::string> LoweringCache::load(std::string* complaint) const {
  if (path_.empty()) return std::nullopt;
  struct stat status {};
  if (lstat(folder_.c_str(), &status) != 0) return std::nullopt;
  if (!S_ISDIR(status.st_mode) || !is_ours_alone(status)) {
    *complaint = folder_ + " is accessible to other users";
    return std::nullopt;
  }
  const Descriptor file(open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  if (!file && errno == ENOENT) return std::nullopt;
  if (!file || fstat(file.get(), &status) != 0) {
    *complaint = path_ + ": " + std::strerror(errno);
    return std::nullopt;
  }
  if (!S_ISREG(status.st_mode) || !is_ours_alone(status)) {
    *complaint = path_ + " is accessible to other users";
    return std::nullopt;
  }
  auto graph = read_graph(file.get(), status.st_size);
  if (!graph) *complaint = path_ + " was truncated or changed";
  return graph;
}

bool LoweringCache::store(const std::string& graph) const {
  if (path_.empty()) return false;
  std::error_code failed;
  const bool made = fs::create_directories(folder_, failed);
  if (failed) return false;
  if (made) fs::permissions(folder_, fs::perms::owner_all, failed);
  struct stat status {};
  if (lstat(folder_.c_str(), &status) != 0 || !S_ISDIR(status.st_mode) || !is_ours_alone(status))
    return false;
  std::string beside = path_ + ".XXXXXX";
  const Descriptor file(mkostemp(beside.data(), O_CLOEXEC));  // mode 0600
  if (!file) return false;
  const bool written = write_all(file.get(), kMark) && write_all(file.get(), digest_of(graph)) &&
                       write_all(file.get(), graph);
  if (written && rename(beside.c_str(), path_.c_str()) == 0) return true;
  unlink(beside.c_str());
  return false;
}

}  // namespace weir::engine
