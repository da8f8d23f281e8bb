// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/converted_frame.hpp"

#include <algorithm>
#include <string>

#include "core/tensor/tensor_header.hpp"

namespace weir::infer {
namespace {

Error fault(const std::string& who, const char* what, std::string offered, std::string needed) {
  return Error{.code = Code::CALLBACK_FAILED,
               .what = who + what,
               .offered = std::move(offered),
               .needed = std::move(needed),
               .fix = "correct " + who};
}

// Compares the header in front of a flexible tensor with the spec.
Status check_header(const TensorSpec& spec, const weir_tensor& tensor) {
  const auto header = read_tensor_chunk({static_cast<const std::byte*>(tensor.data), tensor.bytes});
  if (!header) return header.error();
  if (header->format == Format::Sparse)
    return Error{.code = Code::FORMAT_UNSUPPORTED,
                 .what = "a tensor of a flexible stream is sparse",
                 .offered = header->spec.to_string(),
                 .needed = "dense tensors"};
  const std::string difference = first_difference({header->spec}, {spec});
  if (difference.empty() && tensor.bytes == kTensorHeaderBytes + *spec.bytes()) return ok();
  return Error{.code = Code::HEADER_INVALID,
               .what = "the header of a flexible tensor does not agree with its frame",
               .offered = header->spec.to_string() + ", " + std::to_string(tensor.bytes) +
                          " bytes with the header",
               .needed = spec.to_string() + ", " +
                         std::to_string(kTensorHeaderBytes + *spec.bytes()) + " bytes",
               .difference = difference,
               .fix = "check the element or program that wrote the stream"};
}

}  // namespace

Status ConverterRoom::check_memory(const TensorSpec& spec, const weir_tensor& tensor,
                                   bool is_flexible) const {
  const bool dense = std::all_of(std::begin(tensor.stride), std::end(tensor.stride),
                                 [](auto s) { return s == 0; });
  if (!tensor.data || tensor.memory_kind != WEIR_MEMORY_HOST || tensor.offset != 0 || !dense)
    return fault(who_, " produced a tensor that is not dense in host memory",
                 spec.to_string() + (tensor.data ? "" : ", data is NULL"),
                 "data, no offset, no strides");
  if (is_flexible) return check_header(spec, tensor);
  if (tensor.bytes != spec.bytes())
    return fault(who_, " produced a tensor whose size differs from its description",
                 std::to_string(tensor.bytes) + " bytes",
                 std::to_string(spec.bytes().value_or(0)) + " bytes for " + spec.to_string());
  return ok();
}

Result<TensorSpec> to_spec(const std::string& who, const weir_tensor_info& info) {
  const auto refused = [&who](const std::string& offered) {
    return fault(
        who, " describes an invalid tensor", offered,
        "a type, a rank of at most 16, dimensions of 0 to 4294967295, less than 2^63 bytes");
  };
  if (info.type >= WEIR_TYPE_END || info.rank > WEIR_RANK_LIMIT)
    return refused("type " + std::to_string(info.type) + ", rank " + std::to_string(info.rank));
  TensorSpec spec{static_cast<ElementType>(info.type), Shape{1}, ""};
  for (uint32_t i = 0; i < info.rank; ++i) {
    const int64_t extent = info.shape[info.rank - 1 - i];
    if (extent < 0 || extent > UINT32_MAX)
      return refused("a dimension of " + std::to_string(extent));
    spec.shape[i] = static_cast<uint32_t>(extent);
  }
  if (spec.shape.rank() < info.rank) spec.shape.set_rank(info.rank);
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

Result<ConvertedFrame> ConverterRoom::take(int result, weir_error* error, bool is_flexible) {
  auto out = checked(result, error, is_flexible);
  release();
  return out;
}

Error ConverterRoom::discard(Error error) noexcept {
  release();
  return error;
}

Result<ConvertedFrame> ConverterRoom::checked(int result, weir_error* error, bool is_flexible) {
  if (result < 0) return take_error(error, result, who_ + " failed on a frame");
  ConvertedFrame out;
  out.pts = frame_.pts;
  out.duration = frame_.duration;
  out.is_flexible = is_flexible;
  if (result > 0) return out;
  const size_t count = frame_.n_tensors;
  if (count == 0 || count > WEIR_TENSOR_LIMIT || frame_.tensors != tensors_.data())
    return fault(who_, " produced no tensors, or more than there is room for",
                 std::to_string(count), "1 to 256, within the given capacity");
  for (size_t i = 0; i < count; ++i) {
    const auto spec = to_spec(who_, tensors_[i].info);
    if (!spec) return spec.error();
    if (auto status = check_memory(*spec, tensors_[i], is_flexible); !status) return status.error();
    out.tensors.emplace_back(*spec, std::exchange(tensors_[i], weir_tensor{}));
  }
  return out;
}

}  // namespace weir::infer
