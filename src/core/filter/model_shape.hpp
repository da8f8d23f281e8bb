// ModelShape: a model's declaration of one tensor, which may leave parts open for the stream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/tensor/frame_spec.hpp"

namespace weir {

// Shapes are outermost first, as in models; -1 = taken from the stream.
struct ModelShape {
  ElementType type = ElementType::End;  // End: taken from the stream
  bool rank_known = false;
  std::vector<int64_t> shape;  // empty and rank_known: a scalar
  std::string name;
  uint32_t layout = 0;  // weir_layout; 0 = any

  bool fixed() const noexcept;  // type and every dimension known
  std::string to_string()
      const;  // innermost-first as in caps, '?' for what is open: "float32 3:?:?:1"
};

// The tensor of a completely known shape; a scalar becomes "1". Precondition: fixed().
TensorSpec to_spec(const ModelShape& shape);
// All tensors, with open parts left unknown (type End, invalid shape).
std::vector<TensorSpec> known_parts(const std::vector<ModelShape>& shapes);

// "2 tensors: uint8 3:224:224:1, float32 4".
std::string list_shapes(const std::vector<ModelShape>& shapes);

// Fills the model's open parts from the stream's tensors, with the model's exact rank. A model
// without tensors leaves their number open. Mismatching counts, types or dimensions are a
// SPEC_MISMATCH with a line to paste.
Result<std::vector<ModelShape>> fit(const std::vector<ModelShape>& model,
                                    const std::vector<TensorSpec>& stream);

// Merges the user's input= and inputtype= (or output...) with the model's declaration. Parts that
// contradict the model are a SPEC_MISMATCH that names `property`.
Result<std::vector<ModelShape>> with_user_settings(std::vector<ModelShape> model,
                                                   const std::string& dimensions,
                                                   const std::string& types,
                                                   const std::string& property);

// A gst-launch fragment that converts `offered` to `needed`, "" if none is known.
std::string suggested_fix(const TensorSpec& offered, const ModelShape& needed);

}  // namespace weir
