// ModelTensor: a model's declaration of one input or output, which may leave parts open for the
// stream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "weir/abi.h"

namespace weir {

// Shapes are outermost first, as in models; -1 = taken from the stream.
struct ModelTensor {
  ElementType type = ElementType::End;  // End: taken from the stream
  bool rank_known = false;
  std::vector<int64_t> shape{};  // empty and rank_known: a scalar
  std::string name{};
  uint32_t layout = 0;  // weir_layout; 0 = any
  float scale = 0;      // real = scale * (value - zero_point); 0 = not quantised
  int32_t zero_point = 0;

  bool operator==(const ModelTensor&) const = default;
  bool fixed() const noexcept;  // type and every dimension known
  // Dimension i, counted from the innermost; 1 beyond the rank.
  int64_t inner(size_t i) const noexcept;
  std::string to_string()
      const;  // innermost-first as in caps, '?' for what is open: "float32 3:?:?:1"
};

// The tensor of a completely known shape; a scalar becomes "1". Precondition: no dimension is open
// (0 is a tensor without elements).
TensorSpec to_spec(const ModelTensor& tensor);
// All tensors, with open parts left unknown (type End, invalid shape).
std::vector<TensorSpec> known_parts(const std::vector<ModelTensor>& tensors);

// "2 tensors: uint8 3:224:224:1, float32 4".
std::string list_tensors(const std::vector<ModelTensor>& tensors);

ModelTensor model_tensor(const TensorSpec& spec);  // without its name
ModelTensor model_tensor(const weir_tensor_info& info);
std::vector<ModelTensor> model_tensors(std::span<const weir_tensor_info> infos);
weir_tensor_info tensor_info(const ModelTensor& tensor);  // its name points into `tensor`
std::vector<weir_tensor_info> tensor_infos(const std::vector<ModelTensor>& tensors);

// Describes the first difference in number, type or shape of tensors; "" without one. Names may
// differ. `role`: "input" or "output".
std::string first_difference(const std::vector<ModelTensor>& offered,
                             const std::vector<ModelTensor>& needed, const std::string& role);
// Tensors of a frame with types, shapes and sizes (0 where open); data stay null. Their names point
// into `tensors`.
std::vector<weir_tensor> frame_tensors(const std::vector<ModelTensor>& tensors);

}  // namespace weir
