// The decoder my-decoder: the mean of the bytes of each frame as a line of text.
// <weir/decoder.hpp> documents the other members that a class may have.
#include <weir/decoder.hpp>

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>

class MyDecoder {
 public:
  // The options of the element.
  explicit MyDecoder(const weir::Options&) {}

  // Says what comes out, for these inputs. Throw weir::Failure for inputs that do not fit.
  void configure(std::span<const weir_tensor_info> inputs, weir::DecoderOutput& output) {
    if (inputs.size() != 1 || inputs[0].type != WEIR_UINT8)
      throw weir::Failure({.code = weir::Code::SPEC_MISMATCH,
                           .what = "mode=my-decoder cannot decode this stream",
                           .offered = std::to_string(inputs.size()) + " tensors",
                           .needed = "one tensor of uint8"});
    output.set_caps("text/x-raw, format=(string)utf8");
  }

  // Returns false to drop the frame.
  bool decode(const weir_frame& frame, weir::DecoderOutput& output) {
    const std::span bytes(static_cast<const uint8_t*>(frame.tensors[0].data),
                          frame.tensors[0].bytes);
    uint64_t sum = 0;
    for (const uint8_t byte : bytes) sum += byte;
    const std::string text = std::to_string(bytes.empty() ? 0 : sum / bytes.size()) + "\n";
    const auto to = output.reserve(text.size());
    std::copy_n(reinterpret_cast<const std::byte*>(text.data()), text.size(), to.begin());
    return true;
  }
};
// Name, other names, options.
WEIR_DECODER(MyDecoder, "my-decoder", "", "[]")
