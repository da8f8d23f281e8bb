// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/batch/row_runner.hpp"

#include <algorithm>
#include <new>
#include <numeric>
#include <span>
#include <string>

namespace weir::infer {
namespace {

std::span<weir_tensor> get_tensors(const weir_frame& frame) {
  return {frame.tensors, frame.n_tensors};
}

Error not_by_rows(const std::string& what, const std::string& difference) {
  return {.code = Code::BATCH_UNSUPPORTED,
          .what = "the model's batch cannot be split",
          .offered = what,
          .needed = "an open first dimension of the same length in every input and output",
          .difference = difference,
          .fix = "tensor_filter invoke-rows=0 invoke-threads=1"};
}

Status check_open(const char* role, const std::vector<weir_tensor_info>& infos,
                  bool may_be_unknown) {
  for (size_t i = 0; i < infos.size(); ++i) {
    const auto& info = infos[i];
    const bool unknown = info.rank == WEIR_RANK_UNKNOWN;
    const bool is_declared = info.batch_axis == WEIR_NO_BATCH_AXIS || info.batch_axis == 0;
    if (unknown && may_be_unknown) continue;
    if (!unknown && info.rank > 0 && info.shape[0] == -1 && is_declared) continue;
    const std::string which = std::string(role) + " " + std::to_string(i);
    if (unknown || info.rank == 0) return not_by_rows("a tensor without rows", which);
    return not_by_rows(
        !is_declared ? "a batch on another dimension" : std::to_string(info.shape[0]) + " rows",
        which);
  }
  return ok();
}

bool is_one_row(const weir_tensor_info& info) {
  return info.rank != WEIR_RANK_UNKNOWN && info.rank > 0 && info.shape[0] == 1;
}

// Checks that all tensors of a frame have `rows` rows.
Status check_frame(const char* role, const weir_frame& frame, int64_t rows) {
  for (size_t i = 0; i < frame.n_tensors; ++i) {
    const weir_tensor& tensor = frame.tensors[i];
    const bool fits = tensor.info.rank > 0 && tensor.info.rank <= WEIR_RANK_LIMIT &&
                      tensor.info.shape[0] == rows && tensor.data &&
                      tensor.bytes % static_cast<uint64_t>(rows) == 0;
    if (fits) continue;
    return not_by_rows("a tensor that does not have " + std::to_string(rows) + " rows",
                       role + std::string(" ") + std::to_string(i));
  }
  return ok();
}

void cut(const weir_frame& whole, size_t rows, size_t first, size_t count,
         std::vector<weir_tensor>* tensors, weir_frame* part) {
  tensors->assign(whole.tensors, whole.tensors + whole.n_tensors);
  for (weir_tensor& tensor : *tensors) {
    const uint64_t row = tensor.bytes / rows, offset = row * first;
    tensor.data = static_cast<std::byte*>(tensor.data) + offset;
    tensor.bytes = row * count;
    tensor.capacity -= std::min(tensor.capacity, offset);
    tensor.info.shape[0] = static_cast<int64_t>(count);
  }
  *part = whole;
  part->tensors = tensors->data();
  if (whole.maps && whole.n_maps == rows) {
    part->maps = whole.maps + first;
    part->n_maps = static_cast<uint32_t>(count);
  }
}

}  // namespace

bool has_single_row(uint32_t flags, const std::vector<weir_tensor_info>& inputs,
                    const std::vector<weir_tensor_info>& outputs) {
  return (flags & (WEIR_MODEL_STATEFUL | WEIR_MODEL_DYNAMIC_OUTPUT)) == 0 && !inputs.empty() &&
         std::all_of(inputs.begin(), inputs.end(), is_one_row) &&
         std::all_of(outputs.begin(), outputs.end(), is_one_row);
}

Status check_rows(uint32_t flags, const std::vector<weir_tensor_info>& inputs,
                  const std::vector<weir_tensor_info>& outputs) {
  if (flags & WEIR_MODEL_STATEFUL) return not_by_rows("a model that keeps state", "");
  if (flags & WEIR_MODEL_DYNAMIC_OUTPUT)
    return not_by_rows("a model that decides the sizes of its outputs", "");
  if (inputs.empty()) return not_by_rows("a model without inputs", "");
  if (auto status = check_open("input", inputs, false); !status) return status;
  return check_open("output", outputs, true);
}

// Parts of equal size, except the last, which has the remaining rows.
size_t RowRunner::rows_of_a_part(const weir_frame& in, size_t rows, size_t alignment) const {
  size_t step = 1;  // rows between two aligned rows
  for (const weir_tensor& tensor : get_tensors(in)) {
    const size_t row = tensor.bytes / rows;
    step = std::lcm(step, alignment / std::gcd(row, alignment));
  }
  size_t parts = limits_.rows > 0 ? (rows + limits_.rows - 1) / limits_.rows : 1;
  const size_t threads = team_.threads();
  parts = (parts + threads - 1) / threads * threads;
  const size_t wanted = (rows + parts - 1) / parts;
  const size_t down = wanted / step * step;
  return std::max(wanted % step == 0 ? wanted : down, step);
}

void RowRunner::run_part(size_t thread, const Invoke& invoke, Part* part) {
  try {
    auto kept = invoke(thread, part->in, part->out);
    if (kept)
      part->kept = *kept;
    else
      part->status = kept.error();
  } catch (const std::bad_alloc&) {
    part->status = Error{.code = Code::OUT_OF_MEMORY, .what = "memory ran out"};
  } catch (const std::exception& e) {
    part->status = Error{.code = Code::INTERNAL, .what = e.what()};
  }
}

Result<bool> RowRunner::run(const weir_frame& in, weir_frame& out, size_t alignment,
                            const Invoke& invoke) {
  if (in.n_tensors == 0 || in.tensors[0].info.rank == 0 || in.tensors[0].info.shape[0] < 1)
    return not_by_rows("a frame without rows", "input 0");
  const auto rows = static_cast<size_t>(in.tensors[0].info.shape[0]);
  for (const auto& [role, frame] :
       {std::pair{"input", &in}, std::pair<const char*, const weir_frame*>{"output", &out}})
    if (auto status = check_frame(role, *frame, static_cast<int64_t>(rows)); !status)
      return status.error();
  const size_t length = rows_of_a_part(in, rows, std::max<size_t>(alignment, 1));
  if (limits_.single && length > 1 && rows > 1)
    return Error{.code = Code::BATCH_UNSUPPORTED,
                 .what = "the rows of a batch are not aligned as the model requires",
                 .offered = "rows of " + std::to_string(in.tensors[0].bytes / rows) + " bytes",
                 .needed = "a multiple of " + std::to_string(alignment) + " bytes",
                 .fix = "use a model with an open first dimension"};
  const size_t parts = (rows + length - 1) / length;
  if (parts_.size() < parts) parts_.resize(parts);
  for (size_t i = 0; i < parts; ++i) {
    Part& part = parts_[i];
    const size_t first = i * length, count = std::min(length, rows - first);
    cut(in, rows, first, count, &part.inputs, &part.in);
    cut(out, rows, first, count, &part.outputs, &part.out);
    part.status = ok();
    part.kept = true;
  }
  team_.run(parts, [&](size_t thread, size_t i) { run_part(thread, invoke, &parts_[i]); });
  bool kept = true;
  for (size_t i = 0; i < parts; ++i) {
    if (!parts_[i].status) return parts_[i].status.error();
    kept = kept && parts_[i].kept;
  }
  return kept;
}

}  // namespace weir::infer
