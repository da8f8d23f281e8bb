// Properties: what a filter is told about its element, and what it points to.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <string>
#include <vector>

#include "compat/tensors.hpp"
#include "tensor_typedef.h"
#include "weir/engine.hpp"

namespace weir::compat {

// At one place while the filter is open: filters keep the pointer.
class Properties {
 public:
  // `name`: of the framework. `shown`: what errors call the filter. Nothing is opened.
  Properties(std::string name, std::string shown, const OpenRequest& request);
  ~Properties();
  Properties(const Properties&) = delete;
  Properties& operator=(const Properties&) = delete;

  GstTensorFilterProperties* get() noexcept { return &value_; }
  const std::string& shown() const noexcept { return shown_; }
  bool dynamic() const noexcept { return value_.invoke_dynamic; }
  bool asynchronous() const noexcept { return value_.invoke_async; }
  // How long the user lets it say nothing of its frames; zero: as long as it takes.
  std::chrono::milliseconds async_timeout() const noexcept { return async_timeout_; }
  // How many outputs the user says that there are; 0: nothing said.
  size_t declared_outputs() const noexcept { return value_.output_meta.num_tensors; }

  // What accelerator= comes to: `supported` are the framework's, none for one that does not say.
  // `whole_list`: every wish that is supported, else the first.
  void choose_hardware(const std::vector<accl_hw>& supported, accl_hw automatic, accl_hw standard,
                       bool whole_list);
  // The stream's tensors.
  void configure_inputs(std::span<const weir_tensor_info> inputs);
  void configure_outputs(std::span<const weir_tensor_info> outputs);
  // Names that a dynamic filter put into output_meta are its own.
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
