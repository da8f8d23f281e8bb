// TensorsData: memory of tensors, its own or that of an owner it keeps alive.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "tensors_info.hpp"

namespace weir::application {

class TensorsData : public Object {
 public:
  static constexpr const char* kKind = "tensors data";
  enum class Access { ReadOnly, ReadWrite };

  // Allocates memory set to 0. The specs are complete.
  static std::shared_ptr<TensorsData> create(TensorSpecs tensors);
  // `owner` keeps the `memory` of each tensor alive.
  TensorsData(TensorSpecs tensors, std::vector<std::span<std::byte>> memory,
              std::shared_ptr<const void> owner, Access access)
      : tensors_(std::move(tensors)),
        memory_(std::move(memory)),
        owner_(std::move(owner)),
        access_(access) {}
  const char* kind() const noexcept override { return kKind; }

  const TensorSpecs& tensors() const noexcept { return tensors_; }
  const std::vector<std::span<std::byte>>& memory() const noexcept { return memory_; }
  bool writable() const noexcept { return access_ == Access::ReadWrite; }
  // Describes the tensors for calls of weir/model.h and pipeline.h; valid while this object exists.
  std::vector<weir_tensor> c_tensors() const;

 private:
  TensorSpecs tensors_;
  std::vector<std::span<std::byte>> memory_;
  std::shared_ptr<const void> owner_;
  Access access_;
};

// Tensors of the C ABI whose memory `owner` keeps alive.
std::shared_ptr<TensorsData> make_data(std::span<const weir_tensor> tensors,
                                       std::shared_ptr<const void> owner,
                                       TensorsData::Access access);

// A handle that is valid until the object is destroyed.
class LentHandle {
 public:
  explicit LentHandle(std::shared_ptr<Object> object) : handle_(Handles::all().add(object)) {}
  LentHandle(const LentHandle&) = delete;
  LentHandle& operator=(const LentHandle&) = delete;
  ~LentHandle() { (void)Handles::all().take<Object>(handle_, "handle"); }
  void* get() const noexcept { return handle_; }

 private:
  void* handle_;
};

}  // namespace weir::application
