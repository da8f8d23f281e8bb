// Fuzz target: parses properties of tensor_demux, tensor_split and tensor_if and runs the results.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "core/condition/comparison.hpp"
#include "core/split/pick_list.hpp"
#include "core/split/segments.hpp"

namespace {

constexpr uint64_t kMax = 1 << 20;

// Segments are within the tensor; along a dimension they cover all of it or report the rest.
void split(const weir::SplitRequest& request, const weir::TensorSpec& spec) {
  const auto plan = weir::plan_split(request, spec);
  if (!plan || plan->segments.size() > 64) return;
  const std::vector<std::byte> in(static_cast<size_t>(*spec.bytes()), std::byte{5});
  size_t total = 0;
  for (const auto& segment : plan->segments) {
    std::vector<std::byte> out(static_cast<size_t>(*segment.spec.bytes()));
    weir::copy_segment(segment, in, out);
    for (const std::byte b : out)
      if (b != std::byte{5}) std::abort();
    total += out.size();
    const weir::SourceMap map;
    (void)weir::make_source_maps(segment, spec, {&map, 1}, request.parts % 2 == 1);
  }
  if (request.picks.empty() && (total == in.size()) == plan->left_over.has_value()) std::abort();
}

void decide(const weir::condition::Condition& condition, const weir::TensorSpec& spec) {
  if (weir::condition::missing(condition)) return;
  const auto comparison = weir::condition::Comparison::make(condition, {spec});
  if (!comparison) return;
  const std::vector<std::byte> in(static_cast<size_t>(*spec.bytes()), std::byte{0x7F});
  (void)comparison->holds(std::span(in).subspan(comparison->offset(), comparison->bytes()));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 5) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 5, size - 5);
  const std::string_view first = text.substr(0, text.find('\n'));
  const std::string_view second = text.substr(std::min(text.size(), first.size() + 1));
  const weir::TensorSpec spec{static_cast<weir::ElementType>(data[1] % 11),
                              weir::Shape{data[2] % 9u + 1, data[3] % 9u + 1, 3u}, ""};
  if (*spec.bytes() > kMax) return 0;
  switch (data[0] % 3) {
    case 0:
      (void)weir::parse_tensor_groups("tensorpick", text);
      break;
    case 1: {
      auto segments = weir::parse_segments(first);
      auto picks = weir::parse_index_list("tensorpick", second, weir::kPickSeparators);
      if (!segments || !picks) break;
      weir::SplitRequest request{*std::move(segments), *std::move(picks), std::nullopt, 0};
      if (data[4] % 4 > 0) request.dimension = data[4] % 4 - 1u;
      if (request.segments.empty()) request.parts = data[4] / 16;
      split(request, spec);
      break;
    }
    default: {
      using weir::condition::ComparedValue;
      const auto compared = data[4] % 2 ? ComparedValue::Element : ComparedValue::Average;
      const auto op = static_cast<weir::condition::Operator>(data[4] / 2 % 10);
      const auto condition = weir::condition::parse_condition(compared, first, op, second);
      if (condition) decide(*condition, spec);
      break;
    }
  }
  return 0;
}
