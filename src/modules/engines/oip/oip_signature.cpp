// SPDX-License-Identifier: LGPL-2.1-or-later
#include "oip/oip_signature.hpp"

#include <algorithm>

#include "net/protocol/oip_types.hpp"
#include "weir/engine_tools.hpp"

namespace weir::engine {
namespace {

Result<OipTensor> tensor_from(const net::TensorText& text) {
  const auto* type = net::oip_type(text.datatype);
  if (!type)
    return unsupported_type("the server's tensor " + text.name, text.datatype,
                            text.datatype == "BF16" ? "a cast to FP32 in the model" : "",
                            "INT8 to INT64, UINT8 to UINT64, FP16, FP32, FP64, BOOL or BYTES");
  if (text.shape.size() > WEIR_RANK_LIMIT)
    return unsupported_rank("the server's tensor " + text.name,
                            static_cast<long long>(text.shape.size()));
  OipTensor out{
      .name = text.name, .datatype = text.datatype, .shape = text.shape, .type = type->type};
  for (auto& extent : out.shape) extent = extent < 0 ? -1 : extent;
  if (out.is_bytes()) {
    out.bytes_rank = out.shape.size();
    out.shape = {-1};
  }
  return out;
}

std::vector<OipTensor> tensors_from(const std::vector<DeclaredTensor>& declared) {
  std::vector<OipTensor> out;
  for (const auto& tensor : declared) {
    const auto* type = net::find_oip_type(tensor.type);
    if (!type || !tensor.has_shape) return {};
    out.push_back({.name = tensor.name,
                   .datatype = std::string(type->name),
                   .shape = tensor.shape,
                   .type = tensor.type});
  }
  return out;
}

std::string list(const std::vector<OipTensor>& tensors) {
  std::string out;
  for (const auto& tensor : tensors) out += (out.empty() ? "" : ", ") + tensor.to_string();
  return out;
}

}  // namespace

weir_tensor_info OipTensor::info() const {
  weir_tensor_info out = open_tensor_info();
  out.type = type;
  out.name = name.c_str();
  set_shape(&out, shape.begin(), shape.size());
  return out;
}

std::string OipTensor::to_string() const {
  std::string out = name + " " + datatype + " [";
  for (const int64_t extent : shape) out += (out.back() == '[' ? "" : ",") + std::to_string(extent);
  return out + "]";
}

std::string OipSignature::to_string() const {
  return "inputs " + list(inputs) + "; outputs " + list(outputs);
}

bool OipSignature::is_compatible(const OipSignature& other) const {
  const auto extents = [](int64_t a, int64_t b) { return a == b || a < 0 || b < 0; };
  const auto tensors = [&](const OipTensor& a, const OipTensor& b) {
    return a.datatype == b.datatype &&
           std::equal(a.shape.begin(), a.shape.end(), b.shape.begin(), b.shape.end(), extents);
  };
  return std::equal(inputs.begin(), inputs.end(), other.inputs.begin(), other.inputs.end(),
                    tensors) &&
         std::equal(outputs.begin(), outputs.end(), other.outputs.begin(), other.outputs.end(),
                    tensors);
}

Result<OipSignature> OipSignature::from(const net::ModelMetadata& metadata) {
  OipSignature out;
  for (const auto& [from, to] :
       {std::pair{&metadata.inputs, &out.inputs}, std::pair{&metadata.outputs, &out.outputs}})
    for (const auto& text : *from) {
      auto tensor = tensor_from(text);
      if (!tensor) return tensor.error();
      to->push_back(*std::move(tensor));
    }
  return out;
}

OipSignature OipSignature::from(const DeclaredTensors& declared) {
  OipSignature out{tensors_from(declared.inputs()), tensors_from(declared.outputs())};
  if (out.inputs.empty() || out.outputs.empty()) return {};
  return out;
}

}  // namespace weir::engine
