// DnnRunner: the session of an open network; resolves shapes and invokes frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "opencv-dnn/dnn_model.hpp"

namespace weir::engine {

// The model's only session; one thread at a time.
class DnnRunner {
 public:
  static Result<std::unique_ptr<DnnRunner>> create(const DnnModel& model,
                                                   std::span<const weir_option> options);
  Status resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out);
  // OpenCV copies the inputs; outputs are copied from the network's memory.
  Status invoke(const weir_frame& in, weir_frame& out);
  Status warm();

 private:
  explicit DnnRunner(const DnnModel& model) : model_(model) {}
  const DnnModel& model_;
  std::vector<weir_tensor_info> last_inputs_;  // inputs of the last resolve, for WEIR_WARM
};

}  // namespace weir::engine
