// Lowers SUB of 8-bit values, bit-exact with TensorFlow Lite.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cmath>
#include <limits>

#include "lowering/operator_parts.hpp"
#include "lowering/operators.hpp"

namespace weir::engine {
namespace {

constexpr int kLeftShift = 20;  // applied to values before they are rescaled to a common scale
constexpr int kValues = 256;

// real is about mantissa * 2^(exponent - 31).
struct Multiplier {
  int64_t mantissa = 0;
  int exponent = 0;
};
Multiplier make_multiplier(double real) {
  Multiplier out;
  out.mantissa = static_cast<int64_t>(std::round(std::ldexp(std::frexp(real, &out.exponent), 31)));
  if (out.mantissa == int64_t{1} << 31) out.mantissa /= 2, ++out.exponent;
  return out.exponent < -31 ? Multiplier{} : out;
}

// Rounds half up.
int64_t high_product(int64_t value, int64_t mantissa) {
  return (value * mantissa + (int64_t{1} << 30)) >> 31;
}

// Rounds half away from zero.
int64_t shifted_right(int64_t value, int by) {
  if (by <= 0) return value;
  const int64_t half = int64_t{1} << (by - 1);
  return value < 0 ? -((-value + half) >> by) : (value + half) >> by;
}

// Looks up each stored value's equivalent at the common scale.
Result<std::string> common_scale(LoweredGraph& graph, int32_t index, double real, int sign) {
  const auto q = graph.quantization(index);
  if (!q) return q.error();
  const auto multiplier = make_multiplier(real);
  std::string table;
  for (int value = 0; value < kValues; ++value) {
    const int64_t shifted = int64_t{value - q->zero_point} << kLeftShift;
    const auto scaled = static_cast<int32_t>(
        shifted_right(high_product(shifted, sign * multiplier.mantissa), -multiplier.exponent));
    table.append(reinterpret_cast<const char*>(&scaled), sizeof scaled);
  }
  const auto name = graph.value(index);
  if (!name) return name.error();
  const auto place = graph.made(
      "Cast", {*name}, OnnxAttributes().number("to", static_cast<int64_t>(OnnxElement::kInt32)));
  constexpr int64_t kCount = kValues;
  return graph.made("Gather", {graph.int32_constant({&kCount, 1}, table), place});
}

// In double precision, whose error in the product is far below a half.
std::string rounded(LoweredGraph& graph, const std::string& sum, double real) {
  const auto multiplier = make_multiplier(real);
  const auto factor = std::ldexp(static_cast<double>(multiplier.mantissa), -31);
  const auto real_sum = graph.made(
      "Cast", {sum}, OnnxAttributes().number("to", static_cast<int64_t>(OnnxElement::kDouble)));
  const auto half = graph.real(0.5);
  auto whole = graph.made(
      "Floor", {graph.made("Add", {graph.made("Mul", {real_sum, graph.real(factor)}), half})});
  if (multiplier.exponent >= 0) return whole;
  const auto shifted = graph.made("Mul", {whole, graph.real(std::ldexp(1.0, multiplier.exponent))});
  const auto away = graph.made("Floor", {graph.made("Add", {graph.made("Abs", {shifted}), half})});
  return graph.made("Mul", {graph.made("Sign", {shifted}), away});
}

}  // namespace

Status lower_subtract(LoweredGraph& graph, const TfliteGraphOperator& op) {
  if (auto status = check_counts(op, 2, 2); !status) return status;
  if (!graph.is_8bit(op.outputs[0])) return plain_binary(graph, op, "Sub");
  const auto a = graph.quantization(op.inputs[0]), b = graph.quantization(op.inputs[1]),
             out = graph.quantization(op.outputs[0]);
  for (const auto* each : {&a, &b, &out})
    if (!*each) return each->error();
  const double twice = 2 * std::max(a->scale, b->scale);
  const double output = twice / ((1 << kLeftShift) * static_cast<double>(out->scale));
  if (!std::isnormal(output) || output >= 1 || a->scale / twice > 1 || b->scale / twice > 1)
    return refuse("scales that are too far apart");
  const auto first = common_scale(graph, op.inputs[0], static_cast<double>(a->scale) / twice, 1);
  if (!first) return first.error();
  const auto second = common_scale(graph, op.inputs[1], static_cast<double>(b->scale) / twice, -1);
  if (!second) return second.error();
  const auto value = rounded(graph, graph.made("Add", {*first, *second}), output);
  const auto moved = graph.made("Add", {value, graph.real(out->zero_point)});
  const auto within = graph.made("Clip", {moved, graph.real(0), graph.real(kValues - 1)});
  return node_with_activation(
      graph, "Cast", "", {within}, op.outputs[0],
      OnnxAttributes().number("to", static_cast<int64_t>(OnnxElement::kUint8)),
      op.options.scalar<int8_t>(0, 0));
}

}  // namespace weir::engine
