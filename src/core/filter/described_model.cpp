// Compares a described model with a stream and converts it for modules.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/filter/described_model.hpp"

#include <algorithm>

namespace weir {
namespace {

bool is_output(const DescribedTensor& output, const TensorSpec& tensor) {
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

std::vector<weir_tensor_info> infos_of(const std::vector<DescribedTensor>& tensors) {
  std::vector<weir_tensor_info> out;
  for (const DescribedTensor& tensor : tensors) {
    weir_tensor_info info{};
    info.type = static_cast<uint32_t>(tensor.type);
    info.rank = static_cast<uint32_t>(std::min<size_t>(tensor.shape.size(), WEIR_RANK_LIMIT));
    std::copy_n(tensor.shape.begin(), info.rank, info.shape);
    info.name = tensor.name.empty() ? nullptr : tensor.name.c_str();
    info.scale = tensor.scale;
    info.zero_point = tensor.zero_point;
    info.batch_axis = WEIR_NO_BATCH_AXIS;
    out.push_back(info);
  }
  return out;
}

}  // namespace

DescribedTensor described(const TensorSpec& spec) {
  DescribedTensor out;
  out.type = spec.type;
  for (size_t i = spec.shape.rank(); i-- > 0;) out.shape.push_back(spec.shape[i]);
  return out;
}

bool has_outputs(const DescribedModel& model, const FrameSpec& stream) {
  if (stream.format != Format::Static) return stream.format == Format::Flexible;
  return std::equal(model.outputs.begin(), model.outputs.end(), stream.tensors.begin(),
                    stream.tensors.end(), is_output);
}

const weir_stream_model& AbiModel::fill(const DescribedModel& model) {
  const auto text = [](const std::string& s) { return s.empty() ? nullptr : s.c_str(); };
  inputs_ = infos_of(model.inputs);
  outputs_ = infos_of(model.outputs);
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
