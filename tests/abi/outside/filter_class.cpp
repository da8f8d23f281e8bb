// A third-party library that registers a filter class when it is loaded: y = a + b x.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <weir/custom_filter.hpp>

#include <string>

class Line {
 public:
  explicit Line(const weir::OpenRequest& request)
      : a_(number(request.options, "a", 0)), b_(number(request.options, "b", 1)) {}
  std::span<const weir_tensor_info> inputs() const { return {&values_, 1}; }
  std::span<const weir_tensor_info> outputs() const { return {&values_, 1}; }
  void resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out) {
    out[0].shape[0] = in[0].shape[0];
  }
  bool invoke(std::span<const weir_tensor> in, std::span<weir_tensor> out) {
    const auto x = weir::elements<const float>(in[0]);
    const auto y = weir::elements<float>(out[0]);
    for (size_t i = 0; i < x.size(); ++i) y[i] = a_ + b_ * x[i];
    return true;
  }

 private:
  static float number(const weir::Options& options, const char* key, float otherwise) {
    const auto text = options.get(key);
    return text ? std::stof(std::string(*text)) : otherwise;
  }
  float a_, b_;
  weir_tensor_info values_ = weir::tensor_info("values", WEIR_FLOAT32, {-1});
};
WEIR_FILTER_CLASS(Line, "Line")
