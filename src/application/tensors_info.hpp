// TensorsInfo: tensor descriptions as a program of the C API sets them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <mutex>
#include <string>
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "handles.hpp"
#include "weir/abi.h"

namespace weir::application {

using TensorSpecs = std::vector<TensorSpec>;

// Checks an info. OPTION_VALUE: no tensors, or one without type or dimensions. LIMIT_EXCEEDED: too
// large.
Status check_complete(const TensorSpecs& tensors, const char* what);
// Compares specs. SPEC_MISMATCH: types or dimensions differ. Names are ignored.
Status check_same(const char* what, const TensorSpecs& offered, const TensorSpecs& needed);
std::string describe(const TensorSpecs& tensors);  // "float32 4:2, uint8 3"

// Shapes are outermost first; unknown parts stay open. The name is valid while `spec` exists.
weir_tensor_info c_info(const TensorSpec& spec);
std::vector<weir_tensor_info> c_infos(const TensorSpecs& tensors);
// Reverses c_info(): open extents become 1; an open rank gives an incomplete spec.
TensorSpec to_spec(const weir_tensor_info& info);

class TensorsInfo : public Object {
 public:
  static constexpr const char* kKind = "tensors info";
  explicit TensorsInfo(TensorSpecs tensors = {}) : tensors_(std::move(tensors)) {}
  const char* kind() const noexcept override { return kKind; }

  TensorSpecs tensors() const {
    std::lock_guard lock(mutex_);
    return tensors_;
  }
  void set(TensorSpecs tensors) {
    std::lock_guard lock(mutex_);
    tensors_ = std::move(tensors);
  }
  void set_count(size_t count) {
    std::lock_guard lock(mutex_);
    tensors_.resize(count);
  }
  // Runs `body` with tensor `index`. OPTION_VALUE: out of range.
  template <class Body>
  Status with(size_t index, Body&& body) {
    std::lock_guard lock(mutex_);
    if (index >= tensors_.size()) return beyond(index, tensors_.size());
    body(tensors_[index]);
    return ok();
  }

 private:
  static Error beyond(size_t index, size_t count);

  mutable std::mutex mutex_;  // guards the rest
  TensorSpecs tensors_;
};

Error no_such_tensor(std::string index, size_t count);
void* new_info(TensorSpecs tensors);
// Returns the tensors of the info; none if the handle is NULL.
Result<TensorSpecs> tensors_or_none(void* info, const char* what);

}  // namespace weir::application
