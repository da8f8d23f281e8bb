// Between the ABI's tensor descriptions and those that the filter matches.
#pragma once
#include <string>
#include <vector>

#include "core/infer/model_shapes.hpp"

namespace weir {

// Fills a frame's tensors with types, shapes and sizes (0 where open); data stay null.
void describe_tensors(const std::vector<ModelShape>& shapes, std::vector<weir_tensor>* tensors);
// What the engine said of the outputs; where that is open, what was `declared` (by the user).
std::vector<ModelShape> completed(std::vector<ModelShape> resolved,
                                  const std::vector<ModelShape>& declared);

// "4,2" of two tensors; 1 where nothing is known.
std::string ranks(const std::vector<ModelShape>& shapes);

}  // namespace weir
