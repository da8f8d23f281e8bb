// The engine my-engine: y = x + N for uint8 tensors of any shape, where N is the number in the
// model file. <weir/engine.hpp> documents the other members that a class may have.
#include <weir/engine.hpp>

#include <algorithm>
#include <fstream>
#include <span>
#include <string>

class MyEngine {
 public:
  // The keys of custom=key:value, which are checked before the model is opened.
  static constexpr const char* kOptions =
      R"([{"name": "times", "type": "integer", "default": "1", "help": "how often N is added"}])";

  // Opens a model. Throw weir::Failure for an error that users see as it is.
  explicit MyEngine(const weir::OpenRequest& request) {
    const std::string path = request.paths.front();
    std::ifstream file(path);
    int number = 0;
    if (!(file >> number))
      throw weir::Failure({.code = weir::Code::MODEL_INVALID,
                           .what = "the model cannot be read",
                           .offered = path,
                           .needed = "a text file with a number"});
    const std::string times(request.options.get("times").value_or("1"));
    added_ = static_cast<uint8_t>(number * std::stoi(times));
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
    for (size_t i = 0; i < x.size(); ++i) y[i] = static_cast<uint8_t>(x[i] + added_);
    return true;
  }

 private:
  uint8_t added_ = 0;
  weir_tensor_info bytes_ = weir::tensor_info("bytes", WEIR_UINT8, {});
};
// Name, version, other names and extensions of model files, each list with commas.
WEIR_ENGINE(MyEngine, "my-engine", "1", "", "")
