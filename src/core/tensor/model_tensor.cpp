// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/model_tensor.hpp"

#include <algorithm>

#include "weir/join.hpp"

namespace weir {

bool ModelTensor::fixed() const noexcept {
  return type != ElementType::End && rank_known &&
         std::all_of(shape.begin(), shape.end(), [](int64_t d) { return d > 0; });
}

int64_t ModelTensor::inner(size_t i) const noexcept {
  return i < shape.size() ? shape[shape.size() - 1 - i] : 1;
}

std::string ModelTensor::to_string() const {
  std::string out = type == ElementType::End ? "any type" : std::string(weir::to_string(type));
  if (!rank_known) return out + " of any dimension";
  out += ' ';
  if (shape.empty()) return out + "1";
  for (size_t i = 0; i < shape.size(); ++i) {
    const int64_t d = inner(i);
    out += (i ? ":" : "") + (d < 0 ? std::string("?") : std::to_string(d));
  }
  return out;
}

TensorSpec to_spec(const ModelTensor& model) {
  TensorSpec spec{model.type, {}, model.name};
  if (model.shape.empty()) spec.shape[0] = 1;
  for (size_t i = 0; i < std::min(model.shape.size(), kRankLimit); ++i)
    spec.shape[i] = static_cast<uint32_t>(model.inner(i));
  if (spec.shape.rank() < model.shape.size()) spec.shape.set_rank(model.shape.size());
  return spec;
}

std::string list_tensors(const std::vector<ModelTensor>& tensors) {
  return std::to_string(tensors.size()) + (tensors.size() == 1 ? " tensor: " : " tensors: ") +
         join(tensors, ", ", [](const ModelTensor& tensor) { return tensor.to_string(); });
}

std::vector<TensorSpec> known_parts(const std::vector<ModelTensor>& tensors) {
  std::vector<TensorSpec> out;
  for (const auto& tensor : tensors) {
    if (tensor.fixed())
      out.push_back(to_spec(tensor));
    else
      out.push_back({tensor.type, {}, tensor.name});
  }
  return out;
}

ModelTensor model_tensor(const TensorSpec& spec) {
  ModelTensor tensor{.type = spec.type, .rank_known = true};
  for (size_t i = spec.shape.rank(); i-- > 0;) tensor.shape.push_back(spec.shape[i]);
  return tensor;
}

ModelTensor model_tensor(const weir_tensor_info& info) {
  ModelTensor tensor;
  tensor.type = static_cast<ElementType>(info.type);
  tensor.rank_known = info.rank != WEIR_RANK_UNKNOWN;
  if (tensor.rank_known)
    tensor.shape.assign(info.shape, info.shape + std::min<uint32_t>(info.rank, WEIR_RANK_LIMIT));
  if (info.name) tensor.name = info.name;
  tensor.layout = info.layout;
  tensor.scale = info.scale;
  tensor.zero_point = info.zero_point;
  return tensor;
}

std::vector<ModelTensor> model_tensors(std::span<const weir_tensor_info> infos) {
  std::vector<ModelTensor> out;
  out.reserve(infos.size());
  for (const auto& info : infos) out.push_back(model_tensor(info));
  return out;
}

weir_tensor_info tensor_info(const ModelTensor& tensor) {
  weir_tensor_info info{};
  info.type = static_cast<uint32_t>(tensor.type);
  info.rank = tensor.rank_known ? static_cast<uint32_t>(tensor.shape.size()) : WEIR_RANK_UNKNOWN;
  std::copy_n(tensor.shape.begin(), std::min<size_t>(tensor.shape.size(), WEIR_RANK_LIMIT),
              info.shape);
  info.name = tensor.name.c_str();
  info.layout = tensor.layout;
  info.scale = tensor.scale;
  info.zero_point = tensor.zero_point;
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  return info;
}

std::vector<weir_tensor_info> tensor_infos(const std::vector<ModelTensor>& tensors) {
  std::vector<weir_tensor_info> out;
  out.reserve(tensors.size());
  for (const auto& tensor : tensors) out.push_back(tensor_info(tensor));
  return out;
}

std::vector<weir_tensor> frame_tensors(const std::vector<ModelTensor>& tensors) {
  std::vector<weir_tensor> out(tensors.size());
  for (size_t i = 0; i < tensors.size(); ++i) {
    out[i].info = tensor_info(tensors[i]);
    out[i].memory_kind = WEIR_MEMORY_HOST;
    out[i].fence_fd = -1;
    if (tensors[i].fixed()) out[i].bytes = to_spec(tensors[i]).bytes().value_or(0);
  }
  return out;
}

std::string first_difference(const std::vector<ModelTensor>& offered,
                             const std::vector<ModelTensor>& needed, const std::string& role) {
  if (offered.size() != needed.size())
    return std::to_string(offered.size()) + " " + role + "s, needed are " +
           std::to_string(needed.size());
  for (size_t i = 0; i < offered.size(); ++i) {
    const auto &a = offered[i], &b = needed[i];
    if (a.type != b.type || a.rank_known != b.rank_known || a.shape != b.shape)
      return role + " " + std::to_string(i) + " is " + a.to_string() + ", needed is " +
             b.to_string();
  }
  return "";
}

}  // namespace weir
