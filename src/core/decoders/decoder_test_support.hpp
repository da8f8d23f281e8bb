// Test helpers: runs a built-in decoder as the host does and records its output.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <list>
#include <memory>
#include <string>
#include <vector>

#include "core/decoders/decoders.hpp"
#include "core/infer/module/decoder.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/tensor/frame_spec.hpp"
#include "says.hpp"

namespace weir::decoders {

using Bytes = std::vector<uint8_t>;
using DecoderOptions = infer::Decoder::Options;

// Dimensions as in caps ("4:10:1", innermost first) and the bytes of the elements.
struct TestTensor {
  template <class T>
  TestTensor(ElementType element_type, std::string dimensions, const std::vector<T>& values)
      : type(element_type), shape(std::move(dimensions)), bytes(values.size() * sizeof(T)) {
    if (!bytes.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  }
  TestTensor(std::string dimensions, const std::vector<float>& values)
      : TestTensor(ElementType::Float32, std::move(dimensions), values) {}

  weir_tensor_info info() const {
    weir_tensor_info out{};
    const Shape parsed = Shape::parse(shape);
    out.type = static_cast<uint32_t>(type);
    out.rank = static_cast<uint32_t>(parsed.rank());
    for (uint32_t i = 0; i < out.rank; ++i) out.shape[i] = parsed[out.rank - 1 - i];
    return out;
  }
  weir_tensor tensor() const {
    weir_tensor out{};
    out.data = const_cast<uint8_t*>(bytes.data());
    out.bytes = out.capacity = bytes.size();
    out.info = info();
    return out;
  }

  ElementType type;
  std::string shape;
  Bytes bytes;
};

// Null with the reason in `error` if the decoder refuses the options.
inline std::unique_ptr<infer::Decoder> open_decoder(const std::string& mode,
                                                    const DecoderOptions& options,
                                                    std::string* error) {
  infer::ModuleLibrary library;
  library.add_builtin(&builtin_decoders());
  const auto type = library.decoder(mode);
  auto opened = type ? infer::Decoder::open(**type, options)
                     : Result<std::unique_ptr<infer::Decoder>>(type.error());
  if (opened) return *std::move(opened);
  *error = opened.error().message();
  return nullptr;
}

// The caps and the memories that a decoder writes.
struct TestSink final : weir_sink {
  Status set_caps(const std::string& text) override {
    caps = text;
    return ok();
  }
  void* reserve(uint64_t bytes) override {
    memories.emplace_back(bytes, 0xAA);  // memory is not cleared for decoders
    return memories.back().data();
  }
  Status share_input(uint32_t) override { return ok(); }

  std::string caps;
  std::list<Bytes> memories;
};

// An open decoder with its last caps, output and error.
class TestDecoder {
 public:
  TestDecoder(const std::string& mode, const DecoderOptions& options)
      : decoder_(open_decoder(mode, options, &error)) {}
  // Returns whether the decoder takes the tensors.
  bool configure(const std::vector<TestTensor>& tensors) {
    if (!decoder_) return false;
    std::vector<weir_tensor_info> infos;
    for (const auto& tensor : tensors) infos.push_back(tensor.info());
    TestSink sink;
    const auto status = decoder_->configure(infos, &sink);
    error = status ? "" : status.error().message();
    caps = sink.caps;
    return bool(status);
  }
  // As tensor_filter describes a model with these outputs, quantised alike.
  void set_model(const std::vector<TestTensor>& outputs, float scale, int32_t zero_point) {
    std::vector<weir_tensor_info> infos;
    for (const auto& output : outputs) {
      infos.push_back(output.info());
      infos.back().scale = scale;
      infos.back().zero_point = zero_point;
    }
    const weir_stream_model model{.struct_size = sizeof model,
                                  .n_inputs = 0,
                                  .n_outputs = static_cast<uint32_t>(infos.size()),
                                  .inputs = nullptr,
                                  .outputs = infos.data(),
                                  .path = "/models/test.tflite",
                                  .metadata_json = nullptr,
                                  .card_labels = nullptr,
                                  .n_card_labels = 0};
    decoder_->set_model(&model);
  }
  // Decodes a frame without configure(), as for flexible streams.
  const Bytes& decode(const std::vector<TestTensor>& tensors) {
    std::vector<weir_tensor> memory;
    for (const auto& tensor : tensors) memory.push_back(tensor.tensor());
    return decode_memory(std::move(memory));
  }
  const Bytes& decode_memory(std::vector<weir_tensor> memory) {
    output.clear();
    if (!decoder_) return output;
    weir_frame frame{};
    frame.struct_size = sizeof frame;
    frame.n_tensors = static_cast<uint32_t>(memory.size());
    frame.tensors = memory.empty() ? nullptr : memory.data();
    TestSink sink;
    const auto kept = decoder_->decode(frame, &sink);
    error = kept ? "" : kept.error().message();
    if (!sink.caps.empty()) caps = sink.caps;
    if (!sink.memories.empty()) output = std::move(sink.memories.back());
    return output;
  }
  void reset() { decoder_->reset(); }

  std::string caps, error;  // error: "" after success
  Bytes output;

 private:
  std::unique_ptr<infer::Decoder> decoder_;
};

// Why the decoder refuses the options or the frame; "" if it does not.
inline std::string error_of(const std::string& mode, const DecoderOptions& options,
                            const std::vector<TestTensor>& tensors) {
  TestDecoder decoder(mode, options);
  if (decoder.error.empty() && decoder.configure(tensors)) decoder.decode(tensors);
  return decoder.error;
}

// Writes a text file for the test and returns its path.
inline std::string file_with(const std::string& name, const std::string& text) {
  const std::string path = testing::TempDir() + "weir-decoder-" + name;
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

// Collects log lines "LEVEL module: text" of modules until the end of the scope.
struct LogLines {
  LogLines() {
    lines.clear();
    infer::set_log_function([](int level, const char* module, const char* text) {
      lines.push_back(std::to_string(level) + " " + module + ": " + text);
    });
  }
  ~LogLines() { infer::set_log_function(nullptr); }
  LogLines(const LogLines&) = delete;
  LogLines& operator=(const LogLines&) = delete;
  static inline std::vector<std::string> lines;
};

}  // namespace weir::decoders
