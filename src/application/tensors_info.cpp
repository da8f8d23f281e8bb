// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tensors_info.hpp"

#include <algorithm>
#include <utility>

#include "weir/join.hpp"

namespace weir::application {

std::string describe(const TensorSpecs& tensors) {
  if (tensors.empty()) return "no tensor";
  return join(tensors, ", ", [](const TensorSpec& tensor) {
    return (tensor.type == ElementType::End ? "no type" : std::string(to_string(tensor.type))) +
           (tensor.shape.valid() ? " " + tensor.shape.to_string() : ", no dimensions");
  });
}

Status check_complete(const TensorSpecs& tensors, const char* what) {
  if (tensors.empty())
    return Error{.code = Code::OPTION_VALUE,
                 .what = std::string(what) + " describes no tensor",
                 .needed = "at least one tensor",
                 .fix = "ml_tensors_info_set_count(info, 1)"};
  int64_t total = 0;
  for (size_t i = 0; i < tensors.size(); ++i) {
    const std::string name = std::string(what) + ": tensor " + std::to_string(i);
    if (!tensors[i].valid())
      return Error{.code = Code::OPTION_VALUE,
                   .what = name + " has an incomplete description",
                   .offered = describe(tensors),
                   .needed = "a type and dimensions",
                   .difference = tensors[i].shape.valid() ? "type" : "dimensions",
                   .fix = tensors[i].shape.valid() ? "ml_tensors_info_set_tensor_type"
                                                   : "ml_tensors_info_set_tensor_dimension"};
    if (!tensors[i].bytes())
      return Error{.code = Code::LIMIT_EXCEEDED,
                   .what = name + " is too large",
                   .offered = describe(tensors),
                   .needed = "less than 2^63 bytes"};
    if (__builtin_add_overflow(total, static_cast<int64_t>(*tensors[i].bytes()), &total))
      return Error{.code = Code::LIMIT_EXCEEDED,
                   .what = std::string(what) + " describes tensors that are too large together",
                   .offered = describe(tensors),
                   .needed = "less than 2^63 bytes"};
  }
  return ok();
}

Status check_same(const char* what, const TensorSpecs& offered, const TensorSpecs& needed) {
  const std::string difference = first_difference(offered, needed);
  if (difference.empty()) return ok();
  return Error{.code = Code::SPEC_MISMATCH,
               .what = what,
               .offered = describe(offered),
               .needed = describe(needed),
               .difference = difference};
}

weir_tensor_info c_info(const TensorSpec& spec) {
  weir_tensor_info info{};
  info.type = static_cast<uint32_t>(spec.type);
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  info.name = spec.name.empty() ? nullptr : spec.name.c_str();
  const size_t rank = spec.shape.rank();
  info.rank = rank > 0 ? static_cast<uint32_t>(rank) : WEIR_RANK_UNKNOWN;
  for (size_t i = 0; i < rank; ++i) info.shape[i] = spec.shape[rank - 1 - i];
  return info;
}

std::vector<weir_tensor_info> c_infos(const TensorSpecs& tensors) {
  std::vector<weir_tensor_info> out;
  for (const auto& tensor : tensors) out.push_back(c_info(tensor));
  return out;
}

TensorSpec to_spec(const weir_tensor_info& info) {
  TensorSpec spec;
  if (info.type < WEIR_TYPE_END) spec.type = static_cast<ElementType>(info.type);
  spec.name = info.name ? info.name : "";
  if (info.rank > WEIR_RANK_LIMIT) return spec;
  if (info.rank == 0) spec.shape = Shape{1};
  for (uint32_t i = 0; i < info.rank; ++i)
    spec.shape[info.rank - 1 - i] =
        info.shape[i] < 0 ? 1 : static_cast<uint32_t>(std::min<int64_t>(info.shape[i], UINT32_MAX));
  if (spec.shape.rank() < info.rank) spec.shape.set_rank(info.rank);
  return spec;
}

Error no_such_tensor(std::string index, size_t count) {
  return Error{.code = Code::OPTION_VALUE,
               .what = "no tensor has this index",
               .offered = std::move(index),
               .needed = "an index below the number of tensors: " + std::to_string(count)};
}

Error TensorsInfo::beyond(size_t index, size_t count) {
  return no_such_tensor(std::to_string(index), count);
}

void TensorsInfo::set(TensorSpecs tensors, std::optional<Reads> reads) {
  const bool is_long = std::any_of(tensors.begin(), tensors.end(), [](const TensorSpec& tensor) {
    return tensor.shape.rank() > kPlainRank;
  });
  std::lock_guard lock(mutex_);
  tensors_ = std::move(tensors);
  count_ = tensors_.size();
  reads_ = reads.value_or(is_long ? Reads::AllDimensions : Reads::FourDimensions);
}

void* new_info(TensorSpecs tensors) {
  return Handles::all().add(std::make_shared<TensorsInfo>(std::move(tensors)));
}

Result<TensorSpecs> tensors_or_none(void* info, const char* what) {
  if (!info) return TensorSpecs{};
  const auto found = Handles::all().find<TensorsInfo>(info, what);
  if (!found) return found.error();
  auto tensors = (*found)->tensors();
  if (auto status = check_complete(tensors, what); !status) return status.error();
  return tensors;
}

}  // namespace weir::application
