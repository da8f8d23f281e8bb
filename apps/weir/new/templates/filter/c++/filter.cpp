// The filter my-filter: y = 255 - x, for uint8 tensors of any shape. <weir/engine.hpp> documents
// the other members that a class may have.
#include <weir/engine.hpp>

#include <algorithm>
#include <span>

class MyFilter {
 public:
  static constexpr uint64_t kFlags = WEIR_ENGINE_NEEDS_NO_MODEL;

  // request.options has the pairs of custom=key:value. Throw weir::Failure for an error.
  explicit MyFilter(const weir::OpenRequest&) {
    bytes_.rank = WEIR_RANK_UNKNOWN;  // the stream decides
  }

  std::span<const weir_tensor_info> inputs() const { return {&bytes_, 1}; }
  std::span<const weir_tensor_info> outputs() const { return {&bytes_, 1}; }

  // The output has the input's shape.
  void resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out) {
    out[0].rank = in[0].rank;
    std::copy(std::begin(in[0].shape), std::end(in[0].shape), out[0].shape);
  }

  // Returns false to drop the frame.
  bool invoke(std::span<const weir_tensor> in, std::span<weir_tensor> out) {
    const auto x = weir::elements<const uint8_t>(in[0]);
    const auto y = weir::elements<uint8_t>(out[0]);
    for (size_t i = 0; i < x.size(); ++i) y[i] = static_cast<uint8_t>(255 - x[i]);
    return true;
  }

 private:
  weir_tensor_info bytes_ = weir::tensor_info("bytes", WEIR_UINT8, {});
};
WEIR_ENGINE(MyFilter, "my-filter", "1", "", "")
