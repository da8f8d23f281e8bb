// TorchModel: a TorchScript model opened by libtorch, with what it says of its inputs and outputs.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "pytorch/torch_options.hpp"
#include "pytorch/torch_program.hpp"

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
  int threads() const noexcept { return options_.threads; }

 private:
  TorchModel() = default;
  Status read_inputs(const std::string& name);
  Status read_outputs(const std::string& name);

  TorchOptions options_;
  std::unique_ptr<TorchProgram> program_;
  std::vector<std::string> names_;  // of inputs
  std::vector<weir_tensor_info> inputs_, outputs_;
  std::string metadata_;
};

}  // namespace weir::engine
