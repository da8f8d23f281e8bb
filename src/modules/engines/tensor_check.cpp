// Validates tensors that cross the ABI; trusts none of their members.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tensor_check.hpp"

#include <algorithm>
#include <cstring>

#include "weir/join.hpp"

namespace weir::engine {
namespace {

// Larger than any tensor of a stream, and small enough that no product overflows.
constexpr uint64_t kBytesLimit = uint64_t{1} << 48;

bool strides_are_dense(const weir_tensor& tensor) {
  const auto& info = tensor.info;
  int64_t step = static_cast<int64_t>(element_bytes(info.type));
  bool all_zero = true, dense = true;
  for (uint32_t i = info.rank; i-- > 0;) {
    all_zero = all_zero && tensor.stride[i] == 0;
    dense = dense && (tensor.stride[i] == step || info.shape[i] == 1);
    step *= info.shape[i];
  }
  return all_zero || dense;
}

bool fits_type(const weir_tensor_info& model, const weir_tensor_info& given) {
  return model.type == given.type || model.type == WEIR_TYPE_END;
}

std::string first_difference(const weir_tensor_info& model, const weir_tensor_info& given) {
  if (!fits_type(model, given))
    return std::string("type ") + type_name(given.type) + " instead of " + type_name(model.type);
  if (model.rank != given.rank)
    return "rank " + std::to_string(given.rank) + " instead of " + std::to_string(model.rank);
  for (uint32_t i = model.rank; i-- > 0;)
    if (model.shape[i] >= 0 && given.shape[i] >= 0 && model.shape[i] != given.shape[i])
      return "dimension " + std::to_string(model.rank - i) + " is " +
             std::to_string(given.shape[i]) + " instead of " + std::to_string(model.shape[i]);
  return {};
}

bool fits(const weir_tensor_info& model, const weir_tensor_info& given) {
  if (!fits_type(model, given)) return false;
  if (model.rank == WEIR_RANK_UNKNOWN || given.rank == WEIR_RANK_UNKNOWN) return true;
  return given.rank <= WEIR_RANK_LIMIT && first_difference(model, given).empty();
}

Error does_not_fit(const weir_tensor_info& model, const weir_tensor_info& given, size_t index,
                   const char* role) {
  return Error{.code = Code::SPEC_MISMATCH,
               .what = std::string(role) + " " + std::to_string(index) + " does not fit the model",
               .offered = describe(given),
               .needed = describe(model),
               .difference = first_difference(model, given)};
}

}  // namespace

bool is_fixed(const weir_tensor_info& info) noexcept {
  return info.rank <= WEIR_RANK_LIMIT &&
         std::all_of(info.shape, info.shape + info.rank, [](int64_t d) { return d >= 0; });
}

std::optional<uint64_t> tensor_bytes(const weir_tensor_info& info) noexcept {
  uint64_t bytes = element_bytes(info.type);
  if (bytes == 0 || !is_fixed(info)) return std::nullopt;
  for (uint32_t i = 0; i < info.rank; ++i) {
    const auto extent = static_cast<uint64_t>(info.shape[i]);
    if (extent != 0 && bytes > kBytesLimit / extent) return std::nullopt;
    bytes *= extent;
  }
  return bytes;
}

std::string describe(const weir_tensor_info& info) {
  std::string out = std::string(type_name(info.type)) + " ";
  if (info.rank == 0) out += "1";
  if (info.rank > WEIR_RANK_LIMIT) out += "of any rank";
  for (uint32_t i = std::min<uint32_t>(info.rank, info.rank > WEIR_RANK_LIMIT ? 0 : info.rank);
       i-- > 0;)
    out += (info.shape[i] < 0 ? "?" : std::to_string(info.shape[i])) + (i > 0 ? ":" : "");
  if (info.name && *info.name) out += std::string(" (") + info.name + ")";
  return out;
}

std::string describe(std::span<const weir_tensor_info> infos) {
  if (infos.empty()) return "no tensors";
  return join(infos, ", ", [](const weir_tensor_info& info) { return describe(info); });
}

Status check_infos(std::span<const weir_tensor_info> model, std::span<const weir_tensor_info> given,
                   const char* role) {
  if (model.size() != given.size())
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = std::string("the number of ") + role + "s does not fit the model",
                 .offered = std::to_string(given.size()) + ": " + describe(given),
                 .needed = std::to_string(model.size()) + ": " + describe(model)};
  for (size_t i = 0; i < model.size(); ++i)
    if (!fits(model[i], given[i])) return does_not_fit(model[i], given[i], i, role);
  return ok();
}

Status check_memory(const weir_tensor& tensor, size_t index, const char* role) {
  const std::string which = std::string(role) + " " + std::to_string(index);
  if (tensor.memory_kind != WEIR_MEMORY_HOST)
    return Error{.code = Code::FORMAT_UNSUPPORTED,
                 .what = which + " is not in host memory",
                 .offered = "memory kind " + std::to_string(tensor.memory_kind),
                 .needed = "host memory"};
  const auto bytes = tensor_bytes(tensor.info);
  if (!bytes || *bytes != tensor.bytes || (!tensor.data && *bytes > 0))
    return Error{
        .code = Code::FRAME_SIZE,
        .what = which + " has a size that does not match its description",
        .offered = std::to_string(tensor.bytes) + " bytes" + (tensor.data ? "" : " without memory"),
        .needed = bytes ? std::to_string(*bytes) + " bytes: " + describe(tensor.info)
                        : "a complete description, not " + describe(tensor.info)};
  if (!strides_are_dense(tensor))
    return Error{.code = Code::FORMAT_UNSUPPORTED,
                 .what = which + " has gaps between its rows",
                 .offered = "a strided view",
                 .needed = "dense memory"};
  return ok();
}

std::span<weir_tensor> get_tensors(const weir_frame& frame) noexcept {
  return {frame.tensors, frame.tensors ? frame.n_tensors : 0};
}

Status check_count(std::span<const weir_tensor_info> model, size_t given, const char* role) {
  if (given == model.size()) return ok();
  return Error{.code = Code::SPEC_MISMATCH,
               .what = std::string("the number of ") + role + "s does not fit the model",
               .offered = std::to_string(given),
               .needed = std::to_string(model.size()) + ": " + describe(model)};
}

Status check_inputs(std::span<const weir_tensor_info> model, std::span<const weir_tensor> given) {
  if (auto status = check_count(model, given.size(), "input"); !status) return status;
  for (size_t i = 0; i < given.size(); ++i) {
    if (!fits(model[i], given[i].info)) return does_not_fit(model[i], given[i].info, i, "input");
    if (auto status = check_memory(given[i], i, "input"); !status) return status;
  }
  return ok();
}

Status check_outputs(std::span<const weir_tensor_info> model, std::span<const weir_tensor> given) {
  if (auto status = check_count(model, given.size(), "output"); !status) return status;
  for (size_t i = 0; i < given.size(); ++i)
    if (given[i].data)
      if (auto status = check_memory(given[i], i, "output"); !status) return status;
  return ok();
}

Status write_output(const weir_tensor_info& info, const void* data, size_t index, weir_tensor* to) {
  const uint64_t bytes = tensor_bytes(info).value_or(0);
  if (!to->data) {
    const char* name = to->info.name ? to->info.name : info.name;
    if (module_host->allocate(nullptr, WEIR_MEMORY_HOST, bytes, 64, to) != WEIR_OK)
      return Error{.code = Code::OUT_OF_MEMORY,
                   .what = "no memory for an output",
                   .offered = describe(info)};
    to->info = info;
    to->info.name = name;
  } else if (to->bytes != bytes || to->info.type != info.type) {
    return Error{.code = Code::INVOKE_FAILED,
                 .what = "an output's size or type differs from its declaration",
                 .offered = describe(info),
                 .needed = describe(to->info),
                 .difference = "output " + std::to_string(index)};
  }
  if (bytes > 0) std::memcpy(to->data, data, bytes);
  return ok();
}

}  // namespace weir::engine
