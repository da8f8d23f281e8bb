// Propagates the number of values through the steps of a graph.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pytorch/torch_work.hpp"

#include <algorithm>

namespace weir::engine {
namespace {

struct Value {
  double numbers = 0, channels = 1;
};

}  // namespace

Work TorchWork::estimate(std::span<const weir_tensor_info> inputs) const {
  if (inputs.size() != inputs_) return {};
  std::vector<Value> values;
  double batch = 1;
  for (const auto& info : inputs) {
    Value value{1, 1};
    if (info.rank == WEIR_RANK_UNKNOWN || info.rank > WEIR_RANK_LIMIT) return {};
    for (uint32_t i = 0; i < info.rank; ++i) {
      if (info.shape[i] < 0) return {};
      value.numbers *= static_cast<double>(info.shape[i]);
    }
    if (info.rank > 1) value.channels = static_cast<double>(info.shape[1]);
    if (values.empty() && info.rank > 2) batch = static_cast<double>(info.shape[0]);
    values.push_back(value);
  }
  Work work;
  for (const Step& step : steps_) {
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
