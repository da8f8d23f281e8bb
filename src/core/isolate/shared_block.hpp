// SharedBlock: memory shared between this process and a worker process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>

#include "machine/descriptor.hpp"
#include "weir/result.hpp"

namespace weir::isolate {

// Pages mapped for the lifetime of the object.
class Mapping {
 public:
  Mapping() = default;
  // False if the kernel refuses.
  Mapping(int descriptor, size_t bytes, bool writable) noexcept;
  Mapping(Mapping&& other) noexcept;
  Mapping& operator=(Mapping&& other) noexcept;
  ~Mapping();
  explicit operator bool() const noexcept { return data_ != nullptr; }
  std::byte* data() const noexcept { return data_; }
  size_t bytes() const noexcept { return bytes_; }

 private:
  std::byte* data_ = nullptr;
  size_t bytes_ = 0;
};

enum class Sharing {
  ReadByWorker,    // only this process can ever write it
  WrittenByWorker  // results
};

// A memfd of fixed size, sealed so that the worker cannot truncate it.
class SharedBlock {
 public:
  static constexpr size_t kPage = 4096;
  // At least `bytes`, rounded up to pages that are allocated immediately. OUT_OF_MEMORY.
  static Result<std::shared_ptr<SharedBlock>> create(size_t bytes, Sharing sharing);

  std::byte* data() const noexcept { return mapping_.data(); }
  size_t bytes() const noexcept { return mapping_.bytes(); }
  uint64_t id() const noexcept { return id_; }  // unique in this process
  int descriptor() const noexcept { return descriptor_.get(); }
  Sharing sharing() const noexcept { return sharing_; }

 private:
  SharedBlock() = default;
  io::Descriptor descriptor_;
  Mapping mapping_;
  uint64_t id_ = 0;
  Sharing sharing_ = Sharing::ReadByWorker;
};

}  // namespace weir::isolate
