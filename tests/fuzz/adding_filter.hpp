// A filter for targets that need a model: framework=custom-easy model=adding takes uint8 of any
// size and returns the number of bytes and their sum.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstring>

#include "fuzz_input.hpp"
#include "weir/custom_filter.h"

namespace weir::fuzz {

inline int add_bytes(const weir_host*, const weir_frame* in, weir_frame* out, void*, weir_error*) {
  // Engines depend on these guarantees of the host.
  require(in->n_tensors == 1 && out->n_tensors == 1, "a frame has the tensors of the model");
  const auto& from = in->tensors[0];
  require(from.data || from.bytes == 0, "an input has memory");
  // It does not allocate outputs, and the pipeline sets a worker's sizes.
  if (!out->tensors[0].data || out->tensors[0].bytes < 16) return -WEIR_INVOKE_FAILED;
  uint64_t results[2] = {from.bytes, 0};
  for (uint64_t i = 0; i < from.bytes; ++i) results[1] += static_cast<const uint8_t*>(from.data)[i];
  std::memcpy(out->tensors[0].data, results, sizeof results);
  return 0;
}

inline void register_adding_filter() {
  weir_tensor_info input{}, output{};
  input.type = WEIR_UINT8;
  input.rank = output.rank = 1;
  input.shape[0] = -1;
  output.type = WEIR_UINT64;
  output.shape[0] = 2;
  input.batch_axis = output.batch_axis = WEIR_NO_BATCH_AXIS;
  weir_filter filter{};
  filter.struct_size = sizeof filter;
  filter.n_inputs = filter.n_outputs = 1;
  filter.inputs = &input;
  filter.outputs = &output;
  filter.invoke = add_bytes;
  require(weir_filter_register("adding", &filter, nullptr) == 0, "a filter can be registered");
}

}  // namespace weir::fuzz
