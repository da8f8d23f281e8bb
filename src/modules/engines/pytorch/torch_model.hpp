// TorchModel: a TorchScript model opened by libtorch, with its inputs and outputs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <atomic>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "pytorch/torch_options.hpp"
#include "pytorch/torch_program.hpp"
#include "weir/abi.h"

namespace weir::engine {

class TorchModel {
 public:
  static Result<std::unique_ptr<TorchModel>> open(const weir_open& request);
  TorchModel(const TorchModel&) = delete;
  TorchModel& operator=(const TorchModel&) = delete;

  void describe(weir_model_info* info) const;

  const TorchProgram& program() const noexcept { return *program_; }
  const std::vector<weir_tensor_info>& inputs() const noexcept { return inputs_; }
  const std::vector<weir_tensor_info>& outputs() const noexcept { return outputs_; }
  // Threads of one invoke: the requested number or the choice of choose_threads(); 1 until then.
  int threads() const noexcept { return std::max(threads_.load(), 1); }
  // Chooses by the work of the model on inputs of these shapes.
  void choose_threads(std::span<const weir_tensor_info> inputs) const;
  weir_execution execution() const noexcept {
    return {sizeof(weir_execution), static_cast<uint32_t>(threads_.load()), 0};
  }

 private:
  TorchModel() = default;
  Status read_inputs(const std::string& name);
  Status read_outputs(const std::string& name);

  TorchOptions options_;
  mutable std::atomic<int> threads_{0};  // 0 = not chosen yet
  std::unique_ptr<TorchProgram> program_;
  std::vector<std::string> names_;  // names of inputs
  std::vector<weir_tensor_info> inputs_, outputs_;
  std::string metadata_;
};

}  // namespace weir::engine
