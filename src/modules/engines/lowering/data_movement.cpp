// Lowers operators that move values without computing.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>

#include "lowering/operator_parts.hpp"
#include "lowering/operators.hpp"

namespace weir::engine {
namespace {

int64_t elements(const TfliteGraphTensor& tensor) {
  int64_t out = 1;
  for (const int64_t extent : tensor.shape) out *= extent;
  return out;
}

struct Ends {
  std::string in, out;  // value names
};
// For operators whose first input and output have the same type.
Result<Ends> get_ends(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (graph.tensor(op.inputs[0]).type != graph.tensor(op.outputs[0]).type)
    return refuse("an output whose type differs from the input's").error();
  auto in = graph.value(op.inputs[0]);
  if (!in) return in.error();
  auto out = graph.value(op.outputs[0]);
  if (!out) return out.error();
  return Ends{*std::move(in), *std::move(out)};
}

}  // namespace

Status lower_reshape(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 1, 2); !status) return status;
  const auto ends = get_ends(graph, op);
  if (!ends) return ends.error();
  const auto& output = graph.tensor(op.outputs[0]);
  if (elements(output) != elements(graph.tensor(op.inputs[0])) || elements(output) == 0)
    return refuse("an output with a different number of elements");
  graph.node("Reshape", "", {ends->in, graph.shape(output.shape)}, ends->out);
  return ok();
}

namespace {

// Concatenates tensors that are not quantised.
Status concatenate_numbers(LoweredGraph& graph, const TfliteGraphOperator& op,
                           const OnnxAttributes& along) {
  std::vector<std::string> names;
  for (const int32_t input : op.inputs) {
    if (input < 0) return refuse("an input is missing");
    if (graph.tensor(input).type != graph.tensor(op.outputs[0]).type)
      return refuse("an output whose type differs from the input's");
    const auto name = graph.value(input);
    if (!name) return name.error();
    names.push_back(*name);
  }
  const auto out = graph.value(op.outputs[0]);
  if (!out) return out.error();
  graph.node("Concat", "", names, *out, along);
  return ok();
}

Status concatenate_quantized(LoweredGraph& graph, const TfliteGraphOperator& op,
                             const OnnxAttributes& along, int8_t activation) {
  std::vector<std::string> plain;
  const auto made = graph.quantization(op.outputs[0]);
  if (!made) return made.error();
  std::vector<Quantization> scales;
  for (const int32_t input : op.inputs) {
    if (input < 0) return refuse("an input is missing");
    const auto q = graph.quantization(input);
    if (!q) return q.error();
    const auto name = graph.value(input);
    if (!name) return name.error();
    plain.push_back(*name);
    scales.push_back(*q);
  }
  if (std::all_of(scales.begin(), scales.end(), [&](const auto& q) { return q == *made; }))
    return node_with_activation(graph, "Concat", "", plain, op.outputs[0], along, activation);
  std::vector<std::string> scaled{graph.scale(made->scale), graph.zero_point(made->zero_point)};
  for (size_t i = 0; i < plain.size(); ++i)
    scaled.insert(scaled.end(),
                  {plain[i], graph.scale(scales[i].scale), graph.zero_point(scales[i].zero_point)});
  return node_with_activation(graph, "QLinearConcat", kMicrosoft, scaled, op.outputs[0], along,
                              activation);
}

}  // namespace

Status lower_concatenation(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 1, 1024); !status) return status;
  const auto rank = static_cast<int64_t>(graph.tensor(op.outputs[0]).shape.size());
  auto axis = op.options.scalar<int32_t>(0, 0);
  if (axis < 0) axis += static_cast<int32_t>(rank);
  if (axis < 0 || axis >= rank) return refuse("an axis that does not exist");
  const auto along = OnnxAttributes().number("axis", axis);
  const auto activation = op.options.scalar<int8_t>(1, 0);
  if (!graph.is_8bit(op.outputs[0])) {
    if (activation != 0) return refuse("a fused activation of numbers that are not quantised");
    return concatenate_numbers(graph, op, along);
  }
  return concatenate_quantized(graph, op, along, activation);
}

Status lower_pad(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 2, 2); !status) return status;
  const auto ends = get_ends(graph, op);
  if (!ends) return ends.error();
  const bool is_real = graph.tensor(op.outputs[0]).type == TfliteType::kFloat32;
  std::string padding = graph.scale(0);
  if (!is_real) {
    const auto q = graph.quantization(op.outputs[0]);
    if (!q) return q.error();
    padding = graph.zero_point(q->zero_point);
  }
  const auto given = graph.integers(op.inputs[1]);  // before and after, per axis
  if (!given) return given.error();
  const auto& input = graph.tensor(op.inputs[0]).shape;
  const auto& output = graph.tensor(op.outputs[0]).shape;
  const size_t rank = input.size();
  if (given->size() != 2 * rank || output.size() != rank)
    return refuse("padding with a different rank");
  std::vector<int64_t> pads(2 * rank);  // all values "before", then all "after"
  for (size_t i = 0; i < rank; ++i) {
    pads[i] = (*given)[2 * i];
    pads[rank + i] = (*given)[2 * i + 1];
    // Subtracts from the output, because sums of values from the file can overflow.
    if (pads[i] < 0 || pads[i] > output[i] || pads[rank + i] < 0 ||
        pads[rank + i] > output[i] - pads[i] || input[i] != output[i] - pads[i] - pads[rank + i])
      return refuse("padding that does not give the output's shape");
  }
  graph.node("Pad", "", {ends->in, graph.shape(pads), padding}, ends->out);
  return ok();
}

namespace {

struct Range {
  int64_t from = 0, to = 0;
};
// Returns the range of an axis that the masks of StridedSliceOptions (begin 0, end 1, shrink_axis
// 4) and the numbers give.
Range make_range(const TfliteGraphOperator& op, size_t axis, int64_t extent, int64_t begin,
                 int64_t end) {
  const auto is_masked = [&](uint32_t field) {
    return (op.options.scalar<int32_t>(field, 0) >> axis & 1) != 0;
  };
  const auto place = [extent](int64_t at) {
    return std::clamp<int64_t>(at < 0 ? at + extent : at, 0, extent);
  };
  const int64_t from = is_masked(0) ? 0 : place(begin);
  if (is_masked(4)) return {from, from + 1};
  return {from, is_masked(1) ? extent : place(end)};
}

}  // namespace

Status lower_strided_slice(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 4, 4); !status) return status;
  const auto ends = get_ends(graph, op);
  if (!ends) return ends.error();
  const auto begin = graph.integers(op.inputs[1]), end = graph.integers(op.inputs[2]),
             step = graph.integers(op.inputs[3]);
  for (const auto* list : {&begin, &end, &step})
    if (!*list) return list->error();
  const auto& input = graph.tensor(op.inputs[0]);
  const auto& output = graph.tensor(op.outputs[0]);
  const size_t rank = input.shape.size();
  if (begin->size() != rank || end->size() != rank || step->size() != rank || rank > 16 ||
      op.options.scalar<int32_t>(2, 0) != 0 || op.options.scalar<int32_t>(3, 0) != 0)
    return refuse("an ellipsis, a new axis or fewer numbers than axes");
  std::vector<int64_t> from(rank), to(rank), axes(rank);
  int64_t count = 1;
  for (size_t i = 0; i < rank; ++i) {
    const int64_t extent = input.shape[i], stride = (*step)[i];
    if (stride < 1) return refuse("a step below 1");
    const Range range = make_range(op, i, extent, (*begin)[i], (*end)[i]);
    if (range.to <= range.from || range.to > extent) return refuse("a slice of no elements");
    from[i] = range.from, to[i] = range.to;
    axes[i] = static_cast<int64_t>(i);
    count *= (range.to - range.from - 1) / stride + 1;
  }
  if (count != elements(output)) return refuse("an output with a different number of elements");
  const auto slice = graph.made("Slice", {ends->in, graph.shape(from), graph.shape(to),
                                          graph.shape(axes), graph.shape(*step)});
  graph.node("Reshape", "", {slice, graph.shape(output.shape)}, ends->out);
  return ok();
}

namespace {

// Shared by both resizing modes: the size, and the coordinates as in TensorFlow Lite.
struct Resizing {
  Ends ends;
  std::string size;
  bool corners, half_pixels;
  OnnxAttributes attributes(const char* mode) const {
    return std::move(OnnxAttributes()
                         .text("mode", mode)
                         .text("coordinate_transformation_mode", corners       ? "align_corners"
                                                                 : half_pixels ? "half_pixel"
                                                                               : "asymmetric"));
  }
};
// `first`: the index of the field align_corners; half_pixel_centers is the next field.
Result<Resizing> read_resizing(LoweredGraph& graph, const TfliteGraphOperator& op, uint32_t first) {
  if (auto status = check_counts(op, 2, 2); !status) return status.error();
  const auto ends = get_ends(graph, op);
  if (!ends) return ends.error();
  const auto size = graph.integers(op.inputs[1]);
  if (!size) return size.error();
  const auto& input = graph.tensor(op.inputs[0]).shape;
  const auto& output = graph.tensor(op.outputs[0]).shape;
  if (input.size() != 4 || output.size() != 4 || input[0] != output[0] || input[3] != output[3] ||
      *size != std::vector<int64_t>{output[1], output[2]} || output[1] < 1 || output[2] < 1)
    return refuse("a size that is not the output's").error();
  return Resizing{*ends, graph.shape(output), op.options.scalar<uint8_t>(first, 0) != 0,
                  op.options.scalar<uint8_t>(first + 1, 0) != 0};
}

}  // namespace

Status lower_nearest_neighbour(LoweredGraph& graph, const TfliteGraphOperator& op) {
  const auto found = read_resizing(graph, op, 0);
  if (!found) return found.error();
  graph.node(
      "Resize", "", {found->ends.in, "", "", found->size}, found->ends.out,
      found->attributes("nearest").text(
          "nearest_mode", found->corners || found->half_pixels ? "round_prefer_ceil" : "floor"));
  return ok();
}

// Computed in floats, because TensorFlow Lite and XNNPACK round differently from each other.
Status lower_bilinear(LoweredGraph& graph, const TfliteGraphOperator& op) {
  const auto found = read_resizing(graph, op, 2);
  if (!found) return found.error();
  if (!graph.is_8bit(op.inputs[0])) return refuse("a picture whose values are not 8-bit");
  const auto in = graph.quantization(op.inputs[0]), out = graph.quantization(op.outputs[0]);
  if (!in) return in.error();
  if (!out) return out.error();
  if (*in != *out) return refuse("an output whose scale differs from the input's");
  const auto one = graph.scale(1), zero = graph.zero_point(0);
  const auto real = graph.made("DequantizeLinear", {found->ends.in, one, zero});
  const auto larger =
      graph.made("Resize", {real, "", "", found->size}, found->attributes("linear"));
  graph.node("QuantizeLinear", "", {larger, one, zero}, found->ends.out);
  return ok();
}

}  // namespace weir::engine
