// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pytorch/torch_runner.hpp"

#include <algorithm>

#include "tensor_check.hpp"

namespace weir::engine {
Result<std::unique_ptr<TorchRunner>> TorchRunner::create(const TorchModel& model,
                                                         std::span<const weir_option>) {
  return std::unique_ptr<TorchRunner>(new TorchRunner(model));
}

Status TorchRunner::resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out) {
  if (auto status = check_infos(model_.inputs(), in, "input"); !status) return status;
  if (auto status = check_count(model_.outputs(), out.size(), "output"); !status) return status;
  std::copy(model_.outputs().begin(), model_.outputs().end(), out.begin());
  const bool whole = std::all_of(in.begin(), in.end(), [](const auto& info) {
    return is_fixed(info) && tensor_bytes(info).has_value();
  });
  if (!whole) return ok();
  last_inputs_.assign(in.begin(), in.end());
  model_.choose_threads(in);
  const auto found = model_.program().dry_run(in, model_.threads());
  if (!found) {
    if (found.error().code == Code::LIMIT_EXCEEDED) return ok();  // the first frame decides
    if (found.error().code != Code::INVOKE_FAILED) return found.error();
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the model does not accept inputs of these shapes and types",
                 .offered = describe(in),
                 .needed = describe(model_.inputs()),
                 .difference = found.error().offered,
                 .fix =
                     "set input= and inputtype= to what the model was built for, and convert the "
                     "stream to it"};
  }
  if (auto status = check_count(model_.outputs(), found->size(), "output"); !status) return status;
  for (size_t i = 0; i < out.size(); ++i) {
    const char* name = out[i].name;
    out[i] = (*found)[i];
    out[i].name = name;
    if (model_.program().facts().sizes_depend_on_data) std::fill_n(out[i].shape, out[i].rank, -1);
  }
  return ok();
}

Status TorchRunner::invoke(const weir_frame& in, weir_frame& out) {
  const auto inputs = get_tensors(in), outputs = get_tensors(out);
  if (auto status = check_inputs(model_.inputs(), inputs); !status) return status;
  if (auto status = check_outputs(model_.outputs(), outputs); !status) return status;
  return model_.program().run(inputs, outputs, model_.threads());
}

Status TorchRunner::reset_state() {
  if (!model_.program().facts().has_state) return ok();
  return Error{.code = Code::MODEL_UNSUPPORTED,
               .what = "the state of this model cannot be reset",
               .offered = "reset",
               .needed = "a model without state; open it again"};
}

Status TorchRunner::warm() {
  if (last_inputs_.empty()) return ok();
  // libtorch profiles the first run and compiles for the second.
  for (int i = 0; i < 2; ++i)
    if (const auto found = model_.program().dry_run(last_inputs_, model_.threads()); !found)
      return found.error().code == Code::LIMIT_EXCEEDED ? ok() : Status(found.error());
  return ok();
}

}  // namespace weir::engine
