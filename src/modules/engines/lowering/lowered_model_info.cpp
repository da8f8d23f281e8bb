// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lowering/lowered_model_info.hpp"

#include <nlohmann/json.hpp>

#include "tflite-file/tflite_file.hpp"
#include "tflite-file/tflite_metadata.hpp"

namespace weir::engine {

std::string lowered_metadata(std::span<const std::byte> tflite) {
  const auto summary = read_tflite(tflite);
  if (!summary) return "{}";
  const nlohmann::json out{{"custom_metadata_map", tflite_properties(tflite, summary->metadata)},
                           {"description", summary->description},
                           {"lowering", "onnxruntime"},
                           {"operators", summary->operators}};
  return out.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void lay_over(std::span<const PortQuantization> source, std::span<weir_tensor_info> ports) {
  for (size_t i = 0; i < ports.size() && i < source.size(); ++i) {
    ports[i].scale = source[i].scale;
    ports[i].zero_point = source[i].zero_point;
    if (ports[i].rank == 4) ports[i].layout = WEIR_LAYOUT_NHWC;
  }
}

}  // namespace weir::engine
