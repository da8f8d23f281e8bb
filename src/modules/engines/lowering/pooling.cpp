// Lowers pooling, channels last. Pooling keeps the quantisation.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lowering/operator_parts.hpp"
#include "lowering/operators.hpp"

namespace weir::engine {
namespace {

struct Pool {
  Window window;
  std::array<int64_t, 4> pads;
  std::string data;
  int8_t activation;
};

Result<Pool> read_pool(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 1, 1); !status) return status.error();
  Pool out{Window::of(op.options), {}, {}, op.options.scalar<int8_t>(5, 0)};
  out.window.size = {op.options.scalar<int32_t>(4, 0), op.options.scalar<int32_t>(3, 0)};
  const auto& input = graph.tensor(op.inputs[0]);
  const auto& output = graph.tensor(op.outputs[0]);
  const auto pads = out.window.pads(input, output);
  if (!pads) return pads.error();
  if (input.shape[3] != output.shape[3]) return refuse("a pool that changes the channels").error();
  out.pads = *pads;
  auto data = graph.value(op.inputs[0]);
  if (!data) return data.error();
  out.data = *std::move(data);
  return out;
}

OnnxAttributes permutation(const std::array<int64_t, 4>& axes) {
  return OnnxAttributes().numbers("perm", axes);
}

}  // namespace

// TensorFlow Lite rounds half away from zero, for uint8 up. A mean of n integers is a half or
// differs from it by at least 1/n, so adding a quarter of that rounds halves correctly.
Status lower_average_pool(LoweredGraph& graph, const TfliteGraphOperator& op) {
  const auto pool = read_pool(graph, op);
  if (!pool) return pool.error();
  if (!graph.is_8bit(op.inputs[0])) return refuse("a pool over values that are not 8-bit");
  const auto& input = graph.tensor(op.inputs[0]).shape;
  const auto& size = pool->window.size;
  const bool is_signed = graph.tensor(op.inputs[0]).type == TfliteType::kInt8;
  const auto one = graph.scale(1), zero = graph.zero_point(is_signed ? 128 : 0);
  const auto real = graph.made("DequantizeLinear", {pool->data, one, zero});
  auto beyond = graph.scale(0.25f / static_cast<float>(size[0] * size[1]));
  const bool whole =
      size[0] == input[1] && size[1] == input[2] && pool->pads == std::array<int64_t, 4>{};
  std::string mean;
  if (whole) {
    mean = graph.made("ReduceMean", {real},
                      OnnxAttributes().numbers("axes", std::array<int64_t, 2>{1, 2}));
  } else {
    const auto first = graph.made("Transpose", {real}, permutation({0, 3, 1, 2}));
    const auto means = graph.made("AveragePool", {first},
                                  OnnxAttributes()
                                      .numbers("kernel_shape", size)
                                      .numbers("strides", pool->window.stride)
                                      .numbers("pads", pool->pads)
                                      .number("count_include_pad", 0));
    mean = graph.made("Transpose", {means}, permutation({0, 2, 3, 1}));
  }
  if (is_signed) beyond = graph.made("Mul", {graph.made("Sign", {mean}), beyond});
  return node_with_activation(graph, "QuantizeLinear", "",
                              {graph.made("Add", {mean, beyond}), one, zero}, op.outputs[0], {},
                              pool->activation);
}

Status lower_max_pool(LoweredGraph& graph, const TfliteGraphOperator& op) {
  const auto pool = read_pool(graph, op);
  if (!pool) return pool.error();
  if (!graph.is_8bit(op.inputs[0])) return refuse("a pool over values that are not 8-bit");
  return node_with_activation(graph, "NhwcMaxPool", kMicrosoft, {pool->data}, op.outputs[0],
                              OnnxAttributes()
                                  .numbers("kernel_shape", pool->window.size)
                                  .numbers("strides", pool->window.stride)
                                  .numbers("pads", pool->pads),
                              pool->activation);
}

}  // namespace weir::engine
