// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/shared_block.hpp"

#include <fcntl.h>
#include <sys/mman.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

namespace weir::isolate {
namespace {

constexpr size_t kMaxBytes = size_t{1} << 40;

Error no_memory(size_t bytes, const char* step) {
  return Error{.code = Code::OUT_OF_MEMORY,
               .what = "no shared memory for a worker process",
               .offered = std::to_string(bytes) + " bytes: " + step + ": " + std::strerror(errno),
               .needed = "free memory and file descriptors"};
}

}  // namespace

Mapping::Mapping(int descriptor, size_t bytes, bool writable) noexcept {
  void* at = mmap(nullptr, bytes, writable ? PROT_READ | PROT_WRITE : PROT_READ,
                  MAP_SHARED | MAP_POPULATE, descriptor, 0);
  if (at == MAP_FAILED) return;
  data_ = static_cast<std::byte*>(at);
  bytes_ = bytes;
}

Mapping::Mapping(Mapping&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), bytes_(other.bytes_) {}

Mapping& Mapping::operator=(Mapping&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(bytes_, other.bytes_);
  return *this;
}

Mapping::~Mapping() {
  if (data_) munmap(data_, bytes_);
}

Result<std::shared_ptr<SharedBlock>> SharedBlock::create(size_t bytes, Sharing sharing) {
  static std::atomic<uint64_t> last_id{0};
  if (bytes > kMaxBytes) {
    errno = EFBIG;
    return no_memory(bytes, "size");
  }
  const size_t size = bytes == 0 ? kPage : (bytes + kPage - 1) / kPage * kPage;
  std::shared_ptr<SharedBlock> block(new SharedBlock);
  block->descriptor_ = io::Descriptor(memfd_create("weir", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  const int descriptor = block->descriptor_.get();
  if (descriptor < 0) return no_memory(size, "memfd_create");
  // Allocate now: a page missing later would kill the process that touches it.
  if (const int failed = posix_fallocate(descriptor, 0, static_cast<off_t>(size))) {
    errno = failed;
    return no_memory(size, "posix_fallocate");
  }
  block->mapping_ = Mapping(descriptor, size, true);
  if (!block->mapping_) return no_memory(size, "mmap");
  int seals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;
  if (sharing == Sharing::ReadByWorker) seals |= F_SEAL_FUTURE_WRITE;
  if (fcntl(descriptor, F_ADD_SEALS, seals) != 0) return no_memory(size, "F_ADD_SEALS");
  block->id_ = ++last_id;
  block->sharing_ = sharing;
  return block;
}

}  // namespace weir::isolate
