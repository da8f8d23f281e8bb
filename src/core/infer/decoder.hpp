// Decoder: an opened decoder of any module.
#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/infer/host.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::infer {

class Decoder {
 public:
  using Options = std::vector<std::pair<std::string, std::string>>;  // "option1", value
  static Result<std::unique_ptr<Decoder>> open(const weir_decoder_type& type,
                                               const Options& options);
  ~Decoder();
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  // The input's tensors are known; the decoder says its output caps through the sink.
  Status configure(const std::vector<weir_tensor_info>& inputs, weir_sink* sink);
  // true: the sink holds the output; false: the frame is dropped.
  Result<bool> decode(const weir_frame& frame, weir_sink* sink);
  // The frames that follow do not continue those before.
  void reset() noexcept;

 private:
  Decoder(const weir_decoder_type& type, weir_decoder* handle) : type_(type), handle_(handle) {}
  const weir_decoder_type& type_;
  weir_decoder* handle_;
};

}  // namespace weir::infer
