// SPDX-License-Identifier: LGPL-2.1-or-later

#include "core/decoders/decoders.hpp"

#include <vector>

#include "core/infer/module/host.hpp"
#include "weir/module.hpp"

namespace weir::decoders {

const weir_module& builtin_decoders() {
  module_host = &infer::host();
  static const auto decoders = [] {
    std::vector<const weir_decoder_type*> out{&bounding_boxes(), &image_segment(),
                                              &pose_estimation(), &tensor_region()};
    const auto results = results_decoders();
    out.insert(out.end(), results.begin(), results.end());
    const auto records = record_decoders();
    out.insert(out.end(), records.begin(), records.end());
    out.push_back(nullptr);
    return out;
  }();
  static const weir_module module{sizeof(weir_module), WEIR_ABI_MAJOR, WEIR_ABI_MINOR, nullptr,
                                  decoders.data(),     nullptr,        nullptr,        nullptr};
  return module;
}

}  // namespace weir::decoders
