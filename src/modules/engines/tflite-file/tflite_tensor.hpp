// TfliteTensor: one tensor of a TensorFlow Lite file, checked.
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
  bool constant = false;  // the file has its value
  bool made = false;      // an input, or the output of an operator that was walked
  bool computed = false;  // by an operator
  bool empty = false;     // of no elements: it may be used without ever being made
  bool is_available() const { return variable || constant || made || empty; }
};

// MODEL_INVALID with the words of `finding`, or that the file was cut where it was.
Error tflite_damage(const FlatFile& file, const std::string& finding);

// MODEL_INVALID for an unknown element type, a buffer that is not there or of another size, a
// shape, quantisation or sparsity that cannot be. `buffers`: the data of each.
Result<TfliteTensor> check_tflite_tensor(FlatFile* file, const FlatTable& tensor,
                                         std::span<const FlatVector> buffers);

}  // namespace weir::engine
