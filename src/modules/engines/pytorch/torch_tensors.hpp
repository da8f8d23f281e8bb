// Tensors of Weir and of libtorch. Only torch_program.cpp includes this.
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

namespace weir::engine {

// libtorch 1.13 has no unsigned integers of more than 8 bits.
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
  if (type == at::kBool) return WEIR_UINT8;  // a byte of 0 or 1 each
  return std::nullopt;
}

inline Error no_such_type(const weir_tensor_info& info) {
  return Error{Code::SPEC_MISMATCH,
               "libtorch has no tensors of this element type",
               describe(info),
               "int8, uint8, int16, int32, int64, float16, float32 or float64",
               "",
               "tensor_transform mode=typecast option=float32 ! tensor_filter"};
}

// What a tensor of libtorch is; its layout must be strided.
inline Result<weir_tensor_info> torch_info(const at::Tensor& tensor) {
  weir_tensor_info info{};
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  const auto type = from_torch(tensor.scalar_type());
  if (!type)
    return Error{Code::MODEL_UNSUPPORTED,
                 "an output is of a type that streams lack",
                 c10::toString(tensor.scalar_type()),
                 "numbers of 8 to 64 bits, or bool",
                 "",
                 "convert it within the model: y.to(torch.float32)"};
  if (tensor.dim() > WEIR_RANK_LIMIT)
    return Error{Code::MODEL_UNSUPPORTED,
                 "an output has too many dimensions",
                 "rank " + std::to_string(tensor.dim()),
                 "rank 16 at most",
                 "",
                 ""};
  info.type = *type;
  info.rank = static_cast<uint32_t>(tensor.dim());
  std::copy(tensor.sizes().begin(), tensor.sizes().end(), info.shape);
  return info;
}

// Dense in memory; oneDNN's layouts, sparse and quantised tensors become plain numbers.
inline at::Tensor dense(const at::Tensor& given) {
  at::Tensor tensor = given.is_quantized() ? given.dequantize() : given;
  if (tensor.layout() != at::kStrided) tensor = tensor.to_dense();
  if (tensor.is_conj() || tensor.is_neg()) tensor = tensor.resolve_conj().resolve_neg();
  return tensor.contiguous();
}

inline bool lies_within(const void* data, std::span<const weir_tensor> tensors) {
  const auto* at = static_cast<const std::byte*>(data);
  return std::any_of(tensors.begin(), tensors.end(), [at](const weir_tensor& tensor) {
    const auto* begin = static_cast<const std::byte*>(tensor.data);
    return begin && at >= begin && at < begin + tensor.bytes;
  });
}

// Writes into the memory that is there, or gives libtorch's away: copied where it is an input's, a
// weight's or another output's too.
inline Status hand_over(const at::Tensor& tensor, size_t index, std::span<const weir_tensor> inputs,
                        weir_tensor* out) {
  auto info = torch_info(tensor);
  if (!info) return info.error();
  const uint64_t bytes = tensor.nbytes();
  const bool only_ours = tensor.has_storage() && tensor.storage().use_count() == 1 &&
                         !lies_within(tensor.data_ptr(), inputs);
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
