// A third-party library that registers its own filter when it is loaded: y = x / 2.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <weir/custom_filter.hpp>

namespace {

[[maybe_unused]] const bool registered =
    weir::RegisteredFilter::keep("halved",
                                 {.inputs = {weir::tensor_info("x", WEIR_FLOAT32, {1, 4})},
                                  .outputs = {weir::tensor_info("y", WEIR_FLOAT32, {1, 4})}},
                                 [](std::span<const weir_tensor> in, std::span<weir_tensor> out) {
                                   const auto x = weir::elements<const float>(in[0]);
                                   const auto y = weir::elements<float>(out[0]);
                                   for (size_t i = 0; i < x.size(); ++i) y[i] = x[i] / 2;
                                 });

}  // namespace
