// SPDX-License-Identifier: LGPL-2.1-or-later
#include "model_source.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace weir::engine {
namespace {

Error not_found(const std::string& path, const std::string& why) {
  return Error{.code = Code::MODEL_NOT_FOUND,
               .what = "the model file cannot be read",
               .offered = path + ": " + why,
               .needed = "a regular file that this user may read",
               .difference = {},
               .fix = {}};
}

}  // namespace

Result<ModelSource> ModelSource::open(const weir_open& request) {
  if (request.n_models == 0 && request.bytes && request.n_bytes > 0)
    return ModelSource(std::span(static_cast<const std::byte*>(request.bytes), request.n_bytes));
  if (request.n_models != 1 || !request.paths || !request.paths[0])
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "this engine accepts exactly one model file",
                 .offered = std::to_string(request.n_models) + " files",
                 .needed = "1 file",
                 .difference = {},
                 .fix = "model=NAME"};
  const std::string path = request.paths[0];
  // O_NONBLOCK: a FIFO without a writer must not block here; it is rejected below.
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return not_found(path, std::strerror(errno));
  ModelSource source(path, file, 0);
  struct stat facts {};
  if (fstat(file, &facts) != 0) return not_found(path, std::strerror(errno));
  if (!S_ISREG(facts.st_mode)) return not_found(path, "not a regular file");
  source.size_ = static_cast<uint64_t>(facts.st_size);
  if (source.size_ == 0)
    return Error{.code = Code::MODEL_INVALID,
                 .what = "the model file is empty",
                 .offered = path,
                 .needed = "a model",
                 .difference = {},
                 .fix = {}};
  return source;
}

ModelSource::ModelSource(ModelSource&& other) noexcept
    : path_(std::move(other.path_)),
      file_(std::exchange(other.file_, -1)),
      kept_(std::move(other.kept_)),
      bytes_(other.bytes_),
      size_(other.size_) {}

ModelSource::~ModelSource() {
  if (file_ >= 0) close(file_);
}

bool ModelSource::keep_small() {
  if (file_ < 0 || size_ > kKeptBytes) return true;
  std::vector<std::byte> content(size_);
  if (!read(0, content)) return false;
  kept_ = std::move(content);
  bytes_ = kept_;
  close(std::exchange(file_, -1));
  return true;
}

bool ModelSource::read(uint64_t at, std::span<std::byte> out) const noexcept {
  if (at > size_ || out.size() > size_ - at) return false;
  if (file_ < 0) {
    std::copy_n(bytes_.begin() + static_cast<ptrdiff_t>(at), out.size(), out.begin());
    return true;
  }
  while (!out.empty()) {
    const ssize_t got = pread(file_, out.data(), out.size(), static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    at += static_cast<uint64_t>(got);
    out = out.subspan(static_cast<size_t>(got));
  }
  return true;
}

}  // namespace weir::engine
