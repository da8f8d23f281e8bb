// A complete filter: values above `limit` become 1, the others 0; uint8 of any length.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <weir/engine.hpp>

class Threshold {
 public:
  static constexpr uint64_t kFlags = WEIR_ENGINE_NEEDS_NO_MODEL;
  static constexpr const char* kOptions =
      R"([{"name": "limit", "type": "integer", "default": "127", "help": "above it is 1"}])";

  explicit Threshold(const weir::OpenRequest& request)
      : limit_(std::stoi(std::string(request.options.get("limit").value_or("127")))) {}
  std::span<const weir_tensor_info> inputs() const { return {&bytes_, 1}; }
  std::span<const weir_tensor_info> outputs() const { return {&bytes_, 1}; }
  void resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out) {
    out[0].shape[0] = in[0].shape[0];
  }
  bool invoke(std::span<const weir_tensor> in, std::span<weir_tensor> out) {
    const auto x = weir::elements<const uint8_t>(in[0]);
    const auto y = weir::elements<uint8_t>(out[0]);
    for (size_t i = 0; i < x.size(); ++i) y[i] = x[i] > limit_;
    return true;
  }

 private:
  int limit_;
  weir_tensor_info bytes_ = weir::tensor_info("bytes", WEIR_UINT8, {-1});
};
WEIR_ENGINE(Threshold, "threshold", "1", "", "")
