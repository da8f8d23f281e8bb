// Properties: the GstTensorFilterProperties passed to a filter, with all it points to.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <string>
#include <vector>

#include "compat/tensors.hpp"
#include "tensor_typedef.h"
#include "weir/engine.hpp"

namespace weir::compat {

// Does not move while the filter is open: filters keep the pointer.
class Properties {
 public:
  // `name`: of the framework. `shown`: the filter's name in errors. Opens nothing.
  Properties(std::string name, std::string shown, const OpenRequest& request);
  ~Properties();
  Properties(const Properties&) = delete;
  Properties& operator=(const Properties&) = delete;

  GstTensorFilterProperties* get() noexcept { return &value_; }
  const std::string& shown() const noexcept { return shown_; }
  bool dynamic() const noexcept { return value_.invoke_dynamic; }
  bool asynchronous() const noexcept { return value_.invoke_async; }
  // Returns how long the filter may be silent, set by the user; zero: forever.
  std::chrono::milliseconds async_timeout() const noexcept { return async_timeout_; }
  // Returns the number of outputs that the user declared; 0: not declared.
  size_t declared_outputs() const noexcept { return value_.output_meta.num_tensors; }

  // Resolves accelerator=. `supported`: the framework's, empty if it gives none. `whole_list`: all
  // supported requests, else only the first.
  void choose_hardware(const std::vector<accl_hw>& supported, accl_hw automatic, accl_hw standard,
                       bool whole_list);
  // Sets the stream's tensors.
  void configure_inputs(std::span<const weir_tensor_info> inputs);
  void configure_outputs(std::span<const weir_tensor_info> outputs);
  // Names that a dynamic filter wrote into output_meta belong to the filter.
  void forget_output_names() noexcept;

 private:
  std::string name_, shown_, custom_, accelerator_, key_;
  std::vector<std::string> models_;
  std::vector<const char*> model_files_;
  std::vector<accl_hw> hardware_;
  const std::chrono::milliseconds async_timeout_;
  GstTensorFilterProperties value_{};
};

}  // namespace weir::compat
