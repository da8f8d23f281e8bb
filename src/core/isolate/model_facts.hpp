// ModelFacts: what an engine says of a model, as values that go from process to process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "core/isolate/message.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::isolate {

// Descriptions with their names. They point to each other: moved, never copied.
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

struct ModelFacts {
  std::string engine;      // its name
  weir_model_info info{};  // no pointer in it is set
  TensorInfos inputs, outputs;
  std::string metadata_json;

  static ModelFacts take(MessageReader* message);
};
void put_model(const std::string& engine, const weir_model_info& info, MessageWriter* message);

// Types and shapes are the same.
bool same_tensors(const ModelFacts& a, const ModelFacts& b);

void put_error(const Error& error, MessageWriter* message);
Error take_error(MessageReader* message);

}  // namespace weir::isolate
