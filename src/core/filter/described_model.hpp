// DescribedModel: what tensor_filter says downstream about the model whose outputs it pushes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "weir/decoder_model.h"

namespace weir {

struct DescribedTensor {
  ElementType type = ElementType::End;  // End: not known
  std::vector<int64_t> shape;           // outermost first, -1 = not known
  std::string name;
  float scale = 0;  // 0 = not quantised
  int32_t zero_point = 0;
  bool operator==(const DescribedTensor&) const = default;
};

struct DescribedModel {
  std::vector<DescribedTensor> inputs;     // of the model
  std::vector<DescribedTensor> outputs;    // of the stream: after output-combination
  std::string path;                        // "" = none
  std::string metadata_json;               // "" = none
  std::vector<std::string> card_labels{};  // names of classes; not in the event
  bool operator==(const DescribedModel&) const = default;
};

// Describes a tensor of a stream, which has no name.
DescribedTensor described(const TensorSpec& spec);

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
