// What a model says of one tensor, some of it open, and whether a stream's tensor fits it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/tensor/frame_spec.hpp"

namespace weir {

// Shapes here are outermost-first as models have them; -1 = decided by the stream.
struct ModelShape {
  ElementType type = ElementType::End;  // End: decided by the stream
  bool rank_known = false;
  std::vector<int64_t> shape;  // empty and rank_known: a scalar
  std::string name;
  uint32_t layout = 0;  // weir_layout; 0 = any

  bool fixed() const noexcept;  // type and every dimension known
  std::string to_string()
      const;  // innermost-first as in caps, '?' for what is open: "float32 3:?:?:1"
};

// The tensor when everything is known; a scalar becomes "1". Precondition: fixed().
TensorSpec to_spec(const ModelShape& shape);
// All tensors, or those parts left unknown (type End, invalid shape) that are open.
std::vector<TensorSpec> known_parts(const std::vector<ModelShape>& shapes);

// Puts the stream's tensors in place of what the model leaves open, with the model's exact rank. A
// model of no tensors leaves their number open.
// Counts, types or dimensions that do not fit are a SPEC_MISMATCH with a line to paste.
Result<std::vector<ModelShape>> fit(const std::vector<ModelShape>& model,
                                    const std::vector<TensorSpec>& stream);

// What the user wrote in input= / inputtype= (or output...) laid over what the model says. Parts
// that contradict the model are a SPEC_MISMATCH that names `property`.
Result<std::vector<ModelShape>> with_user_settings(std::vector<ModelShape> model,
                                                   const std::string& dimensions,
                                                   const std::string& types,
                                                   const std::string& property);

// A gst-launch fragment that turns `offered` into `needed`, "" when none is known.
std::string suggested_fix(const TensorSpec& offered, const ModelShape& needed);

}  // namespace weir
