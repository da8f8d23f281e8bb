// weir_tensor_info <-> ModelShape.
#include "elements/tensor_filter/model_info.hpp"

#include <algorithm>

namespace weir {

ModelShape model_shape(const weir_tensor_info& info) {
  ModelShape shape;
  shape.type = static_cast<ElementType>(info.type);
  shape.rank_known = info.rank != WEIR_RANK_UNKNOWN;
  if (shape.rank_known)
    shape.shape.assign(info.shape, info.shape + std::min<uint32_t>(info.rank, WEIR_RANK_LIMIT));
  if (info.name) shape.name = info.name;
  return shape;
}

std::vector<ModelShape> model_shapes(const std::vector<weir_tensor_info>& infos) {
  std::vector<ModelShape> out;
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
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  return info;
}

void describe_tensors(const std::vector<ModelShape>& shapes, std::vector<weir_tensor>* tensors) {
  tensors->assign(shapes.size(), weir_tensor{});
  for (size_t i = 0; i < shapes.size(); ++i) {
    (*tensors)[i].info = tensor_info(shapes[i]);
    (*tensors)[i].memory_kind = WEIR_MEMORY_HOST;
    (*tensors)[i].fence_fd = -1;
    if (shapes[i].fixed()) (*tensors)[i].bytes = to_spec(shapes[i]).bytes().value_or(0);
  }
}

Result<std::vector<ModelShape>> resolve(infer::Session* session,
                                        const std::vector<ModelShape>& inputs,
                                        const std::vector<ModelShape>& declared) {
  std::vector<weir_tensor_info> infos;
  for (const auto& shape : inputs) infos.push_back(tensor_info(shape));
  auto resolved = session->resolve(infos);
  if (!resolved) return resolved.error();
  auto out = model_shapes(*resolved);
  for (size_t i = 0; i < std::min(out.size(), declared.size()); ++i) {
    if (!out[i].fixed() && declared[i].fixed()) out[i] = declared[i];
    if (out[i].name.empty()) out[i].name = declared[i].name;
  }
  if (out.empty()) return declared;
  return out;
}

}  // namespace weir
