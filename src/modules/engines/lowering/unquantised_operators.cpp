// Lowers operators on values without quantisation (float32, int32, int64), and CAST to and from
// them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <limits>

#include "lowering/operator_parts.hpp"
#include "lowering/operators.hpp"

namespace weir::engine {
namespace {

bool is_float(const LoweredGraph& graph, int32_t index) {
  return graph.tensor(index).type == TfliteType::kFloat32;
}

bool is_plain(const LoweredGraph& graph, int32_t index) {
  const auto type = graph.tensor(index).type;
  return type == TfliteType::kFloat32 || type == TfliteType::kInt32 || type == TfliteType::kInt64;
}

OnnxAttributes to(OnnxElement type) {
  return OnnxAttributes().number("to", static_cast<int64_t>(type));
}

// The limits of a fused activation; infinite without one.
Result<std::array<float, 2>> get_limits(int8_t activation) {
  constexpr float kFar = std::numeric_limits<float>::infinity();
  switch (static_cast<Activation>(activation)) {
    case Activation::kNone:
      return std::array{-kFar, kFar};
    case Activation::kRelu:
      return std::array{0.0f, kFar};
    case Activation::kReluN1To1:
      return std::array{-1.0f, 1.0f};
    case Activation::kRelu6:
      return std::array{0.0f, 6.0f};
  }
  return refuse("fused activation number " + std::to_string(activation)).error();
}

// Converts to int32. int8 values are stored as uint8 plus 128; this restores them.
std::string widened(LoweredGraph& graph, const std::string& value, bool is_signed) {
  const auto wide = graph.made("Cast", {value}, to(OnnxElement::kInt32));
  constexpr int32_t kMoved = 128;
  return is_signed ? graph.made("Sub", {wide, graph.number(kMoved)}) : wide;
}

}  // namespace

Status plain_binary(LoweredGraph& graph, const TfliteGraphOperator& op, std::string_view name) {
  const auto type = graph.tensor(op.outputs[0]).type;
  for (const int32_t input : {op.inputs[0], op.inputs[1]})
    if (!is_plain(graph, input) || graph.tensor(input).type != type)
      return refuse("inputs and output that are not all 8-bit or all of one type");
  const auto a = graph.value(op.inputs[0]), b = graph.value(op.inputs[1]),
             out = graph.value(op.outputs[0]);
  for (const auto* each : {&a, &b, &out})
    if (!*each) return each->error();
  const auto limits = get_limits(op.options.scalar<int8_t>(0, 0));
  if (!limits) return limits.error();
  const bool cut = *limits != std::array{-std::numeric_limits<float>::infinity(),
                                         std::numeric_limits<float>::infinity()};
  if (cut && type != TfliteType::kFloat32)
    return refuse("a fused activation of whole numbers of 32 or 64 bits");
  const std::string computed = cut ? graph.fresh() : *out;
  graph.node(name, "", {*a, *b}, computed);
  if (cut)
    graph.node("Clip", "", {computed, graph.scale((*limits)[0]), graph.scale((*limits)[1])}, *out);
  return ok();
}

// Integers are not lowered: for a divisor of 0 TensorFlow Lite fails, but ONNX Runtime crashes.
Status lower_divide(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 2, 2); !status) return status;
  if (!is_float(graph, op.outputs[0])) return refuse("a quotient that is not float32");
  return plain_binary(graph, op, "Div");
}

// Rounds towards minus infinity. ONNX's Mod has the sign of the divisor; its Div truncates.
Status lower_floor_divide(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 2, 2); !status) return status;
  if (graph.tensor(op.outputs[0]).type != TfliteType::kInt32 ||
      graph.tensor(op.inputs[0]).type != TfliteType::kInt32)
    return refuse("a quotient that is not int32");
  const auto divisors = graph.integers(op.inputs[1]);
  if (!divisors) return divisors.error();
  if (graph.tensor(op.inputs[1]).type != TfliteType::kInt32 ||
      std::any_of(divisors->begin(), divisors->end(), [](int64_t by) { return by < 1; }))
    return refuse("a divisor below 1");
  const auto a = graph.value(op.inputs[0]), b = graph.value(op.inputs[1]),
             out = graph.value(op.outputs[0]);
  for (const auto* each : {&a, &b, &out})
    if (!*each) return each->error();
  const auto rest = graph.made("Mod", {*a, *b});
  graph.node("Div", "", {graph.made("Sub", {*a, rest}), *b}, *out);
  return ok();
}

Status lower_square_root(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 1, 1); !status) return status;
  if (!is_float(graph, op.inputs[0]) || !is_float(graph, op.outputs[0]))
    return refuse("a square root that is not float32");
  const auto in = graph.value(op.inputs[0]), out = graph.value(op.outputs[0]);
  if (!in) return in.error();
  if (!out) return out.error();
  graph.node("Sqrt", "", {*in}, *out);
  return ok();
}

// Casts the stored values, whatever their quantisation: floats truncate and integers keep their low
// bits. Floats outside the target type are undefined in TensorFlow Lite too.
Status lower_cast(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 1, 1); !status) return status;
  const auto from = graph.tensor(op.inputs[0]).type, wanted = graph.tensor(op.outputs[0]).type;
  const auto in = graph.value(op.inputs[0]), out = graph.value(op.outputs[0]);
  if (!in) return in.error();
  if (!out) return out.error();
  if (from == wanted) {
    graph.node("Identity", "", {*in}, *out);
    return ok();
  }
  std::string value = *in;
  if (graph.is_8bit(op.inputs[0])) value = widened(graph, value, from == TfliteType::kInt8);
  if (graph.is_8bit(op.outputs[0])) {
    value = graph.made("Cast", {value}, to(OnnxElement::kInt32));
    constexpr int32_t kMoved = 128;
    if (wanted == TfliteType::kInt8) value = graph.made("Add", {value, graph.number(kMoved)});
    // Modulo 256 keeps the low bits, so that no cast kernel saturates.
    constexpr int32_t kValues = 256;
    value = graph.made("Mod", {value, graph.number(kValues)});
  }
  const auto element = wanted == TfliteType::kFloat32 ? OnnxElement::kFloat
                       : wanted == TfliteType::kInt32 ? OnnxElement::kInt32
                       : wanted == TfliteType::kInt64 ? OnnxElement::kInt64
                                                      : OnnxElement::kUint8;
  graph.node("Cast", "", {value}, *out, to(element));
  return ok();
}

// The first of equal values, as in TensorFlow Lite.
Status lower_arg_max(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 2, 2); !status) return status;
  const auto axis = graph.integers(op.inputs[1]);
  if (!axis) return axis.error();
  const auto rank = static_cast<int64_t>(graph.tensor(op.inputs[0]).shape.size());
  const auto type = graph.tensor(op.outputs[0]).type;
  const auto given = graph.tensor(op.inputs[0]).type;
  if (axis->size() != 1 || (*axis)[0] < -rank || (*axis)[0] >= rank)
    return refuse("an axis that does not exist");
  if ((type != TfliteType::kInt32 && type != TfliteType::kInt64) || given == TfliteType::kInt64)
    return refuse("numbers of a type that is not lowered here");
  const auto in = graph.value(op.inputs[0]), out = graph.value(op.outputs[0]);
  if (!in) return in.error();
  if (!out) return out.error();
  const auto places = graph.made("ArgMax", {*in},
                                 OnnxAttributes().number("axis", (*axis)[0]).number("keepdims", 0));
  graph.node("Cast", "", {places}, *out,
             to(type == TfliteType::kInt32 ? OnnxElement::kInt32 : OnnxElement::kInt64));
  return ok();
}

}  // namespace weir::engine
