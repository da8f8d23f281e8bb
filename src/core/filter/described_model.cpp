// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/filter/described_model.hpp"

#include <algorithm>

namespace weir {
namespace {

bool is_output(const ModelTensor& output, const TensorSpec& tensor) {
  if (output.type != tensor.type || output.shape.size() > kRankLimit) return false;
  Shape shape;
  const size_t rank = output.shape.size();
  for (size_t i = 0; i < rank; ++i) {
    const int64_t extent = output.shape[rank - 1 - i];
    if (extent < 1 || extent > UINT32_MAX) return false;
    shape[i] = static_cast<uint32_t>(extent);
  }
  if (rank == 0) shape = Shape{1};
  return shape == tensor.shape;
}

// Tensors without a name have none, rather than "".
std::vector<weir_tensor_info> to_infos(const std::vector<ModelTensor>& tensors) {
  auto infos = tensor_infos(tensors);
  for (auto& info : infos)
    if (*info.name == '\0') info.name = nullptr;
  return infos;
}

}  // namespace

bool has_outputs(const DescribedModel& model, const FrameSpec& stream) {
  if (stream.format != Format::Static) return stream.format == Format::Flexible;
  return std::equal(model.outputs.begin(), model.outputs.end(), stream.tensors.begin(),
                    stream.tensors.end(), is_output);
}

const weir_stream_model& AbiModel::fill(const DescribedModel& model) {
  const auto text = [](const std::string& s) { return s.empty() ? nullptr : s.c_str(); };
  inputs_ = to_infos(model.inputs);
  outputs_ = to_infos(model.outputs);
  card_labels_.clear();
  for (const auto& label : model.card_labels) card_labels_.push_back(label.c_str());
  model_ = {sizeof model_,
            static_cast<uint32_t>(inputs_.size()),
            static_cast<uint32_t>(outputs_.size()),
            inputs_.data(),
            outputs_.data(),
            text(model.path),
            text(model.metadata_json),
            card_labels_.data(),
            static_cast<uint32_t>(card_labels_.size())};
  return model_;
}

}  // namespace weir
