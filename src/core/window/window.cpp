// Computes windows (docs/compatibility/routing.md 6.6).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/window/window.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <string>

namespace weir::window {
namespace {

std::string option(const char* name, uint64_t value) {
  return std::string(name) + "=" + std::to_string(value);
}

Error not_a_multiple(const WindowRequest& r, size_t tensor, const TensorSpec& spec) {
  const uint32_t extent = spec.shape[r.dimension];
  return Error{.code = Code::OPTION_VALUE,
               .what = "a buffer does not contain frames-in frames",
               .offered = option("frames-in", r.frames_in) + ", and dimension " +
                          std::to_string(r.dimension) + " of tensor " + std::to_string(tensor) +
                          " (" + spec.to_string() + ") is " + std::to_string(extent),
               .needed = "a dimension that is a multiple of frames-in",
               .difference = std::to_string(extent) + " modulo " + std::to_string(r.frames_in) +
                             " is " + std::to_string(extent % r.frames_in),
               .fix = option("frames-in", std::gcd(extent, r.frames_in))};
}

Error cannot_flush(const WindowRequest& r, uint64_t max) {
  return Error{.code = Code::OPTION_VALUE,
               .what = "frames-flush exceeds the number of frames in a full window",
               .offered = option("frames-flush", r.frames_flush) + ", with " +
                          option("frames-in", r.frames_in) + " and " +
                          option("frames-out", r.frames_out),
               .needed = "at most " + std::to_string(max) +
                         " = frames-in times (frames-out / frames-in, rounded up)",
               .fix = option("frames-flush", max)};
}

Error too_big(const TensorSpec& spec, const WindowRequest& r) {
  return Error{.code = Code::LIMIT_EXCEEDED,
               .what = "a window is too large for a tensor",
               .offered = spec.to_string() + " with " + option("frames-out", r.frames_out),
               .needed = "dimensions below 2^32 and 2^63 bytes",
               .fix = "frames-out=1"};
}

// The tensor of a window as written in caps.
Result<TensorSpec> make_output(const WindowRequest& r, size_t index, const TensorSpec& spec) {
  TensorSpec out = spec;
  uint32_t& extent = out.shape[r.dimension];
  if (extent == 0) return out;
  if (extent % r.frames_in != 0) return not_a_multiple(r, index, spec);
  const uint64_t frames = uint64_t{extent / r.frames_in} * r.frames_out;
  if (frames > UINT32_MAX) return too_big(spec, r);
  extent = static_cast<uint32_t>(frames);
  if (!out.bytes()) return too_big(spec, r);
  return out;
}

WindowLayout make_layout(const WindowRequest& r, const TensorSpec& spec) {
  WindowLayout layout;
  layout.frame_bytes = static_cast<size_t>(*spec.bytes() / r.frames_in);
  layout.block_bytes = layout.frame_bytes;
  if (!r.concatenate || r.frames_out <= 1 || r.dimension >= spec.shape.rank()) return layout;
  size_t block = element_size(spec.type) * (spec.shape[r.dimension] / r.frames_in);
  for (size_t i = 0; i < r.dimension; ++i) block *= spec.shape[i];
  layout.block_bytes = block;
  return layout;
}

// The tensor of the window's real size when caps cannot express it.
Result<TensorSpec> make_memory_spec(const WindowRequest& r, size_t index, const TensorSpec& spec) {
  const uint64_t count = *spec.shape.count();
  if (count % r.frames_in != 0) {
    Error error = not_a_multiple(r, index, spec);
    error.offered = option("frames-in", r.frames_in) + ", and tensor " + std::to_string(index) +
                    " (" + spec.to_string() + ") has " + std::to_string(count) + " elements";
    error.needed = "a number of elements that is a multiple of frames-in";
    error.difference.clear();
    error.fix = option("frames-in", std::gcd(count, uint64_t{r.frames_in}));
    return error;
  }
  if (count / r.frames_in > UINT32_MAX) return too_big(spec, r);
  TensorSpec out{spec.type, {static_cast<uint32_t>(count / r.frames_in), r.frames_out}, ""};
  if (!out.bytes()) return too_big(spec, r);
  return out;
}

Status add_tensor(const WindowRequest& r, size_t index, const TensorSpec& spec, WindowPlan* plan) {
  if (!spec.bytes()) return too_big(spec, r);
  auto out = make_output(r, index, spec);
  if (!out) return out.error();
  TensorSpec memory = *out;
  if (spec.shape[r.dimension] == 0) {
    auto true_size = make_memory_spec(r, index, spec);
    if (!true_size) return true_size.error();
    plan->size_differs = plan->in != plan->out;
    if (plan->size_differs) memory = *std::move(true_size);
  }
  plan->layouts.push_back(make_layout(r, spec));
  plan->output.push_back(*std::move(out));
  plan->memory.push_back(std::move(memory));
  return ok();
}

template <size_t Size>
void copy_blocks(const std::byte* from, std::byte* to, size_t count, size_t stride) noexcept {
  for (size_t i = 0; i < count; ++i) std::memcpy(to + i * stride, from + i * Size, Size);
}

}  // namespace

uint64_t WindowPlan::buffers_waited() const noexcept {
  if (passes_through) return 0;
  // Offset of a window's start within its first buffer, at most.
  const uint64_t latest_begin = in - std::gcd(in, step);
  return (latest_begin + out - 1) / in;
}

Result<WindowPlan> plan(const WindowRequest& r, const std::vector<TensorSpec>& input) {
  WindowPlan plan;
  plan.in = r.frames_in;
  plan.out = r.frames_out;
  plan.step = r.frames_flush > 0 ? r.frames_flush : r.frames_out;
  const uint64_t max = plan.in * ((plan.out + plan.in - 1) / plan.in);
  if (plan.step > max) return cannot_flush(r, max);
  plan.passes_through = plan.in == plan.out && plan.step == plan.out;
  for (size_t i = 0; i < input.size(); ++i)
    if (auto status = add_tensor(r, i, input[i], &plan); !status) return status.error();
  return plan;
}

void place(const WindowLayout& layout, uint64_t index, uint64_t frames,
           std::span<const std::byte> frame, std::span<std::byte> out) noexcept {
  const size_t block = layout.block_bytes, count = layout.frame_bytes / block;
  const size_t stride = block * static_cast<size_t>(frames);
  const std::byte* from = frame.data();
  std::byte* to = out.data() + block * static_cast<size_t>(index);
  switch (block) {
    case 1:
      return copy_blocks<1>(from, to, count, stride);
    case 2:
      return copy_blocks<2>(from, to, count, stride);
    case 3:
      return copy_blocks<3>(from, to, count, stride);
    case 4:
      return copy_blocks<4>(from, to, count, stride);
    case 8:
      return copy_blocks<8>(from, to, count, stride);
    case 12:
      return copy_blocks<12>(from, to, count, stride);
    case 16:
      return copy_blocks<16>(from, to, count, stride);
    default:
      for (size_t i = 0; i < count; ++i) std::memcpy(to + i * stride, from + i * block, block);
  }
}

uint64_t to_time(uint64_t frames, const Fraction& rate) noexcept {
  if (!rate.valid() || rate.numerator == 0) return 0;
  __extension__ using Wide = unsigned __int128;
  constexpr uint64_t kSecond = 1'000'000'000;
  const Wide time = Wide{frames} * kSecond * static_cast<uint64_t>(rate.denominator) /
                    static_cast<uint64_t>(rate.numerator);
  return static_cast<uint64_t>(std::min(time, Wide{UINT64_MAX / 2}));
}

}  // namespace weir::window
