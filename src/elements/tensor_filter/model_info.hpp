// Between the ABI's tensor descriptions and those that the filter matches.
#pragma once
#include <vector>

#include "core/filter/model_shape.hpp"
#include "core/infer/model.hpp"

namespace weir {

ModelShape model_shape(const weir_tensor_info& info);
std::vector<ModelShape> model_shapes(const std::vector<weir_tensor_info>& infos);
weir_tensor_info tensor_info(const ModelShape& shape);  // its name points into `shape`
// Fills a frame's tensors with types, shapes and sizes (0 where open); data stay null.
void describe_tensors(const std::vector<ModelShape>& shapes, std::vector<weir_tensor>* tensors);
// The outputs for these inputs; what the engine leaves open stays as `declared` (by the user).
Result<std::vector<ModelShape>> resolve(infer::Session* session,
                                        const std::vector<ModelShape>& inputs,
                                        const std::vector<ModelShape>& declared);

}  // namespace weir
