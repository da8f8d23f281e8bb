// ModelShape -> the tensors of a frame.
#include "elements/tensor_filter/model_info.hpp"

#include <algorithm>

namespace weir {

void describe_tensors(const std::vector<ModelShape>& shapes, std::vector<weir_tensor>* tensors) {
  tensors->assign(shapes.size(), weir_tensor{});
  for (size_t i = 0; i < shapes.size(); ++i) {
    (*tensors)[i].info = tensor_info(shapes[i]);
    (*tensors)[i].memory_kind = WEIR_MEMORY_HOST;
    (*tensors)[i].fence_fd = -1;
    if (shapes[i].fixed()) (*tensors)[i].bytes = to_spec(shapes[i]).bytes().value_or(0);
  }
}

std::vector<ModelShape> completed(std::vector<ModelShape> resolved,
                                  const std::vector<ModelShape>& declared) {
  if (resolved.empty()) return declared;
  for (size_t i = 0; i < std::min(resolved.size(), declared.size()); ++i) {
    if (!resolved[i].fixed() && declared[i].fixed()) resolved[i] = declared[i];
    if (resolved[i].name.empty()) resolved[i].name = declared[i].name;
    resolved[i].layout = declared[i].layout;
  }
  return resolved;
}

std::string ranks(const std::vector<ModelShape>& shapes) {
  std::string out;
  for (const auto& shape : shapes) {
    const size_t rank = shape.shape.empty() ? 1 : shape.shape.size();
    out += (out.empty() ? "" : ",") + std::to_string(rank);
  }
  return out;
}

}  // namespace weir
