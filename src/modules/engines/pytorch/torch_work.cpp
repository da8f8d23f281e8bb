// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pytorch/torch_work.hpp"

#include <algorithm>
#include <optional>
#include <vector>

namespace weir::engine {
namespace {

struct Value {
  double numbers = 0, channels = 1;
};

// Nullopt: the shape is open.
std::optional<Value> make_value(const weir_tensor_info& info) {
  if (info.rank > WEIR_RANK_LIMIT) return std::nullopt;  // WEIR_RANK_UNKNOWN is too
  Value out{1, 1};
  for (uint32_t i = 0; i < info.rank; ++i) {
    if (info.shape[i] < 0) return std::nullopt;
    out.numbers *= static_cast<double>(info.shape[i]);
  }
  if (info.rank > 1) out.channels = static_cast<double>(info.shape[1]);
  return out;
}

// What a step reads: all of its inputs together, or the largest one.
Value get_input(const TorchWork::Step& step, const std::vector<Value>& values) {
  Value in;
  for (const uint32_t from : step.from) {
    const Value& part = values[from];
    if (step.joins) {
      in.numbers += part.numbers;
      in.channels += part.channels;
    } else if (part.numbers > in.numbers) {
      in = part;
    }
  }
  return in;
}

}  // namespace

Work TorchWork::estimate(std::span<const weir_tensor_info> inputs) const {
  if (inputs.size() != inputs_) return {};
  std::vector<Value> values;
  double batch = 1;
  for (const auto& info : inputs) {
    const auto value = make_value(info);
    if (!value) return {};
    if (values.empty() && info.rank > 2) batch = static_cast<double>(info.shape[0]);
    values.push_back(*value);
  }
  Work work;
  for (const Step& step : steps_) {
    const Value in = get_input(step, values);
    Value out{in.numbers * step.growth, step.channels > 0 ? step.channels : in.channels};
    if (step.positions > 0)
      out.numbers = std::min(in.numbers, batch * out.channels * step.positions);
    if (step.multiplications > 0) {
      work.multiplications += out.numbers * step.multiplications;
      work.weights += step.weights;
      ++work.operators;
    }
    values.push_back(out);
  }
  return work;
}

}  // namespace weir::engine
