// WorkerModelInfo: an engine's description of a model, as values sent between processes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/isolate/message.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::isolate {

// Descriptions with their names. Movable but not copyable, since they point to each other.
class TensorInfos {
 public:
  TensorInfos() = default;
  TensorInfos(TensorInfos&&) = default;
  TensorInfos& operator=(TensorInfos&&) = default;

  static TensorInfos take(MessageReader* message);
  std::vector<weir_tensor_info>& list() noexcept { return list_; }
  const std::vector<weir_tensor_info>& list() const noexcept { return list_; }

 private:
  std::vector<weir_tensor_info> list_;
  std::vector<std::string> names_;
};

void put_infos(std::span<const weir_tensor_info> infos, MessageWriter* message);

// What the worker made of the property accelerator: it alone knows what the engine supports.
struct AcceleratorChoice {
  std::string used;  // as weir_open.accelerator
  std::optional<Error> warning = {};
};

struct WorkerModelInfo {
  std::string engine;  // its name
  AcceleratorChoice accelerator;
  weir_model_info info{};  // without pointers
  TensorInfos inputs, outputs;
  std::string metadata_json;

  static WorkerModelInfo take(MessageReader* message);
};
void put_model(const std::string& engine, const AcceleratorChoice& accelerator,
               const weir_model_info& info, MessageWriter* message);

// True if types and shapes are the same.
bool same_tensors(const WorkerModelInfo& a, const WorkerModelInfo& b);

void put_error(const Error& error, MessageWriter* message);
Error take_error(MessageReader* message);

}  // namespace weir::isolate
