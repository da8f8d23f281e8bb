// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tflite-file/tflite_graph.hpp"

#include <algorithm>

#include "tflite-file/tflite_file.hpp"

namespace weir::engine {
namespace {

template <class To, class From = To>
std::vector<To> list(const FlatVector& values) {
  std::vector<To> out;
  out.reserve(values.size());
  for (uint32_t i = 0; i < values.size(); ++i)
    out.push_back(static_cast<To>(values.scalar<From>(i)));
  return out;
}

TfliteGraphTensor read_tensor(const FlatTable& table, const FlatVector& buffers) {
  TfliteGraphTensor out;
  out.name = table.string(3).text();
  out.type = static_cast<TfliteType>(table.scalar<uint8_t>(1, 0));
  out.shape = list<int64_t, int32_t>(table.vector(0, 4));
  out.variable = table.scalar<uint8_t>(5, 0) != 0;
  const FlatTable quantization = table.table(4);
  out.scale = list<float>(quantization.vector(2, 4));
  out.zero_point = list<int64_t>(quantization.vector(3, 8));
  out.axis = quantization.scalar<int32_t>(6, 0);
  if (!table.table(6))  // a sparse tensor is not plain bytes
    out.data = buffers.table(table.scalar<uint32_t>(2, 0)).vector(0, 1).bytes();
  return out;
}

TfliteGraphOperator read_operator(const FlatTable& table, const FlatVector& codes) {
  const FlatTable code = codes.table(table.scalar<uint32_t>(0, 0));
  TfliteGraphOperator out;
  out.code = std::max<int32_t>(code.scalar<int8_t>(0, 0), code.scalar<int32_t>(3, 0));
  out.custom = code.string(1).text();
  out.inputs = list<int32_t>(table.vector(1, 4));
  out.outputs = list<int32_t>(table.vector(2, 4));
  out.options = table.table(4);
  return out;
}

}  // namespace

Result<TfliteGraph> read_tflite_graph(std::span<const std::byte> bytes) {
  if (const auto checked = read_tflite(bytes); !checked) return checked.error();
  TfliteGraph out;
  out.file = std::make_unique<FlatFile>(bytes);
  const FlatTable model = out.file->root();
  const FlatTable graph = model.vector(2, 4).table(0);
  const FlatVector tensors = graph.vector(0, 4), operators = graph.vector(3, 4);
  const FlatVector buffers = model.vector(4, 4), codes = model.vector(1, 4);
  for (uint32_t i = 0; i < tensors.size(); ++i)
    out.tensors.push_back(read_tensor(tensors.table(i), buffers));
  for (uint32_t i = 0; i < operators.size(); ++i)
    out.operators.push_back(read_operator(operators.table(i), codes));
  out.inputs = list<int32_t>(graph.vector(1, 4));
  out.outputs = list<int32_t>(graph.vector(2, 4));
  return out;
}

}  // namespace weir::engine
