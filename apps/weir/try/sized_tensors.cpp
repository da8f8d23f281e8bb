// Runs a model once to learn the shapes of its outputs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "try/sized_tensors.hpp"

#include <algorithm>

#include "core/heads/usual_input.hpp"
#include "core/tensor/element_type.hpp"
#include "weir/model.hpp"
#include "weir/module.hpp"

namespace weir::app {
namespace {

bool is_open(const weir_tensor_info& info) {
  return info.rank > WEIR_RANK_LIMIT ||
         std::any_of(info.shape, info.shape + info.rank, [](int64_t extent) { return extent < 1; });
}

}  // namespace

std::vector<weir_tensor_info> sized_inputs(const infer::Model& model,
                                           const std::vector<int64_t>& shape) {
  auto out = model.inputs();
  for (auto& info : out) {
    if (info.rank > WEIR_RANK_LIMIT) continue;
    if (&info == out.data() && shape.size() == info.rank)
      std::copy(shape.begin(), shape.end(), info.shape);
    else
      heads::set_open_sides(model.info().metadata_json, &info);
  }
  return out;
}

std::vector<weir_tensor_info> sized_outputs(const infer::Model& model, const std::string& path,
                                            const std::vector<weir_tensor_info>& inputs) {
  auto out = model.outputs();
  if (std::none_of(out.begin(), out.end(), is_open)) return out;
  if (std::any_of(inputs.begin(), inputs.end(), is_open)) return out;
  auto runs = Model::open(path);
  if (!runs) return out;
  std::vector<std::vector<std::byte>> zeros;
  std::vector<TensorView> views;
  std::vector<TensorShape> shapes;
  for (const auto& info : inputs) {
    size_t bytes = element_size(static_cast<ElementType>(info.type));
    for (uint32_t i = 0; i < info.rank; ++i) bytes *= static_cast<size_t>(info.shape[i]);
    zeros.emplace_back(bytes);
    shapes.emplace_back(info.shape, info.shape + info.rank);
    views.emplace_back(zeros.back().data(), bytes, info.type, shapes.back());
  }
  if (!runs->reshape(shapes)) return out;
  const auto outputs = runs->invoke(views);
  if (!outputs || outputs->size() != out.size()) return out;
  for (size_t i = 0; i < out.size(); ++i) {
    const auto info = (*outputs)[i].info();
    out[i].rank = static_cast<uint32_t>(info.shape.size());
    std::copy(info.shape.begin(), info.shape.end(), out[i].shape);
  }
  return out;
}

}  // namespace weir::app
