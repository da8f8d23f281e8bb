// Builds the table: one column of 256 results for each channel.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/stand_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/transform/number_rules.hpp"

namespace weir::transform {
namespace {

constexpr size_t kValues = 256;
constexpr size_t kMaxColumns = 4;

template <class T>
struct Table {
  T at[kMaxColumns][kValues];
};

template <class From, class To>
void fill(Table<To>& table, size_t channels, const StandTypes& types,
          const StandScale& scale) noexcept {
  for (size_t channel = 0; channel < channels; ++channel) {
    const double mean = scale.mean[channel], deviation = scale.deviation[channel];
    for (size_t i = 0; i < kValues; ++i) {
      const double distance = static_cast<double>(static_cast<From>(i)) - mean;
      const double result = !types.divides                 ? distance
                            : divides_by_product(types.to) ? std::fabs(distance) * (1 / deviation)
                                                           : std::fabs(distance) / deviation;
      table.at[channel][i] = convert<To>(result);
    }
  }
}

// A large deviation gives few steps, and counting the steps below processes many elements at once.
bool run_steps(const uint8_t* column, size_t count, bool accelerate, const std::byte* in,
               std::byte* out) noexcept {
  TableSteps steps;
  steps.first = column[0];
  for (const int direction : {1, -1}) {
    size_t& found = direction > 0 ? steps.ups : steps.downs;
    for (size_t i = 1; i < kValues; ++i) {
      const int change = static_cast<int8_t>(column[i] - column[i - 1]) * direction;
      if (change <= 0) continue;
      const size_t before = steps.ups + steps.downs;
      if (static_cast<size_t>(change) > kMaxSteps - before) return false;
      std::fill_n(&steps.below[before], change, static_cast<uint8_t>(i - 1));
      found += static_cast<size_t>(change);
    }
  }
  run_table_steps(steps, count, accelerate, in, out);
  return true;
}

template <size_t kChannels, class To>
void look_up(const Table<To>& table, size_t count, const std::byte* in, std::byte* out) noexcept {
  for (size_t i = 0; i < count; i += kChannels)
    for (size_t channel = 0; channel < kChannels; ++channel)
      std::memcpy(out + (i + channel) * sizeof(To),
                  &table.at[channel][std::to_integer<uint8_t>(in[i + channel])], sizeof(To));
}

template <class From, class To>
void run(const StandTensor& tensor, const StandTypes& types, const StandScale& scale,
         bool accelerate, const std::byte* in, std::byte* out) noexcept {
  Table<To> table;
  fill<From>(table, tensor.channels, types, scale);
  if constexpr (std::integral<To> && sizeof(To) == 1) {
    uint8_t column[kValues];
    std::memcpy(column, table.at[0], kValues);
    if (tensor.channels == 1 && run_steps(column, tensor.count, accelerate, in, out)) return;
  }
  switch (tensor.channels) {
    case 1:
      return look_up<1>(table, tensor.count, in, out);
    case 2:
      return look_up<2>(table, tensor.count, in, out);
    case 3:
      return look_up<3>(table, tensor.count, in, out);
    default:
      return look_up<4>(table, tensor.count, in, out);
  }
}

}  // namespace

bool has_stand_table(const StandTensor& tensor, const StandTypes& types) noexcept {
  return element_size(types.from) == 1 && tensor.channels <= kMaxColumns &&
         tensor.count >= 16 * kValues * tensor.channels;
}

void run_stand_table(const StandTensor& tensor, const StandTypes& types, const StandScale& scale,
                     bool accelerate, const std::byte* in, std::byte* out) noexcept {
  visit_type(types.to, [&](auto tag) {
    using To = typename decltype(tag)::type;
    if (types.from == ElementType::Int8)
      run<int8_t, To>(tensor, types, scale, accelerate, in, out);
    else
      run<uint8_t, To>(tensor, types, scale, accelerate, in, out);
  });
}

}  // namespace weir::transform
