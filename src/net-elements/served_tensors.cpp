// Describes tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net-elements/served_tensors.hpp"

#include <algorithm>

#include "net/protocol/oip_types.hpp"

namespace weir {

std::vector<net::TensorText> describe_tensors(const std::vector<TensorSpec>& tensors,
                                              const std::string& name,
                                              const std::vector<std::string>& names) {
  std::vector<net::TensorText> out;
  for (const auto& tensor : tensors) {
    net::TensorText text;
    text.name = tensors.size() == 1 ? name : name + "_" + std::to_string(out.size());
    if (names.size() == tensors.size() && !names[out.size()].empty()) text.name = names[out.size()];
    if (const auto* type = net::oip_type_of(static_cast<uint32_t>(tensor.type)))
      text.datatype = type->name;
    for (size_t i = 0; i < tensor.shape.rank(); ++i) text.shape.push_back(tensor.shape[i]);
    std::reverse(text.shape.begin(), text.shape.end());
    out.push_back(std::move(text));
  }
  return out;
}

std::vector<net::TensorText> describe_bytes(const std::string& name) {
  return {{name, "BYTES", {1}}};
}

bool has_tensors(const GstCaps* caps) {
  const GstStructure* first = gst_caps_get_structure(caps, 0);
  return gst_structure_has_name(first, "other/tensor") ||
         gst_structure_has_name(first, "other/tensors");
}

}  // namespace weir
