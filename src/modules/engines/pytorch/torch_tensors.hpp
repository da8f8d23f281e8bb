// Converts between tensors of Weir and libtorch. Only torch_program.cpp includes this.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <ATen/ATen.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tensor_check.hpp"
#include "weir/engine_tools.hpp"

namespace weir::engine {

// libtorch 1.13 has no unsigned integers wider than 8 bits.
inline std::optional<at::ScalarType> to_torch(uint32_t type) noexcept {
  switch (type) {
    case WEIR_INT32:
      return at::kInt;
    case WEIR_INT16:
      return at::kShort;
    case WEIR_INT8:
      return at::kChar;
    case WEIR_UINT8:
      return at::kByte;
    case WEIR_FLOAT64:
      return at::kDouble;
    case WEIR_FLOAT32:
      return at::kFloat;
    case WEIR_INT64:
      return at::kLong;
    case WEIR_FLOAT16:
      return at::kHalf;
    default:
      return std::nullopt;
  }
}

inline std::optional<uint32_t> from_torch(at::ScalarType type) noexcept {
  for (uint32_t weir = 0; weir < WEIR_TYPE_END; ++weir)
    if (to_torch(weir) == type) return weir;
  if (type == at::kBool) return WEIR_UINT8;  // one byte per value, 0 or 1
  return std::nullopt;
}

inline Error no_such_type(const weir_tensor_info& info) {
  return Error{.code = Code::SPEC_MISMATCH,
               .what = "libtorch has no tensors of this element type",
               .offered = describe(info),
               .needed = "int8, uint8, int16, int32, int64, float16, float32 or float64",
               .fix = "tensor_transform mode=typecast option=float32 ! tensor_filter"};
}

// Describes a libtorch tensor, whose layout must be strided.
inline Result<weir_tensor_info> torch_info(const at::Tensor& tensor) {
  weir_tensor_info info = open_tensor_info();
  const auto type = from_torch(tensor.scalar_type());
  if (!type)
    return unsupported_type("an output", c10::toString(tensor.scalar_type()),
                            "convert it within the model: y.to(torch.float32)");
  if (tensor.dim() > WEIR_RANK_LIMIT) return unsupported_rank("an output", tensor.dim());
  info.type = *type;
  set_shape(&info, tensor.sizes().begin(), static_cast<size_t>(tensor.dim()));
  return info;
}

// Makes a tensor dense; oneDNN layouts, sparse and quantised tensors become plain values.
inline at::Tensor dense(const at::Tensor& given) {
  at::Tensor tensor = given.is_quantized() ? given.dequantize() : given;
  if (tensor.layout() != at::kStrided) tensor = tensor.to_dense();
  if (tensor.is_conj() || tensor.is_neg()) tensor = tensor.resolve_conj().resolve_neg();
  return tensor.contiguous();
}

inline bool is_within(const void* data, std::span<const weir_tensor> tensors) {
  const auto* at = static_cast<const std::byte*>(data);
  return std::any_of(tensors.begin(), tensors.end(), [at](const weir_tensor& tensor) {
    const auto* begin = static_cast<const std::byte*>(tensor.data);
    return begin && at >= begin && at < begin + tensor.bytes;
  });
}

// Writes into the given memory, or hands over libtorch's. The latter is copied if it also belongs
// to an input, a weight or another output.
inline Status hand_over(const at::Tensor& tensor, size_t index, std::span<const weir_tensor> inputs,
                        weir_tensor* out) {
  auto info = torch_info(tensor);
  if (!info) return info.error();
  const uint64_t bytes = tensor.nbytes();
  const bool only_ours = tensor.has_storage() && tensor.storage().use_count() == 1 &&
                         !is_within(tensor.data_ptr(), inputs);
  if (out->data || !only_ours || bytes == 0)
    return write_output(*info, tensor.data_ptr(), index, out);
  info->name = out->info.name;
  out->info = *info;
  auto owner = std::make_unique<at::Tensor>(tensor);
  out->data = owner->data_ptr();
  out->bytes = out->capacity = bytes;
  out->release = [](void* kept) { delete static_cast<at::Tensor*>(kept); };
  out->owner = owner.release();
  return ok();
}

}  // namespace weir::engine
