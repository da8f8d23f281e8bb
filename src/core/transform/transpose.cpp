// mode=transpose: its grammar, shapes and kernel.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/modes.hpp"

#include <algorithm>
#include <array>

#include "core/text/text.hpp"
#include "core/transform/option_reader.hpp"
#include "core/transform/transpose_steps.hpp"

namespace weir::transform {
namespace {

using FullOrder = std::array<uint8_t, kRankLimit>;
constexpr const char* kTransposeExample = "option=1:0:2:3";
constexpr size_t kShortForm = 4;  // its last index is always 3

FullOrder full_order(const Transpose& transpose) noexcept {
  FullOrder order{};
  for (size_t i = 0; i < kRankLimit; ++i)
    order[i] = i < transpose.order.size() ? transpose.order[i] : static_cast<uint8_t>(i);
  return order;
}

FullOrder inverse(const FullOrder& order) noexcept {
  FullOrder out{};
  for (size_t i = 0; i < kRankLimit; ++i) out[order[i]] = static_cast<uint8_t>(i);
  return out;
}

// Missing dimensions count as 1 if further ones follow.
Shape permuted(const Shape& in, const FullOrder& order) noexcept {
  Shape out;
  for (size_t i = 0; i < kRankLimit; ++i) out[i] = in[order[i]];
  bool has_further = false;
  for (size_t i = kRankLimit; i-- > 0;) {
    has_further = has_further || out[i] != 0;
    if (has_further && out[i] == 0) out[i] = 1;
  }
  return out;
}

TemplateSpec permuted(const TemplateSpec& spec, const FullOrder& order) noexcept {
  if (spec.shape_open()) return spec;
  return {spec.type, permuted(spec.shape, order)};
}

bool is_identity(const std::vector<uint8_t>& order) noexcept {
  return std::is_sorted(order.begin(), order.end());
}

Result<uint8_t> take_index(OptionReader& reader, const std::vector<uint8_t>& before) {
  const size_t begin = reader.position();
  const auto digits = reader.take_digits();
  const auto value = parse_unsigned(digits);  // nullopt: none, or far too large
  if (digits.empty() || (digits.size() > 1 && digits[0] == '0')) {
    reader.go_to(begin);
    return reader.syntax_error("an index of a dimension, 0 is the innermost", kTransposeExample);
  }
  if (!value || *value >= kRankLimit) {
    reader.go_to(begin);
    return reader.value_error("an index of the transposition is out of range",
                              "at most " + std::to_string(kRankLimit - 1), kTransposeExample);
  }
  if (std::find(before.begin(), before.end(), *value) != before.end()) {
    reader.go_to(begin);
    return reader.syntax_error("each index once", kTransposeExample);
  }
  return static_cast<uint8_t>(*value);
}

std::string with_next_index(std::string_view option) {
  return "option=" + std::string(option) + ":" + std::to_string(kShortForm);
}

// Whether the complete and distinct indices are a permutation that the grammar allows.
Status check_order(OptionReader& reader, const std::vector<uint8_t>& order) {
  if (order.size() < kShortForm)
    return reader.syntax_error("at least four indices, such as 1:0:2:3", kTransposeExample);
  const auto beyond = std::find_if(order.begin(), order.end(),
                                   [&](uint8_t index) { return index >= order.size(); });
  if (beyond != order.end()) {
    size_t place = 0;  // after as many colons as there are indices before it
    for (auto index = order.begin(); index != beyond; ++index)
      place = reader.text().find(':', place) + 1;
    reader.go_to(place);
    return reader.syntax_error(
        "each of the indices 0 to " + std::to_string(order.size() - 1) + " once",
        kTransposeExample);
  }
  if (order.size() == kShortForm && order.back() != kShortForm - 1) {
    reader.go_to(reader.text().rfind(':') + 1);
    return reader.syntax_error("3 as the last of four indices; five and more may be in any order",
                               with_next_index(reader.text()));
  }
  return ok();
}

class TransposeKernel final : public Kernel {
 public:
  TransposeKernel(const TransposeSteps& steps, size_t bytes, bool accelerate) noexcept
      : steps_(steps), bytes_(bytes), accelerate_(accelerate) {}

  Counters run(std::span<const std::byte> in, std::span<std::byte> out) const noexcept override {
    if (in.size() < bytes_ || out.size() < bytes_) return {};
    (accelerate_ ? run_transpose_vector : run_transpose_plain)(steps_, in.data(), out.data());
    return {};
  }

 private:
  TransposeSteps steps_;
  size_t bytes_;
  bool accelerate_;
};

}  // namespace

Result<Operation> parse_transpose(std::string_view option) {
  OptionReader reader("transpose", option);
  Transpose transpose;
  do {
    auto index = take_index(reader, transpose.order);
    if (!index) return std::move(index).error();
    transpose.order.push_back(*index);
  } while (reader.take(":"));
  if (!reader.at_end()) return reader.syntax_error("':' or the end", kTransposeExample);
  if (auto status = check_order(reader, transpose.order); !status) return std::move(status).error();
  Operation operation{transpose, {}};
  if (is_identity(transpose.order))
    operation.warnings.push_back("the transposition " + std::string(option) +
                                 " changes nothing: each frame is passed on as it is");
  return operation;
}

TemplateSpec get_output(const Transpose& transpose, const TemplateSpec& in) {
  return permuted(in, full_order(transpose));
}

std::optional<TemplateSpec> find_input(const Transpose& transpose, const TemplateSpec& out) {
  return permuted(out, inverse(full_order(transpose)));
}

std::shared_ptr<const Kernel> make_kernel(const Transpose& transpose, const TensorSpec& in,
                                          bool accelerate) {
  const size_t bytes = in.bytes().value_or(0);
  const size_t element_bytes = element_size(in.type);
  const auto steps = make_transpose_steps(in.shape, full_order(transpose), element_bytes);
  if (steps.copy) return std::make_shared<CopyKernel>(bytes, element_bytes);
  return std::make_shared<TransposeKernel>(steps, bytes, accelerate);
}

}  // namespace weir::transform
