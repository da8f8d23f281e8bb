// The entry points of the transform: each call goes to the file of the operation.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/transform.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "core/text/text.hpp"
#include "core/transform/clamp.hpp"
#include "core/transform/fused.hpp"
#include "core/transform/gather.hpp"
#include "core/transform/kernel.hpp"
#include "core/transform/modes.hpp"
#include "core/transform/stand.hpp"

namespace weir::transform {
namespace {

constexpr std::array<std::string_view, 7> kModes{"dimchg", "typecast", "arithmetic", "transpose",
                                                 "stand",  "clamp",    "padding"};

Status check(const TensorSpec& in) {
  if (!in.valid())
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "a tensor cannot be transformed",
                 .offered = in.to_string(),
                 .needed = "a tensor with a type and dimensions above 0"};
  if (!in.bytes())
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "a tensor is too large",
                 .offered = in.to_string(),
                 .needed = "a size of less than 2^63 bytes"};
  return ok();
}

}  // namespace

std::string_view to_string(Mode mode) noexcept {
  const auto i = static_cast<size_t>(mode);
  return i < kModes.size() ? kModes[i] : "unknown";
}

Mode parse_mode(std::string_view nick) noexcept {
  for (size_t i = 0; i < kModes.size(); ++i)
    if (equal_ignoring_case(nick, kModes[i])) return static_cast<Mode>(i);
  return Mode::Unknown;
}

Mode Operation::mode() const noexcept {
  constexpr std::array<Mode, std::variant_size_v<decltype(what)>> kModeOf{
      Mode::Dimchg, Mode::Typecast, Mode::Arithmetic, Mode::Transpose,
      Mode::Stand,  Mode::Clamp,    Mode::Padding};
  return kModeOf[what.index()];
}

Result<Operation> parse(Mode mode, std::string_view option) {
  switch (mode) {
    case Mode::Dimchg:
      return parse_dimchg(option);
    case Mode::Typecast:
      return parse_typecast(option);
    case Mode::Arithmetic:
      return parse_arithmetic(option);
    case Mode::Transpose:
      return parse_transpose(option);
    case Mode::Stand:
      return parse_stand(option);
    case Mode::Clamp:
      return parse_clamp(option);
    case Mode::Padding:
      return parse_padding(option);
    case Mode::Unknown:
      break;
  }
  return Error{.code = Code::MODE_UNKNOWN,
               .what = "no mode of the transform is set",
               .offered = "mode=unknown",
               .needed = "dimchg, typecast, arithmetic, transpose, stand, clamp or padding",
               .fix = "mode=typecast option=float32"};
}

Result<TensorSpec> output_spec(const Operation& operation, const TensorSpec& in) {
  if (auto status = check(in); !status) return std::move(status).error();
  const auto out = output_candidates(operation, {in.type, in.shape});
  TensorSpec spec{out.type, out.shape, in.name};
  if (auto status = check(spec); !status) return std::move(status).error();
  return spec;
}

TemplateSpec output_candidates(const Operation& operation, const TemplateSpec& in) {
  return std::visit([&](const auto& op) { return get_output(op, in); }, operation.what);
}

std::optional<TemplateSpec> input_candidates(const Operation& operation, const TemplateSpec& out) {
  return std::visit([&](const auto& op) { return find_input(op, out); }, operation.what);
}

Result<TransformPlan> plan(const Operation& operation, const TensorSpec& in, bool accelerate) {
  auto out = output_spec(operation, in);
  if (!out) return std::move(out).error();
  auto kernel =
      std::visit([&](const auto& op) { return make_kernel(op, in, accelerate); }, operation.what);
  return TransformPlan(in, *std::move(out), std::move(kernel));
}

std::optional<TransformPlan> fused(const TransformPlan& first, const TransformPlan& second) {
  auto kernel = make_fused_kernel({first.kernel_, first.input_.type, first.output_.type},
                                  {second.kernel_, second.input_.type, second.output_.type},
                                  static_cast<size_t>(first.output_.shape.count().value_or(0)));
  if (!kernel) return std::nullopt;
  return TransformPlan(first.input_, second.output_, std::move(kernel));
}

Result<TransformPlan> gather_plan(const TensorSpec& tensor, const StridedLayout& layout) {
  if (auto status = check(tensor); !status) return std::move(status).error();
  const auto extent = find_extent(tensor, layout);
  if (!extent)
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the strides of a tensor lead outside its memory",
                 .offered = std::to_string(layout.strides.size()) + " strides",
                 .needed = "one for each dimension, within the memory",
                 .difference = tensor.to_string()};
  if (*extent > UINT32_MAX)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "a tensor with strides spans too many bytes",
                 .offered = std::to_string(*extent) + " bytes",
                 .needed = "less than 4 GiB"};
  return TransformPlan({ElementType::UInt8, Shape{static_cast<uint32_t>(*extent)}, tensor.name},
                       tensor, std::make_shared<GatherKernel>(make_runs(tensor, layout)));
}

bool TransformPlan::in_place_possible() const noexcept {
  return kernel_->in_place_possible();
}
bool TransformPlan::is_copy() const noexcept {
  return kernel_->is_copy();
}
bool TransformPlan::is_gather() const noexcept {
  return kernel_->is_gather();
}
bool TransformPlan::is_element_wise() const noexcept {
  return kernel_->period() > 0;
}

Counters TransformPlan::apply(std::span<const std::byte> in,
                              std::span<std::byte> out) const noexcept {
  return kernel_->run(in, out);
}

Counters CopyKernel::run(std::span<const std::byte> in, std::span<std::byte> out) const noexcept {
  const size_t bytes = std::min({bytes_, in.size(), out.size()}) / element_bytes_ * element_bytes_;
  if (bytes > 0 && in.data() != out.data()) std::memmove(out.data(), in.data(), bytes);
  return {};
}

}  // namespace weir::transform
