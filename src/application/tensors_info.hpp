// TensorsInfo: tensor descriptions as a program of the C API sets them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <mutex>
#include <optional>
#include <string>
#include <utility>
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
  // A plain info reads four dimensions, an extended one all.
  enum class Reads { FourDimensions, AllDimensions };
  static constexpr size_t kPlainRank = 4;

  // Extended if a tensor has more than four dimensions.
  explicit TensorsInfo(TensorSpecs tensors) { set(std::move(tensors), std::nullopt); }
  explicit TensorsInfo(Reads reads) : reads_(reads) {}
  const char* kind() const noexcept override { return kKind; }

  TensorSpecs tensors() const {
    std::lock_guard lock(mutex_);
    return {tensors_.begin(), tensors_.begin() + static_cast<std::ptrdiff_t>(count_)};
  }
  Reads reads() const {
    std::lock_guard lock(mutex_);
    return reads_;
  }
  // nullopt: as the tensors need.
  void set(TensorSpecs tensors, std::optional<Reads> reads);
  // Keeps the tensors beyond a lower count for a higher one.
  void set_count(size_t count) {
    std::lock_guard lock(mutex_);
    if (count > tensors_.size()) tensors_.resize(count);
    count_ = count;
  }
  // Runs `body` with tensor `index`. OPTION_VALUE: out of range.
  template <class Body>
  Status with(size_t index, Body&& body) {
    std::lock_guard lock(mutex_);
    if (index >= count_) return beyond(index, count_);
    body(tensors_[index]);
    return ok();
  }

 private:
  static Error beyond(size_t index, size_t count);

  mutable std::mutex mutex_;  // guards the rest
  TensorSpecs tensors_;
  size_t count_ = 0;
  Reads reads_ = Reads::FourDimensions;
};

Error no_such_tensor(std::string index, size_t count);
void* new_info(TensorSpecs tensors);
// Returns the tensors of the info; none if the handle is NULL.
Result<TensorSpecs> tensors_or_none(void* info, const char* what);

}  // namespace weir::application
