// What a converter made of one frame: checked before anything of it is believed.
#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/infer/host.hpp"
#include "core/tensor/frame_spec.hpp"

namespace weir::infer {

// One tensor that a converter allocated; released with it unless it was taken.
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
  // Borrowed: dense, in host memory, as long as the spec says. Without `release` it is the
  // converter's own and lives until it is called again.
  const weir_tensor& memory() const noexcept { return memory_; }
  // The caller releases it then.
  weir_tensor take() noexcept { return std::exchange(memory_, weir_tensor{}); }

 private:
  TensorSpec spec_;
  weir_tensor memory_;
};

struct ConvertedFrame {
  std::vector<ConvertedTensor> tensors;  // none: the converter drops the frame
  int64_t pts = -1, duration = -1;       // ns, -1 = none
  std::optional<Fraction> rate;          // where the frame says its own
};

// What the converter `who` says of a tensor, as ours. CALLBACK_FAILED when it is beyond the limits
// or not known.
Result<TensorSpec> spec_of(const std::string& who, const weir_tensor_info& info);

// The room that a converter fills. One frame at a time.
class ConverterRoom {
 public:
  // `who` made the tensors, in errors: "the converter numbers".
  explicit ConverterRoom(std::string who) : who_(std::move(who)), tensors_(WEIR_TENSOR_LIMIT) {}
  ~ConverterRoom() { release(); }
  ConverterRoom(const ConverterRoom&) = delete;
  ConverterRoom& operator=(const ConverterRoom&) = delete;

  // A frame with room for every tensor and the time of `in`.
  weir_frame* prepare(const weir_frame& in);
  // What was filled, where convert() returned `result` and maybe filled `error`; the rest is
  // released.
  Result<ConvertedFrame> take(int result, weir_error* error);
  // After a call that has no result: `error`, and everything is released.
  Error give_up(Error error) noexcept;

 private:
  Result<ConvertedFrame> checked(int result, weir_error* error);
  void release() noexcept;
  Status check_memory(const TensorSpec& spec, const weir_tensor& tensor) const;

  const std::string who_;
  std::vector<weir_tensor> tensors_;
  weir_frame frame_{};
};

}  // namespace weir::infer
