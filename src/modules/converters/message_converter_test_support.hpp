// Runs a converter of messages as the host does, and reports which tensors are parts of the input.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>

#include <cstring>
#include <new>
#include <string>
#include <vector>

#include "core/infer/module/converter.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/tensor/tensor_header.hpp"
#include "says.hpp"

namespace weir::testing_converters {

using Bytes = std::vector<uint8_t>;

struct ReadMessage {
  std::string error;
  std::vector<std::string> specs;
  std::vector<Bytes> bytes;
  std::vector<bool> shared;  // a part of the input, not a copy
  std::string rate;          // "" without one
  bool is_flexible = false;
};

class MessageReader {
 public:
  explicit MessageReader(const std::string& name) {
    static infer::ModuleLibrary library;
    const auto type = library.converter(name);
    EXPECT_TRUE(type) << type.error().message();
    if (!type) return;
    auto opened = infer::Converter::open(**type, {});
    EXPECT_TRUE(opened) << opened.error().message();
    if (opened) converter_ = *std::move(opened);
  }

  std::vector<TensorSpec> configure(const std::string& caps) {
    const auto specs = converter_->configure(caps);
    EXPECT_TRUE(specs);
    return specs ? *specs : std::vector<TensorSpec>{};
  }

  // One buffer whose memories these are, the first at `shift` bytes after a multiple of 64.
  ReadMessage read(const std::vector<Bytes>& memories, size_t shift = 0) {
    std::vector<std::vector<Aligned>> blocks;
    std::vector<weir_tensor> inputs;
    for (const auto& memory : memories) {
      auto& block = blocks.emplace_back((memory.size() + shift) / 64 + 1);
      auto* const at = block[0].bytes + shift;
      std::copy(memory.begin(), memory.end(), at);
      weir_tensor input{};
      input.data = at;
      input.bytes = input.capacity = memory.size();
      inputs.push_back(input);
    }
    weir_frame frame{};
    frame.struct_size = sizeof frame;
    frame.n_tensors = static_cast<uint32_t>(inputs.size());
    frame.tensors = inputs.data();
    return describe(converter_->convert(frame), inputs);
  }
  ReadMessage read(const Bytes& message, size_t shift = 0) {
    return read(std::vector<Bytes>{message}, shift);
  }

 private:
  struct alignas(64) Aligned {
    uint8_t bytes[64] = {};
  };

  static ReadMessage describe(const Result<infer::ConvertedFrame>& made,
                              const std::vector<weir_tensor>& inputs) {
    ReadMessage out;
    if (!made) {
      out.error = made.error().message();
      return out;
    }
    for (const auto& tensor : made->tensors) {
      const auto* data = static_cast<const uint8_t*>(tensor.memory().data);
      out.specs.push_back(tensor.spec().to_string());
      out.bytes.emplace_back(data, data + tensor.memory().bytes);
      const auto* input = static_cast<const uint8_t*>(inputs[0].data);
      out.shared.push_back(data >= input && data < input + inputs[0].bytes);
      EXPECT_EQ(out.shared.back(), tensor.memory().release == nullptr);
    }
    if (made->rate)
      out.rate =
          std::to_string(made->rate->numerator) + "/" + std::to_string(made->rate->denominator);
    out.is_flexible = made->is_flexible;
    return out;
  }

  std::unique_ptr<infer::Converter> converter_;
};

inline Bytes join(std::initializer_list<Bytes> parts) {
  Bytes out;
  for (const auto& part : parts) out.insert(out.end(), part.begin(), part.end());
  return out;
}

// A flexible tensor: its header, then `payload`.
inline Bytes with_header(const TensorSpec& spec, const Bytes& payload,
                         Format format = Format::Static) {
  Bytes out(kTensorHeaderBytes);
  TensorHeader header{spec, format, MediaType::Video, 0};
  write_tensor_header(header, std::as_writable_bytes(std::span(out)).first<kTensorHeaderBytes>());
  out.insert(out.end(), payload.begin(), payload.end());
  return out;
}

}  // namespace weir::testing_converters
