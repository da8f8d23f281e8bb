// Checks and converts tensor descriptions: caps are innermost first, engines outermost first.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "compat/tensors.hpp"

#include <algorithm>

#include "nnstreamer_plugin_api_util.h"
#include "weir/join.hpp"

namespace weir::compat {
namespace {

constexpr uint64_t kMaxBytes = uint64_t{1} << 32;

Failure nonsense(const std::string& filter, std::string offered, std::string needed) {
  return Failure(
      {.code = Code::CALLBACK_FAILED,
       .what = "the filter " + filter + " declares an invalid tensor",
       .offered = std::move(offered),
       .needed = std::move(needed),
       .fix =
           "set num_tensors, and the type and dimension of every tensor, in the GstTensorsInfo"});
}

std::string numbers(const tensor_dim dim) {
  size_t count = NNS_TENSOR_RANK_LIMIT;
  while (count > 1 && dim[count - 1] == 0) --count;
  return join(std::span(dim, count), ":", [](uint32_t extent) { return std::to_string(extent); });
}

weir_tensor_info open_tensor() {
  weir_tensor_info info{};
  info.type = WEIR_TYPE_END;
  info.rank = WEIR_RANK_UNKNOWN;
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  return info;
}

weir_tensor_info checked(const GstTensorInfo& tensor, const std::string& filter,
                         const std::string& which) {
  if (element_type(tensor.type) == ElementType::End)
    throw nonsense(filter, which + " with type " + std::to_string(static_cast<int>(tensor.type)),
                   "a value of tensor_type, 0 to 10");
  const Shape shape = to_shape(tensor.dimension);
  if (!shape.valid())
    throw nonsense(filter, which + " with the dimension " + numbers(tensor.dimension),
                   "1 to 16 numbers above 0, followed only by zeros");
  const auto bytes = TensorSpec{element_type(tensor.type), shape, {}}.bytes();
  if (!bytes || *bytes >= kMaxBytes)
    throw nonsense(filter, which + " with the dimension " + numbers(tensor.dimension),
                   "less than 4 GiB");
  weir_tensor_info info = open_tensor();
  info.type = static_cast<uint32_t>(tensor.type);
  info.rank = static_cast<uint32_t>(shape.rank());
  for (uint32_t i = 0; i < info.rank; ++i) info.shape[i] = shape[info.rank - 1 - i];
  return info;
}

void assign(const weir_tensor_info& from, GstTensorInfo* to) {
  to->name = g_strdup(from.name);
  to->type = from.type < _NNS_END ? static_cast<tensor_type>(from.type) : _NNS_END;
  std::fill_n(to->dimension, NNS_TENSOR_RANK_LIMIT, 0);
  if (from.rank > WEIR_RANK_LIMIT) return;
  if (from.rank == 0) to->dimension[0] = 1;
  for (uint32_t i = 0; i < from.rank; ++i) {
    const int64_t extent = from.shape[from.rank - 1 - i];
    to->dimension[i] = extent > 0 ? static_cast<uint32_t>(extent) : 0;
  }
}

}  // namespace

OwnedTensorsInfo::OwnedTensorsInfo() noexcept {
  gst_tensors_info_init(&info_);
}
OwnedTensorsInfo::~OwnedTensorsInfo() {
  g_free(info_.extra);
}

void OwnedTensorsInfo::assign(std::span<const weir_tensor_info> tensors) {
  compat::assign(tensors, &info_);
  for (size_t i = 0; i < tensors.size(); ++i) {
    auto* tensor = tensor_at(info_, i);
    g_free(std::exchange(tensor->name, nullptr));
  }
}

void assign(std::span<const weir_tensor_info> tensors, GstTensorsInfo* to) {
  gst_tensors_info_free(to);
  to->num_tensors = static_cast<unsigned>(tensors.size());
  for (size_t i = 0; i < tensors.size(); ++i) assign(tensors[i], room_at(*to, i));
}

Described described(const GstTensorsInfo& info, const std::string& filter, const char* role) {
  if (info.num_tensors == 0 || info.num_tensors > NNS_TENSOR_SIZE_LIMIT)
    throw nonsense(filter, std::to_string(info.num_tensors) + " " + role + "s", "1 to 256");
  Described out;
  for (size_t i = 0; i < info.num_tensors; ++i) {
    const std::string which = std::string(role) + " " + std::to_string(i);
    const auto* tensor = tensor_at(info, i);
    if (!tensor)
      throw nonsense(filter, which + " without a description",
                     "a description in extra, which gst_tensors_info_get_nth_info() allocates");
    out.infos.push_back(checked(*tensor, filter, which));
    if (tensor->name && *tensor->name)
      out.infos.back().name = out.names.emplace_back(tensor->name).c_str();
  }
  return out;
}

Described open_tensors(size_t count) {
  Described out;
  out.infos.assign(count, open_tensor());
  return out;
}

}  // namespace weir::compat
