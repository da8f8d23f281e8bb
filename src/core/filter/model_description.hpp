// ModelDescription: the tensors of a model as tensor_filter uses and shows them: the model's
// declaration, overridden by the user's properties. Needs no engine and no stream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "core/filter/combination.hpp"
#include "core/filter/model_fit.hpp"

namespace weir {

// The user's properties of these names; empty = use the model's declaration.
struct DeclaredTensors {
  std::string input{}, inputtype{}, inputname{}, inputlayout{};
  std::string output{}, outputtype{}, outputname{}, outputlayout{};
  std::string input_combination{}, output_combination{};
  bool invoke_dynamic = false;
  bool operator==(const DeclaredTensors&) const = default;
};

// The tensors of one frame; parts may be open.
struct ModelTensors {
  std::vector<ModelTensor> inputs, outputs;
};

struct ModelDescription : ModelTensors {
  std::vector<size_t> input_choice;  // stream tensors given to the model; empty = all
  OutputCombination output_choice;   // empty = all model outputs
  DeclaredTensors declared;

  // The streams of the sink and source pad as far as they are known before caps; without tensors if
  // nothing is known.
  FrameSpec sink_spec() const;
  FrameSpec source_spec() const;
  // The same for a stream `sink` and the model's outputs for it.
  Result<FrameSpec> source_spec(const FrameSpec& sink, const std::vector<ModelTensor>& outputs,
                                bool sizes_known) const;
  // The outputs that the engine reports for a stream, with open parts filled from the user's
  // properties. SPEC_MISMATCH if the user contradicts the engine.
  Result<std::vector<ModelTensor>> complete_outputs(std::vector<ModelTensor> resolved) const;
  Status check_output_choice(const std::vector<ModelTensor>& outputs) const;

 private:
  std::vector<TensorSpec> chosen_outputs(const std::vector<ModelTensor>& outputs) const;
};

// `model` is the model's declaration. `warnings` gets the settings that are ignored because they
// are not understood.
Result<ModelDescription> describe_model(ModelTensors model, const DeclaredTensors& declared,
                                        std::vector<Error>* warnings);

// False for an empty list: such a model leaves the number of its tensors open.
bool all_fixed(const std::vector<ModelTensor>& shapes);

// Lists as written in the properties; "" for no tensors.
std::string dimensions_text(const std::vector<ModelTensor>& shapes);
std::string types_text(const std::vector<ModelTensor>& shapes);
std::string names_text(const std::vector<ModelTensor>& shapes);
std::string layouts_text(const std::vector<ModelTensor>& shapes);
std::string ranks_text(const std::vector<ModelTensor>& shapes);  // 1 where nothing is known

}  // namespace weir
