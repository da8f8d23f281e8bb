// Test fixture that runs a decoder module as the host does, with a sink that records its output.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "core/infer/module/decoder.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/tensor/frame_spec.hpp"
#include "says.hpp"

namespace weir::testing_decoders {

using Bytes = std::vector<uint8_t>;

struct MemorySink : weir_sink {
  std::string caps;
  std::vector<Bytes> memories;   // memories that the decoder reserved
  std::vector<uint32_t> shared;  // indices of the inputs that it shared

  Status set_caps(const std::string& text) override {
    caps = text;
    return ok();
  }
  void* reserve(uint64_t bytes) override { return memories.emplace_back(bytes).data(); }
  Status share_input(uint32_t index) override {
    shared.push_back(index);
    return ok();
  }
};

// A tensor with dimensions as in caps ("3:4:2", innermost first), and its bytes.
template <class T>
struct Tensor {
  ElementType type;
  std::string shape;
  std::vector<T> values;

  weir_tensor_info info() const {
    weir_tensor_info out{};
    const Shape parsed = Shape::parse(shape);
    out.type = static_cast<uint32_t>(type);
    out.rank = static_cast<uint32_t>(parsed.rank());
    for (uint32_t i = 0; i < out.rank; ++i) out.shape[i] = parsed[out.rank - 1 - i];
    return out;
  }
};

struct Outcome {
  MemorySink sink;
  std::string error;  // empty on success
};

// Opens the decoder, configures it for `input` and decodes a frame of these tensors.
inline Outcome decode_frame(const std::string& mode, const infer::Decoder::Options& options,
                            const weir_tensor_info& input, std::vector<weir_tensor> tensors) {
  Outcome out;
  infer::ModuleLibrary library;
  const auto type = library.decoder(mode);
  auto decoder = type ? infer::Decoder::open(**type, options)
                      : Result<std::unique_ptr<infer::Decoder>>(type.error());
  if (!decoder) {
    out.error = decoder.error().message();
    return out;
  }
  if (const auto status = (*decoder)->configure({input}, &out.sink); !status) {
    out.error = status.error().message();
    return out;
  }
  weir_frame frame{};
  frame.struct_size = sizeof frame;
  frame.n_tensors = static_cast<uint32_t>(tensors.size());
  frame.tensors = tensors.empty() ? nullptr : tensors.data();
  if (const auto kept = (*decoder)->decode(frame, &out.sink); !kept)
    out.error = kept.error().message();
  return out;
}

// The same with one tensor.
template <class T>
Outcome decode(const std::string& mode, const infer::Decoder::Options& options,
               const Tensor<T>& tensor) {
  std::vector<T> values = tensor.values;
  weir_tensor memory{};
  memory.data = values.data();
  memory.bytes = memory.capacity = values.size() * sizeof(T);
  memory.info = tensor.info();
  return decode_frame(mode, options, tensor.info(), {memory});
}

}  // namespace weir::testing_decoders
