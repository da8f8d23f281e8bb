// Compares requests with the description of a model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/request_check.hpp"

#include <algorithm>

#include "net/oip_contents.hpp"
#include "net/oip_types.hpp"
#include "weir/module.hpp"

namespace weir::net {
namespace {

std::string list(const std::vector<TensorText>& tensors) {
  std::string out;
  for (const auto& tensor : tensors) out += (out.empty() ? "" : ", ") + describe(tensor);
  return out.empty() ? "none" : out;
}

Error mismatch(const ModelMetadata& model, std::string offered, std::string needed) {
  return {.code = Code::SPEC_MISMATCH,
          .what = "the request does not fit the model " + model.name,
          .offered = std::move(offered),
          .needed = std::move(needed),
          .fix = "compare the request with the answer to ModelMetadata"};
}

std::span<const int64_t> without_outer_ones(std::span<const int64_t> shape) {
  while (!shape.empty() && shape.front() == 1) shape = shape.subspan(1);
  return shape;
}

bool same_shape(const TensorText& offered, const TensorText& needed) {
  const auto one = without_outer_ones(offered.shape), other = without_outer_ones(needed.shape);
  return std::equal(one.begin(), one.end(), other.begin(), other.end());
}

bool same_type(const TensorText& offered, const TensorText& needed) {
  return offered.datatype == needed.datatype ||
         (offered.datatype == "BOOL" && needed.datatype == "UINT8");
}

// The bytes of a tensor of the model, whose shape has no open dimension.
size_t bytes_of(const TensorText& tensor) {
  const auto* type = oip_type(tensor.datatype);
  size_t out = type ? element_bytes(type->type) : 0;
  for (const int64_t extent : tensor.shape) out *= static_cast<size_t>(extent);
  return out;
}

Status check_raw(const InferRequest& request, size_t index, const TensorText& needed,
                 const ModelMetadata& model) {
  if (request.raw.empty() || needed.datatype == "BYTES") return ok();
  const size_t offered = request.raw[index].size(), bytes = bytes_of(needed);
  if (offered == bytes) return ok();
  return mismatch(model, std::to_string(offered) + " bytes for " + describe(request.inputs[index]),
                  std::to_string(bytes) + " bytes for " + describe(needed));
}

}  // namespace

Result<std::vector<size_t>> match_inputs(const InferRequest& request, const ModelMetadata& model) {
  std::vector<size_t> out;
  if (request.inputs.size() != model.inputs.size())
    return mismatch(model, std::to_string(request.inputs.size()) + " inputs",
                    std::to_string(model.inputs.size()) + ": " + list(model.inputs));
  for (const auto& needed : model.inputs) {
    const auto found =
        std::find_if(request.inputs.begin(), request.inputs.end(),
                     [&](const auto& offered) { return offered.name == needed.name; });
    if (found == request.inputs.end())
      return mismatch(model, "no input with the name " + needed.name, list(model.inputs));
    if (!same_type(*found, needed) || !same_shape(*found, needed))
      return mismatch(model, describe(*found), describe(needed));
    const auto index = static_cast<size_t>(found - request.inputs.begin());
    if (auto status = check_raw(request, index, needed, model); !status) return status.error();
    out.push_back(index);
  }
  return out;
}

Result<std::vector<size_t>> match_outputs(const InferRequest& request, const ModelMetadata& model) {
  std::vector<size_t> out;
  for (const auto& name : request.outputs) {
    const auto found = std::find_if(model.outputs.begin(), model.outputs.end(),
                                    [&](const auto& known) { return known.name == name; });
    if (found == model.outputs.end())
      return mismatch(model, "a request for the output " + name, list(model.outputs));
    out.push_back(static_cast<size_t>(found - model.outputs.begin()));
  }
  for (size_t i = 0; request.outputs.empty() && i < model.outputs.size(); ++i) out.push_back(i);
  return out;
}

}  // namespace weir::net
