// SPDX-License-Identifier: LGPL-2.1-or-later
#include "opencv-dnn/dnn_runner.hpp"

#include <algorithm>

#include "tensor_check.hpp"

namespace weir::engine {
namespace {

bool same_shapes(std::span<const weir_tensor_info> a, std::span<const weir_tensor_info> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
    return x.type == y.type && x.rank == y.rank && std::equal(x.shape, x.shape + x.rank, y.shape);
  });
}

}  // namespace

Result<std::unique_ptr<DnnRunner>> DnnRunner::create(const DnnModel& model,
                                                     std::span<const weir_option>) {
  return std::unique_ptr<DnnRunner>(new DnnRunner(model));
}

Status DnnRunner::resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out) {
  if (auto status = check_infos(model_.inputs(), in, "input"); !status) return status;
  if (auto status = check_count(model_.outputs(), out.size(), "output"); !status) return status;
  std::copy(model_.outputs().begin(), model_.outputs().end(), out.begin());
  if (!std::all_of(in.begin(), in.end(), is_fixed)) return ok();
  last_inputs_.assign(in.begin(), in.end());
  if (same_shapes(in, model_.inputs())) return ok();  // already run when the model was opened
  auto found = model_.dry_run(in);
  if (!found) return found.error();
  std::copy(found->begin(), found->end(), out.begin());
  return ok();
}

Status DnnRunner::invoke(const weir_frame& in, weir_frame& out) {
  const auto inputs = get_tensors(in), outputs = get_tensors(out);
  if (auto status = check_inputs(model_.inputs(), inputs); !status) return status;
  if (auto status = check_outputs(model_.outputs(), outputs); !status) return status;
  const auto made = model_.run(inputs);
  if (!made) return made.error();
  if (auto status = check_count(model_.outputs(), made->size(), "output"); !status) return status;
  for (size_t i = 0; i < outputs.size(); ++i)
    if (auto status = write_output((*made)[i].info, (*made)[i].data, i, &outputs[i]); !status)
      return status;
  return ok();
}

Status DnnRunner::warm() {
  const auto& inputs = last_inputs_.empty() ? model_.inputs() : last_inputs_;
  if (!std::all_of(inputs.begin(), inputs.end(), is_fixed)) return ok();
  const auto found = model_.dry_run(inputs);
  return found ? ok() : Status(found.error());
}

}  // namespace weir::engine
