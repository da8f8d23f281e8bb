// SPDX-License-Identifier: LGPL-2.1-or-later
#include "onnxruntime/symbolic_shapes.hpp"

#include <algorithm>
#include <map>

namespace weir::engine {
namespace {

constexpr int64_t kAmbiguous = -2;  // the model uses the name for different sizes: ignore it

template <class Info, class Visit>
void for_each_named(std::span<Info> infos, const DimensionNames& names, Visit visit) {
  for (size_t i = 0; i < std::min(infos.size(), names.size()); ++i) {
    if (infos[i].rank > WEIR_RANK_LIMIT) continue;
    const size_t rank = std::min<size_t>(infos[i].rank, names[i].size());
    for (size_t d = 0; d < rank; ++d)
      if (!names[i][d].empty()) visit(names[i][d], infos[i].shape[d]);
  }
}

}  // namespace

void substitute_symbols(std::span<const weir_tensor_info> inputs, const DimensionNames& input_names,
                        std::span<weir_tensor_info> outputs, const DimensionNames& output_names) {
  std::map<std::string, int64_t> sizes;
  for_each_named(inputs, input_names, [&](const std::string& name, int64_t size) {
    const auto [at, added] = sizes.emplace(name, size);
    if (!added && at->second != size) at->second = kAmbiguous;
  });
  for_each_named(outputs, output_names, [&](const std::string& name, int64_t& size) {
    const auto at = sizes.find(name);
    if (size < 0 && at != sizes.end() && at->second >= 0) size = at->second;
  });
}

}  // namespace weir::engine
