// TorchRunner: resolves shapes and runs frames on an open TorchScript model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "pytorch/torch_model.hpp"

namespace weir::engine {

// One thread at a time; several runners may share a model.
class TorchRunner {
 public:
  static Result<std::unique_ptr<TorchRunner>> create(const TorchModel& model,
                                                     std::span<const weir_option> options);

  // Resolves output shapes by a dry run. SPEC_MISMATCH, with libtorch's message, for inputs that
  // the model rejects.
  Status resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out);
  Status invoke(const weir_frame& in, weir_frame& out);
  Status warm();
  Status reset_state();

 private:
  explicit TorchRunner(const TorchModel& model) : model_(model) {}

  const TorchModel& model_;
  std::vector<weir_tensor_info> last_inputs_;  // inputs of the last resolve, for WEIR_WARM
};

}  // namespace weir::engine
