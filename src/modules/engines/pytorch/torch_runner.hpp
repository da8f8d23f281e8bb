// TorchRunner: shapes and frames through an opened TorchScript model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "pytorch/torch_model.hpp"

namespace weir::engine {

// Used by one thread at a time; several may share a model.
class TorchRunner {
 public:
  static Result<std::unique_ptr<TorchRunner>> create(const TorchModel& model,
                                                     std::span<const weir_option> options);

  // Output shapes by a dry run. Inputs that the model does not take are a SPEC_MISMATCH in
  // libtorch's words.
  Status resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out);
  Status invoke(const weir_frame& in, weir_frame& out);
  Status warm();
  Status reset_state();

 private:
  explicit TorchRunner(const TorchModel& model) : model_(model) {}

  const TorchModel& model_;
  std::vector<weir_tensor_info> last_inputs_;  // of the last resolve, for WARM
};

}  // namespace weir::engine
