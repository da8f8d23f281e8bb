// Test helpers: runs a mode that writes results as the host does, with the facts that tensor_filter
// gives and with source maps, and reads what it writes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <list>

#include "core/decoders/decoder_test_support.hpp"
#include "core/tensor/tensor_header.hpp"
#include "weir/abi.h"
#include "weir/results.hpp"
#include "weir/source_map.hpp"

namespace weir::decoders {

// What tensor_filter says of a model, for the outputs that a test passes.
struct TestModel {
  std::string path = "/models/test.onnx";
  std::string metadata{};             // JSON
  std::string input = "3:640:640:1";  // uint8, dimensions as in caps
  std::vector<std::string> names{};   // of the outputs
  std::vector<float> scales{};        // of the outputs; none = not quantised
  std::vector<int32_t> zero_points{};
};

// One tensor of a frame of results.
struct ResultTensor {
  weir_result_columns columns{};
  TensorSpec spec;
  Bytes payload;

  std::vector<float> floats() const {
    std::vector<float> out(payload.size() / sizeof(float));
    std::memcpy(out.data(), payload.data(), out.size() * sizeof(float));
    return out;
  }
};

class ResultsRun {
 public:
  ResultsRun(const std::string& mode, const DecoderOptions& options)
      : decoder_(open_decoder(mode, options, &error)) {}

  // Passes the model and, unless the stream is flexible, its outputs.
  bool configure(const std::vector<TestTensor>& tensors, const TestModel* model = nullptr,
                 bool is_flexible = false) {
    if (!decoder_) return false;
    std::vector<weir_tensor_info> outputs;
    for (size_t i = 0; i < tensors.size(); ++i) {
      outputs.push_back(tensors[i].info());
      if (!model) continue;
      if (i < model->names.size()) outputs.back().name = model->names[i].c_str();
      if (i < model->scales.size()) outputs.back().scale = model->scales[i];
      if (i < model->zero_points.size()) outputs.back().zero_point = model->zero_points[i];
    }
    if (model) {
      const weir_tensor_info input = TestTensor(ElementType::UInt8, model->input, Bytes{}).info();
      const weir_stream_model facts{sizeof facts,
                                    1,
                                    uint32_t(outputs.size()),
                                    &input,
                                    outputs.data(),
                                    model->path.c_str(),
                                    model->metadata.empty() ? nullptr : model->metadata.c_str(),
                                    nullptr,
                                    0};
      decoder_->set_model(&facts);
    } else {
      decoder_->set_model(nullptr);
    }
    for (auto& output : outputs) output.name = nullptr, output.scale = 0, output.zero_point = 0;
    if (is_flexible) outputs.clear();
    TestSink sink;
    const auto status = decoder_->configure(outputs, &sink);
    caps = sink.caps;
    error = status ? "" : status.error().message();
    return bool(status);
  }

  // Decodes a frame; `maps` are of the picture, or of regions.
  const std::vector<ResultTensor>& decode(const std::vector<TestTensor>& tensors,
                                          const std::vector<SourceMap>& maps = {},
                                          bool of_regions = false) {
    results.clear();
    if (!decoder_) return results;
    std::vector<weir_tensor> memory;
    for (const auto& tensor : tensors) memory.push_back(tensor.tensor());
    std::vector<weir_source_map> abi_maps;
    for (const auto& map : maps) abi_maps.push_back(abi_map(map));
    weir_frame frame{};
    frame.struct_size = sizeof frame;
    frame.n_tensors = static_cast<uint32_t>(memory.size());
    frame.tensors = memory.data();
    frame.n_maps = static_cast<uint32_t>(abi_maps.size());
    frame.maps = abi_maps.data();
    frame.maps_of = of_regions ? WEIR_MAPS_OF_REGIONS : WEIR_MAPS_OF_TENSORS;
    TestSink sink;
    const auto kept = decoder_->decode(frame, &sink);
    error = kept ? "" : kept.error().message();
    if (!sink.caps.empty()) caps = sink.caps;
    if (kept && *kept) read_results(sink.memories);
    return results;
  }

  // Row `index` of tensor `tensor`.
  ResultRow row(size_t index, size_t tensor = 0) {
    rows_.push_back(results.at(tensor).floats());
    const auto& columns = results.at(tensor).columns;
    return {columns, rows_.back().data() + index * columns.length};
  }
  size_t n_rows(size_t tensor = 0) const { return results.at(tensor).spec.shape[1]; }

  std::string caps, error;  // error: "" after success
  std::vector<ResultTensor> results;

 private:
  std::string columns_text() const {
    const std::string field = "weir-columns=(string)\"";
    const size_t begin = caps.find(field) + field.size();
    return caps.substr(begin, caps.find('"', begin) - begin);
  }
  void read_results(const std::list<Bytes>& memories) {
    uint32_t index = 0;
    for (const Bytes& memory : memories) {
      const auto header = read_tensor_chunk(std::as_bytes(std::span(memory)));
      ASSERT_TRUE(header);
      const auto columns = result_columns(columns_text(), index++);
      ASSERT_TRUE(columns) << caps;
      results.push_back({.columns = *columns,
                         .spec = header->spec,
                         .payload = {memory.begin() + kTensorHeaderBytes, memory.end()}});
    }
  }

  std::unique_ptr<infer::Decoder> decoder_;
  std::list<std::vector<float>> rows_;
};

}  // namespace weir::decoders
