// DescribedModel: what tensor_filter says downstream about the model whose outputs it pushes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "core/tensor/model_tensor.hpp"
#include "weir/abi.h"

namespace weir {

struct DescribedModel {
  std::vector<ModelTensor> inputs;         // of the model
  std::vector<ModelTensor> outputs;        // of the stream: after output-combination
  std::string path;                        // "" = none
  std::string metadata_json;               // "" = none
  std::vector<std::string> card_labels{};  // names of classes; not in the event
  bool operator==(const DescribedModel&) const = default;
};

// Whether `stream` can be the outputs of the model: a flexible stream always, a static one if types
// and shapes are equal.
bool has_outputs(const DescribedModel& model, const FrameSpec& stream);

// The model in the form that modules take.
class AbiModel {
 public:
  // The result borrows from `model` and from this object until the next call.
  const weir_stream_model& fill(const DescribedModel& model);

 private:
  std::vector<weir_tensor_info> inputs_, outputs_;
  std::vector<const char*> card_labels_;
  weir_stream_model model_{};
};

}  // namespace weir
