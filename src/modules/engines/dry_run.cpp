// SPDX-License-Identifier: LGPL-2.1-or-later
#include "dry_run.hpp"

#include <algorithm>

#include "tensor_check.hpp"

namespace weir::engine {

Status check_dry_run(std::span<const weir_tensor_info> infos) {
  uint64_t left = kDryRunBytes;
  for (const auto& info : infos) {
    const auto bytes = tensor_bytes(info);
    if (!bytes)
      return Error{.code = Code::SPEC_MISMATCH,
                   .what = "an input has an impossible size",
                   .offered = describe(info),
                   .needed = {},
                   .difference = {},
                   .fix = {}};
    if (*bytes > left)
      return Error{.code = Code::LIMIT_EXCEEDED,
                   .what = "the inputs are too large for a dry run",
                   .offered = describe(infos),
                   .needed = "at most " + std::to_string(kDryRunBytes) + " bytes together",
                   .difference = {},
                   .fix = {}};
    left -= *bytes;
  }
  return ok();
}

Result<DryRunInputs> DryRunInputs::create(std::span<const weir_tensor_info> infos) {
  if (auto status = check_dry_run(infos); !status) return status.error();
  DryRunInputs out;
  for (const auto& info : infos) {
    const uint64_t bytes = *tensor_bytes(info);
    // Only calloc() gives zeros without touching the memory.
    // NOLINTNEXTLINE(cppcoreguidelines-no-malloc)
    out.memory_.emplace_back(std::calloc(std::max<uint64_t>(bytes, 1), 1));
    if (!out.memory_.back())
      return Error{.code = Code::OUT_OF_MEMORY,
                   .what = "no memory for the inputs of a dry run",
                   .offered = describe(infos),
                   .needed = std::to_string(bytes) + " bytes",
                   .difference = {},
                   .fix = {}};
    weir_tensor tensor{};
    tensor.data = out.memory_.back().get();
    tensor.bytes = tensor.capacity = bytes;
    tensor.info = info;
    out.tensors_.push_back(tensor);
  }
  return out;
}

}  // namespace weir::engine
