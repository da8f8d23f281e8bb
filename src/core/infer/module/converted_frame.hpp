// Validates the tensors that a converter made of one frame before they are used.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/infer/module/host.hpp"
#include "core/tensor/frame_spec.hpp"

namespace weir::infer {

// One tensor allocated by a converter; released with this object unless taken.
class ConvertedTensor {
 public:
  ConvertedTensor(TensorSpec spec, const weir_tensor& memory)
      : spec_(std::move(spec)), memory_(memory) {}
  ConvertedTensor(ConvertedTensor&& other) noexcept
      : spec_(std::move(other.spec_)), memory_(std::exchange(other.memory_, weir_tensor{})) {}
  ConvertedTensor& operator=(ConvertedTensor&&) = delete;
  ~ConvertedTensor() {
    if (memory_.release) memory_.release(memory_.owner);
  }

  const TensorSpec& spec() const noexcept { return spec_; }
  // Borrowed: dense, in host memory, of the size of the spec; flexible: with its header. Without
  // `release` it belongs to the converter and is valid until the next call.
  const weir_tensor& memory() const noexcept { return memory_; }
  // Transfers ownership: the caller must release the memory.
  weir_tensor take() noexcept { return std::exchange(memory_, weir_tensor{}); }

 private:
  TensorSpec spec_;
  weir_tensor memory_;
};

struct ConvertedFrame {
  std::vector<ConvertedTensor> tensors;  // empty: the converter drops the frame
  int64_t pts = -1, duration = -1;       // ns, -1 = none
  std::optional<Fraction> rate;          // if the frame carries one
  bool is_flexible = false;              // each tensor's memory begins with its header
};

// Converts the tensor description of the converter `who`. CALLBACK_FAILED if it is unknown or
// exceeds the limits.
Result<TensorSpec> to_spec(const std::string& who, const weir_tensor_info& info);

// The output arrays that a converter fills. One frame at a time.
class ConverterRoom {
 public:
  // `who` is the subject of errors: "the converter numbers".
  explicit ConverterRoom(std::string who) : who_(std::move(who)), tensors_(WEIR_TENSOR_LIMIT) {}
  ~ConverterRoom() { release(); }
  ConverterRoom(const ConverterRoom&) = delete;
  ConverterRoom& operator=(const ConverterRoom&) = delete;

  // A frame with space for the maximum number of tensors and the time of `in`.
  weir_frame* prepare(const weir_frame& in);
  // Returns the tensors after convert() returned `result` and possibly filled `error`; releases
  // unused memory. In a flexible frame, headers that agree with the specs precede the payloads.
  Result<ConvertedFrame> take(int result, weir_error* error, bool is_flexible = false);
  // Releases everything after a call without a result, and returns `error`.
  Error discard(Error error) noexcept;

 private:
  Result<ConvertedFrame> checked(int result, weir_error* error, bool is_flexible);
  void release() noexcept;
  Status check_memory(const TensorSpec& spec, const weir_tensor& tensor, bool is_flexible) const;

  const std::string who_;
  std::vector<weir_tensor> tensors_;
  weir_frame frame_{};
};

}  // namespace weir::infer
