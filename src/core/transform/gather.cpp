// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/gather.hpp"

#include <algorithm>
#include <cstring>

namespace weir::transform {
namespace {

constexpr size_t kBlockBytes = 16384;  // fits into the L1 cache together with its result
constexpr size_t kLongRun = 1024;      // bytes: copying more costs more than a kernel call

}  // namespace

GatherKernel::GatherKernel(Runs runs, FusedPart work)
    : runs_(std::move(runs)), work_(std::move(work)) {}

std::shared_ptr<const Kernel> GatherKernel::then(FusedPart next, size_t count) const {
  if (work_.kernel) {
    const ElementType from = work_.from, to = next.to;
    next = {make_fused_kernel(work_, std::move(next), count), from, to};
  }
  if (!next.kernel || next.kernel->period() == 0 ||
      next.kernel->period() > kBlockBytes / element_size(next.from))
    return nullptr;
  return std::shared_ptr<const Kernel>(new GatherKernel(runs_, std::move(next)));
}

std::span<const std::byte> GatherKernel::run_at(uint64_t offset,
                                                std::span<const std::byte> in) const noexcept {
  if (offset > in.size() || in.size() - offset < runs_.bytes) return {};
  return in.subspan(offset, runs_.bytes);
}

Counters GatherKernel::run(std::span<const std::byte> in, std::span<std::byte> out) const noexcept {
  if (!work_.kernel) {
    for_each_run(runs_, [&](uint64_t offset) {
      const auto run = run_at(offset, in);
      if (run.empty() || run.size() > out.size()) return false;
      std::memcpy(out.data(), run.data(), run.size());
      out = out.subspan(run.size());
      return true;
    });
    return {};
  }
  const size_t elements = runs_.bytes / element_size(work_.from);
  return runs_.bytes >= kLongRun && elements % work_.kernel->period() == 0 ? run_each(in, out)
                                                                           : run_blocks(in, out);
}

Counters GatherKernel::run_each(std::span<const std::byte> in,
                                std::span<std::byte> out) const noexcept {
  Counters counters;
  const size_t out_bytes = runs_.bytes / element_size(work_.from) * element_size(work_.to);
  for_each_run(runs_, [&](uint64_t offset) {
    const auto run = run_at(offset, in);
    if (run.empty() || out.size() < out_bytes) return false;
    counters.divisions_by_zero += work_.kernel->run(run, out.first(out_bytes)).divisions_by_zero;
    out = out.subspan(out_bytes);
    return true;
  });
  return counters;
}

// Collects runs until a block of whole periods is full.
Counters GatherKernel::run_blocks(std::span<const std::byte> in,
                                  std::span<std::byte> out) const noexcept {
  Counters counters;
  const size_t from = element_size(work_.from), to = element_size(work_.to);
  const size_t whole = work_.kernel->period() * from, room = kBlockBytes / whole * whole;
  alignas(64) std::byte block[kBlockBytes];
  size_t filled = 0;
  const auto flush = [&] {
    const size_t bytes = std::min(filled / from * to, out.size());
    counters.divisions_by_zero +=
        work_.kernel->run(std::span(block, filled), out.first(bytes)).divisions_by_zero;
    out = out.subspan(bytes);
    filled = 0;
  };
  for_each_run(runs_, [&](uint64_t offset) {
    auto run = run_at(offset, in);
    if (run.empty()) return false;
    while (!run.empty()) {
      const size_t part = std::min(run.size(), room - filled);
      std::memcpy(block + filled, run.data(), part);
      run = run.subspan(part);
      filled += part;
      if (filled == room) flush();
    }
    return true;
  });
  if (filled > 0) flush();
  return counters;
}

}  // namespace weir::transform
