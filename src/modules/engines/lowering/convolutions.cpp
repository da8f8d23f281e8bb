// Lowers convolutions and fully connected layers: QLinearConv with channels last, QGemm.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <array>
#include <cmath>

#include "lowering/operator_parts.hpp"
#include "lowering/operators.hpp"
#include "lowering/rounding.hpp"
#include "lowering/weights.hpp"

namespace weir::engine {
namespace {

using Extents = std::array<int64_t, 4>;
constexpr Extents kChannelsFirst{0, 3, 1, 2}, kChannelsLast{0, 2, 3, 1};
constexpr std::array<int64_t, 2> kOnes{1, 1};

// Permutes axes: `from` lists the axes of the source in their new order.
template <class T>
std::vector<T> transposed(const T* data, const Extents& shape, const Extents& from) {
  const Extents steps{shape[1] * shape[2] * shape[3], shape[2] * shape[3], shape[3], 1};
  const auto extent = [&](size_t i) { return shape[static_cast<size_t>(from[i])]; };
  const auto step = [&](size_t i) { return steps[static_cast<size_t>(from[i])]; };
  std::vector<T> out;
  out.reserve(static_cast<size_t>(steps[0] * shape[0]));
  for (int64_t i = 0; i < extent(0); ++i)
    for (int64_t j = 0; j < extent(1); ++j)
      for (int64_t k = 0; k < extent(2); ++k)
        for (int64_t l = 0; l < extent(3); ++l)
          out.push_back(data[i * step(0) + j * step(1) + k * step(2) + l * step(3)]);
  return out;
}

std::string bias_name(LoweredGraph& graph, const std::vector<int32_t>& bias) {
  const auto count = static_cast<int64_t>(bias.size());
  return graph.int32_constant({&count, 1},
                              {reinterpret_cast<const char*>(bias.data()), 4 * bias.size()});
}

// The first inputs of QLinear operators with weights, up to and including the output's zero point.
Result<std::vector<std::string>> quantized_inputs(LoweredGraph& graph,
                                                  const TfliteGraphOperator& op,
                                                  const std::string& data, const Weights& weights,
                                                  const std::string& weight_name) {
  const auto in = graph.quantization(op.inputs[0]), out = graph.quantization(op.outputs[0]);
  if (!in) return in.error();
  if (!out) return out.error();
  return std::vector<std::string>{data,
                                  graph.scale(in->scale),
                                  graph.zero_point(in->zero_point),
                                  weight_name,
                                  graph.scales(weights.scale),
                                  graph.zero_point(weights.zero_point),
                                  graph.scale(out->scale),
                                  graph.zero_point(out->zero_point)};
}

// The rounding of a uint8 operator. TensorFlow Lite multiplies the input's and weights' scales in
// single precision.
Result<Rounding> operator_rounding(const LoweredGraph& graph, const TfliteGraphOperator& op,
                                   const Weights& weights, const std::vector<int32_t>& bias) {
  const auto in = graph.quantization(op.inputs[0]), out = graph.quantization(op.outputs[0]);
  if (!in) return in.error();
  if (!out) return out.error();
  const auto product = static_cast<double>(in->scale * weights.scale[0]);
  const double multiplier = product / static_cast<double>(out->scale);
  if (!std::isnormal(multiplier)) return refuse("scales that cannot be multiplied").error();
  int64_t largest = 0;
  for (const int64_t each : bias) largest = std::max(largest, std::abs(each));
  return make_rounding(multiplier, out->zero_point, largest);
}

std::string bias_name(LoweredGraph& graph, const std::vector<int32_t>& bias, float added) {
  std::vector<float> sums(bias.size());
  for (size_t i = 0; i < sums.size(); ++i) sums[i] = static_cast<float>(bias[i]) + added;
  const auto count = static_cast<int64_t>(bias.size());
  return graph.floats({&count, 1}, sums);
}

// Matrix product with uint8 weights [inputs, outputs]: integer sums, rounded in floating point.
Status product(LoweredGraph& graph, const TfliteGraphOperator& op, const std::string& data,
               const std::array<int64_t, 2>& shape, const Weights& weights,
               const std::vector<int32_t>& bias, int8_t activation) {
  const auto in = graph.quantization(op.inputs[0]);
  if (!in) return in.error();
  const auto rounding = operator_rounding(graph, op, weights, bias);
  if (!rounding) return rounding.error();
  const std::string sums = graph.fresh(), one = graph.scale(1);
  graph.node("MatMulIntegerToFloat", kMicrosoft,
             {data, graph.bytes(shape, weights.data), one, one, graph.zero_point(in->zero_point),
              graph.zero_point(weights.zero_point), bias_name(graph, bias, rounding->added)},
             sums);
  const auto out = graph.quantization(op.outputs[0]);
  if (!out) return out.error();
  return node_with_activation(
      graph, "QuantizeLinear", "",
      {sums, graph.scale(rounding->scale), graph.zero_point(out->zero_point)}, op.outputs[0], {},
      activation);
}

// Convolution with uint8 weights, outputs first, in floats: they hold the integers exactly.
Status real_convolution(LoweredGraph& graph, const TfliteGraphOperator& op, const std::string& data,
                        const Extents& shape, const Weights& weights,
                        const std::vector<int32_t>& bias, const OnnxAttributes& attributes,
                        int8_t activation) {
  const auto in = graph.quantization(op.inputs[0]);
  if (!in) return in.error();
  const auto rounding = operator_rounding(graph, op, weights, bias);
  if (!rounding) return rounding.error();
  std::vector<float> real(weights.data.size());
  for (size_t i = 0; i < real.size(); ++i)
    real[i] = static_cast<float>(static_cast<uint8_t>(weights.data[i]) - weights.zero_point);
  // Transposes before dequantising, because bytes are cheaper to move than floats.
  const auto first =
      graph.made("Transpose", {data}, OnnxAttributes().numbers("perm", kChannelsFirst));
  const auto values =
      graph.made("DequantizeLinear", {first, graph.scale(1), graph.zero_point(in->zero_point)});
  const auto sums = graph.made(
      "Conv", {values, graph.floats(shape, real), bias_name(graph, bias, rounding->added)},
      attributes);
  const auto out = graph.quantization(op.outputs[0]);
  if (!out) return out.error();
  const auto rounded = graph.made(
      "QuantizeLinear", {sums, graph.scale(rounding->scale), graph.zero_point(out->zero_point)});
  return node_with_activation(graph, "Transpose", "", {rounded}, op.outputs[0],
                              OnnxAttributes().numbers("perm", kChannelsLast), activation);
}

struct ConvolutionKind {
  int32_t channel_axis;  // axis of the weights' output channels
  Extents order;         // axes of the weights in the order of QLinearConv
  int64_t groups, channels;
  int8_t activation;
};

Status convolution(LoweredGraph& graph, const TfliteGraphOperator& op, Window window,
                   const ConvolutionKind& kind) {
  const auto& input = graph.tensor(op.inputs[0]);
  const auto& output = graph.tensor(op.outputs[0]);
  const auto& filter = graph.tensor(op.inputs[1]);
  window.size = {filter.shape[1], filter.shape[2]};
  const auto pads = window.pads(input, output);
  if (!pads) return pads.error();
  if (output.shape[3] != kind.channels) return refuse("more channels than there are weights");
  auto weights = read_weights(graph, op.inputs[1], kind.channel_axis, kind.channels);
  if (!weights) return weights.error();
  auto bias = read_bias(graph, op, 2, kind.channels);
  if (!bias) return bias.error();
  const auto data = graph.value(op.inputs[0]);
  if (!data) return data.error();
  const Extents shape{filter.shape[0], filter.shape[1], filter.shape[2], filter.shape[3]};
  const bool pointwise = kind.groups == 1 && window.size == kOnes && window.stride == kOnes;
  if (!weights->is_signed && pointwise) {
    const auto columns = transposed(weights->data.data(), shape, {3, 0, 1, 2});
    weights->data.assign(columns.data(), columns.size());
    return product(graph, op, *data, {shape[3], shape[0]}, *weights, *bias, kind.activation);
  }
  const auto ordered = transposed(weights->data.data(), shape, kind.order);
  weights->data.assign(ordered.data(), ordered.size());
  Extents ordered_shape{};
  for (size_t i = 0; i < 4; ++i) ordered_shape[i] = shape[static_cast<size_t>(kind.order[i])];
  auto attributes = OnnxAttributes()
                        .numbers("kernel_shape", window.size)
                        .numbers("strides", window.stride)
                        .numbers("dilations", window.dilation)
                        .numbers("pads", *pads)
                        .number("group", kind.groups);
  if (!weights->is_signed)
    return real_convolution(graph, op, *data, ordered_shape, *weights, *bias, attributes,
                            kind.activation);
  auto inputs =
      quantized_inputs(graph, op, *data, *weights, graph.bytes(ordered_shape, weights->data));
  if (!inputs) return inputs.error();
  inputs->push_back(bias_name(graph, *bias));
  return node_with_activation(graph, "QLinearConv", kMicrosoft, *inputs, op.outputs[0],
                              attributes.number("channels_last", 1), kind.activation);
}

// Checks that input and weights have four axes, none of them empty.
Status check_pictures(const LoweredGraph& graph, const TfliteGraphOperator& op) {
  for (const size_t i : {0u, 1u}) {
    const auto& shape = graph.tensor(op.inputs[i]).shape;
    if (shape.size() != 4 ||
        std::any_of(shape.begin(), shape.end(), [](int64_t e) { return e < 1; }))
      return refuse("an input or weights without four axes");
  }
  return ok();
}

}  // namespace

Status lower_convolution(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 2, 3); !status) return status;
  if (auto status = check_pictures(graph, op); !status) return status;
  const auto& filter = graph.tensor(op.inputs[1]).shape;  // outputs, height, width, inputs
  const int64_t channels_in = graph.tensor(op.inputs[0]).shape[3];
  Window window = Window::of(op.options);
  window.dilation = {op.options.scalar<int32_t>(5, 1), op.options.scalar<int32_t>(4, 1)};
  const int64_t groups = channels_in / filter[3];
  if (groups < 1 || groups * filter[3] != channels_in || filter[0] % groups != 0)
    return refuse("weights for a different number of channels");
  return convolution(graph, op, window,
                     {0, {0, 3, 1, 2}, groups, filter[0], op.options.scalar<int8_t>(3, 0)});
}

Status lower_depthwise_convolution(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 2, 3); !status) return status;
  if (auto status = check_pictures(graph, op); !status) return status;
  const auto& filter = graph.tensor(op.inputs[1]).shape;  // 1, height, width, outputs
  const int64_t channels_in = graph.tensor(op.inputs[0]).shape[3];
  Window window = Window::of(op.options);
  window.dilation = {op.options.scalar<int32_t>(6, 1), op.options.scalar<int32_t>(5, 1)};
  if (filter[0] != 1 || filter[3] % channels_in != 0)
    return refuse("weights for a different number of channels");
  return convolution(graph, op, window,
                     {3, {3, 0, 1, 2}, channels_in, filter[3], op.options.scalar<int8_t>(4, 0)});
}

Status lower_fully_connected(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 2, 3); !status) return status;
  const auto& filter = graph.tensor(op.inputs[1]).shape;
  const auto& output = graph.tensor(op.outputs[0]).shape;
  if (filter.size() != 2 || filter[0] < 1 || filter[1] < 1 || output.empty() ||
      op.options.scalar<int8_t>(1, 0) != 0)
    return refuse("weights that are not a plain matrix");
  const auto elements = [](const std::vector<int64_t>& shape) {
    int64_t out = 1;
    for (const int64_t extent : shape) out *= extent;
    return out;
  };
  const int64_t given = elements(graph.tensor(op.inputs[0]).shape);
  if (given % filter[1] != 0 || elements(output) != given / filter[1] * filter[0])
    return refuse("an input or output that does not fit the weights");
  auto weights = read_weights(graph, op.inputs[1], 0, filter[0]);
  if (!weights) return weights.error();
  auto bias = read_bias(graph, op, 2, filter[0]);
  if (!bias) return bias.error();
  const auto data = graph.value(op.inputs[0]);
  if (!data) return data.error();
  const std::array<int64_t, 2> flat{given / filter[1], filter[1]};
  const auto rows = graph.made("Reshape", {*data, graph.shape(flat)});
  if (!weights->is_signed && output.size() == 2) {
    const auto columns =
        transposed(weights->data.data(), {filter[0], filter[1], 1, 1}, {1, 0, 2, 3});
    weights->data.assign(columns.data(), columns.size());
    return product(graph, op, rows, {filter[1], filter[0]}, *weights, *bias,
                   op.options.scalar<int8_t>(0, 0));
  }
  auto inputs = quantized_inputs(graph, op, rows, *weights, graph.bytes(filter, weights->data));
  if (!inputs) return inputs.error();
  inputs->insert(inputs->begin() + 6,
                 bias_name(graph, *bias));  // QGemm takes the bias before the output's scale
  const auto name = graph.value(op.outputs[0]);
  if (!name) return name.error();
  const std::string product = graph.fresh();
  graph.node("QGemm", kMicrosoft, *inputs, product, OnnxAttributes().number("transB", 1));
  return node_with_activation(graph, "Reshape", "", {product, graph.shape(output)}, op.outputs[0],
                              {}, op.options.scalar<int8_t>(0, 0));
}

namespace {

OnnxAttributes transposed_attributes(const Window& window, const std::vector<int64_t>& input,
                                     const std::vector<int64_t>& output) {
  std::array<int64_t, 4> pads{};
  std::array<int64_t, 2> beyond{};
  for (const size_t axis : {0u, 1u}) {
    const int64_t reach = (input[axis + 1] - 1) * window.stride[axis] + window.size[axis];
    const int64_t total = std::max<int64_t>(reach - output[axis + 1], 0);
    pads[axis] = total / 2;
    pads[axis + 2] = total - total / 2;
    beyond[axis] = std::max<int64_t>(output[axis + 1] - reach, 0);
  }
  return std::move(OnnxAttributes()
                       .numbers("kernel_shape", window.size)
                       .numbers("strides", window.stride)
                       .numbers("pads", pads)
                       .numbers("output_padding", beyond));
}

}  // namespace

// Computed in floats, because ONNX has no quantised transposed convolution.
Status lower_transposed_convolution(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 3, 4); !status) return status;
  TfliteGraphOperator plain = op;
  plain.inputs = {op.inputs[2], op.inputs[1]};
  if (auto status = check_pictures(graph, plain); !status) return status;
  const auto& input = graph.tensor(op.inputs[2]).shape;
  const auto& filter = graph.tensor(op.inputs[1]).shape;  // outputs, height, width, inputs
  const auto& output = graph.tensor(op.outputs[0]).shape;
  if (output.size() != 4 || filter[3] != input[3] || filter[0] != output[3] ||
      input[0] != output[0])
    return refuse("weights for a different number of channels");
  Window window = Window::of(op.options);
  window.size = {filter[1], filter[2]};
  // Checks the padding of the inverse: the convolution from this output to this input.
  TfliteGraphTensor made, given;
  made.shape = output;
  given.shape = input;
  if (const auto fits = window.pads(made, given); !fits) return fits.error();
  const auto weights = read_weights(graph, op.inputs[1], 0, filter[0]);
  if (!weights) return weights.error();
  const auto bias = read_bias(graph, op, 3, filter[0]);
  if (!bias) return bias.error();
  const auto in = graph.quantization(op.inputs[2]), out = graph.quantization(op.outputs[0]);
  if (!in) return in.error();
  if (!out) return out.error();
  const auto data = graph.value(op.inputs[2]);
  if (!data) return data.error();

  const Extents shape{filter[0], filter[1], filter[2], filter[3]};
  std::vector<float> real(weights->data.size());
  const size_t each = real.size() / static_cast<size_t>(filter[0]);
  const auto get_scale = [&](size_t channel) {
    return weights->scale[weights->scale.size() == 1 ? 0 : channel];
  };
  for (size_t i = 0; i < real.size(); ++i)
    real[i] = get_scale(i / each) *
              static_cast<float>(static_cast<uint8_t>(weights->data[i]) - int{weights->zero_point});
  const Extents inputs_first{filter[3], filter[0], filter[1], filter[2]};
  std::vector<std::string> inputs{
      graph.made("Transpose",
                 {graph.made("DequantizeLinear",
                             {*data, graph.scale(in->scale), graph.zero_point(in->zero_point)})},
                 OnnxAttributes().numbers("perm", kChannelsFirst)),
      graph.floats(inputs_first, transposed(real.data(), shape, {3, 0, 1, 2}))};
  std::vector<float> added(bias->size());
  for (size_t i = 0; i < added.size(); ++i)
    added[i] = in->scale * get_scale(i) * static_cast<float>((*bias)[i]);
  inputs.push_back(graph.floats({&filter[0], 1}, added));
  const std::string product = graph.fresh();
  graph.node("ConvTranspose", "", inputs, product, transposed_attributes(window, input, output));
  const std::string last =
      graph.made("Transpose", {product}, OnnxAttributes().numbers("perm", kChannelsLast));
  return node_with_activation(graph, "QuantizeLinear", "",
                              {last, graph.scale(out->scale), graph.zero_point(out->zero_point)},
                              op.outputs[0], {}, op.options.scalar<int8_t>(3, 0));
}

}  // namespace weir::engine
