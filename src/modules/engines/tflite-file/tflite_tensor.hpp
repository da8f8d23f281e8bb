// TfliteTensor: one validated tensor of a TensorFlow Lite file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string>

#include "tflite-file/flat_buffer.hpp"
#include "weir/result.hpp"

namespace weir::engine {

constexpr uint32_t kTfliteRankLimit = 16;

struct TfliteTensor {
  bool variable = false;
  bool constant = false;  // its value is in the file
  bool made = false;      // is an input, or the output of an operator already visited
  bool computed = false;  // is the output of an operator
  bool empty = false;     // has no elements, so it may be used without being computed
  bool is_available() const { return variable || constant || made || empty; }
};

// MODEL_INVALID with the text of `finding`, or with the place at which the file is truncated.
Error tflite_damage(const FlatFile& file, const std::string& finding);

// MODEL_INVALID for an unknown element type, a missing buffer or one of another size, and an
// invalid shape, quantisation or sparsity. `buffers`: the data of each buffer.
Result<TfliteTensor> check_tflite_tensor(FlatFile* file, const FlatTable& tensor,
                                         std::span<const FlatVector> buffers);

}  // namespace weir::engine
