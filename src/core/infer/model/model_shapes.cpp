// Converts between weir_tensor_info and ModelShape.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/model/model_shapes.hpp"

#include <algorithm>

namespace weir {

ModelShape model_shape(const weir_tensor_info& info) {
  ModelShape shape;
  shape.type = static_cast<ElementType>(info.type);
  shape.rank_known = info.rank != WEIR_RANK_UNKNOWN;
  if (shape.rank_known)
    shape.shape.assign(info.shape, info.shape + std::min<uint32_t>(info.rank, WEIR_RANK_LIMIT));
  if (info.name) shape.name = info.name;
  shape.layout = info.layout;
  return shape;
}

std::vector<ModelShape> model_shapes(const std::vector<weir_tensor_info>& infos) {
  std::vector<ModelShape> out;
  out.reserve(infos.size());
  for (const auto& info : infos) out.push_back(model_shape(info));
  return out;
}

weir_tensor_info tensor_info(const ModelShape& shape) {
  weir_tensor_info info{};
  info.type = static_cast<uint32_t>(shape.type);
  info.rank = shape.rank_known ? static_cast<uint32_t>(shape.shape.size()) : WEIR_RANK_UNKNOWN;
  std::copy_n(shape.shape.begin(), std::min<size_t>(shape.shape.size(), WEIR_RANK_LIMIT),
              info.shape);
  info.name = shape.name.c_str();
  info.layout = shape.layout;
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  return info;
}

std::vector<weir_tensor_info> tensor_infos(const std::vector<ModelShape>& shapes) {
  std::vector<weir_tensor_info> out;
  out.reserve(shapes.size());
  for (const auto& shape : shapes) out.push_back(tensor_info(shape));
  return out;
}

std::vector<weir_tensor> frame_tensors(const std::vector<ModelShape>& shapes) {
  std::vector<weir_tensor> tensors(shapes.size());
  for (size_t i = 0; i < shapes.size(); ++i) {
    tensors[i].info = tensor_info(shapes[i]);
    tensors[i].memory_kind = WEIR_MEMORY_HOST;
    tensors[i].fence_fd = -1;
    if (shapes[i].fixed()) tensors[i].bytes = to_spec(shapes[i]).bytes().value_or(0);
  }
  return tensors;
}

std::string first_difference(const std::vector<ModelShape>& offered,
                             const std::vector<ModelShape>& needed, const std::string& role) {
  if (offered.size() != needed.size())
    return std::to_string(offered.size()) + " " + role + "s, needed are " +
           std::to_string(needed.size());
  for (size_t i = 0; i < offered.size(); ++i) {
    const auto &a = offered[i], &b = needed[i];
    if (a.type != b.type || a.rank_known != b.rank_known || a.shape != b.shape)
      return role + " " + std::to_string(i) + " is " + a.to_string() + ", needed is " +
             b.to_string();
  }
  return "";
}

}  // namespace weir
