// octet_stream decoder: outputs the bytes of each tensor as one memory, without its header.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "weir/decoder.hpp"

namespace {

class OctetStream {
 public:
  explicit OctetStream(const weir::Options&) {}

  void configure(std::span<const weir_tensor_info>, weir::DecoderOutput& output) {
    output.set_caps("application/octet-stream");
  }
  bool decode(const weir_frame& frame, weir::DecoderOutput& output) {
    for (uint32_t i = 0; i < frame.n_tensors; ++i) output.share_input(i);
    return true;
  }
};

}  // namespace

WEIR_DECODER(OctetStream, "octet_stream", "", "[]")
