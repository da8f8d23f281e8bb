// A C++ engine for tests, as a user would write one: y = factor * x on float32 of any length.
// Options: factor:NUMBER; throw-at:N (that invoke throws); any:N (accepts any number of tensors and
// outputs the first N, scaled).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "weir/engine.hpp"

namespace {

class Scaling {
 public:
  explicit Scaling(const weir::OpenRequest& request) {
    if (const auto text = request.options.get("factor")) {
      char* end = nullptr;
      const std::string number(*text);
      factor_ = std::strtof(number.c_str(), &end);
      if (number.empty() || *end)
        throw weir::Failure({.code = weir::Code::OPTION_VALUE,
                             .what = "factor is no number",
                             .offered = "factor:" + number,
                             .needed = "a number",
                             .fix = "custom=factor:2.5"});
    }
    if (const auto text = request.options.get("throw-at")) throw_at_ = std::atol(text->data());
    if (const auto text = request.options.get("any")) any_ = std::atol(text->data());
    tensor_.type = WEIR_FLOAT32;
    tensor_.rank = 1;
    tensor_.shape[0] = -1;
    tensor_.name = "values";
    tensor_.batch_axis = WEIR_NO_BATCH_AXIS;
  }
  std::span<const weir_tensor_info> inputs() const { return {&tensor_, any_ < 0 ? 1u : 0u}; }
  std::span<const weir_tensor_info> outputs() const { return inputs(); }
  void resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out) {
    if (any_ < 0) out[0].shape[0] = in[0].shape[0];
    for (size_t i = 0; i < std::min<size_t>(any_ < 0 ? 0 : any_, in.size()); ++i) out[i] = in[i];
  }
  bool invoke(std::span<const weir_tensor> in, std::span<weir_tensor> out) {
    if (invokes_++ == throw_at_) throw std::runtime_error("thrown in an engine");
    for (size_t tensor = 0; tensor < out.size(); ++tensor) {
      const auto* x = static_cast<const float*>(in[tensor].data);
      auto* y = static_cast<float*>(out[tensor].data);
      for (size_t i = 0; i < in[tensor].bytes / sizeof *x; ++i) y[i] = factor_ * x[i];
    }
    return true;
  }

 private:
  weir_tensor_info tensor_{};
  float factor_ = 1;
  long invokes_ = 0, throw_at_ = -1, any_ = -1;
};

}  // namespace

WEIR_ENGINE(Scaling, "scaling", "1", "", "")
