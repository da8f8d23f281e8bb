// Counts, types, shapes and sizes of a converter's tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/converted_frame.hpp"

#include <algorithm>
#include <string>

namespace weir::infer {
namespace {

Error fault(const std::string& who, const char* what, std::string offered, std::string needed) {
  return Error{Code::CALLBACK_FAILED, who + what, std::move(offered),
               std::move(needed),     "",         "mend " + who};
}

}  // namespace

Status ConverterRoom::check_memory(const TensorSpec& spec, const weir_tensor& tensor) const {
  const bool dense = std::all_of(std::begin(tensor.stride), std::end(tensor.stride),
                                 [](auto s) { return s == 0; });
  if (!tensor.data || tensor.memory_kind != WEIR_MEMORY_HOST || tensor.offset != 0 || !dense)
    return fault(who_, " made a tensor that is not dense in host memory",
                 spec.to_string() + (tensor.data ? "" : ", data is NULL"),
                 "data, no offset, no strides");
  if (tensor.bytes != spec.bytes())
    return fault(who_, " made a tensor of another size than it says",
                 std::to_string(tensor.bytes) + " bytes",
                 std::to_string(spec.bytes().value_or(0)) + " bytes for " + spec.to_string());
  return ok();
}

Result<TensorSpec> spec_of(const std::string& who, const weir_tensor_info& info) {
  const auto refused = [&who](const std::string& offered) {
    return fault(
        who, " describes a tensor that cannot be", offered,
        "a type, a rank of at most 16, dimensions of 1 to 4294967295, less than 2^63 bytes");
  };
  if (info.type >= WEIR_TYPE_END || info.rank > WEIR_RANK_LIMIT)
    return refused("type " + std::to_string(info.type) + ", rank " + std::to_string(info.rank));
  TensorSpec spec{static_cast<ElementType>(info.type), Shape{1}, ""};
  for (uint32_t i = 0; i < info.rank; ++i) {
    const int64_t extent = info.shape[info.rank - 1 - i];
    if (extent < 1 || extent > UINT32_MAX)
      return refused("a dimension of " + std::to_string(extent));
    spec.shape[i] = static_cast<uint32_t>(extent);
  }
  if (!spec.bytes()) return refused(spec.to_string());
  return spec;
}

weir_frame* ConverterRoom::prepare(const weir_frame& in) {
  frame_ = in;
  frame_.struct_size = sizeof frame_;
  frame_.tensors = tensors_.data();
  frame_.n_tensors = WEIR_TENSOR_LIMIT;
  return &frame_;
}

void ConverterRoom::release() noexcept {
  for (auto& tensor : tensors_) {
    if (tensor.release) tensor.release(tensor.owner);
    tensor = {};
  }
}

Result<ConvertedFrame> ConverterRoom::take(int result, weir_error* error) {
  auto out = checked(result, error);
  release();
  return out;
}

Error ConverterRoom::give_up(Error error) noexcept {
  release();
  return error;
}

Result<ConvertedFrame> ConverterRoom::checked(int result, weir_error* error) {
  if (result < 0) return take_error(error, result, who_ + " failed on a frame");
  ConvertedFrame out;
  out.pts = frame_.pts;
  out.duration = frame_.duration;
  if (result > 0) return out;
  const size_t count = frame_.n_tensors;
  if (count == 0 || count > WEIR_TENSOR_LIMIT || frame_.tensors != tensors_.data())
    return fault(who_, " made no tensors, or more than there is room for", std::to_string(count),
                 "1 to 256, in the room that it was given");
  for (size_t i = 0; i < count; ++i) {
    const auto spec = spec_of(who_, tensors_[i].info);
    if (!spec) return spec.error();
    if (auto status = check_memory(*spec, tensors_[i]); !status) return status.error();
    out.tensors.emplace_back(*spec, std::exchange(tensors_[i], weir_tensor{}));
  }
  return out;
}

}  // namespace weir::infer
