// Owning what a decoder's table gives.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/decoder.hpp"

namespace weir::infer {

Result<std::unique_ptr<Decoder>> Decoder::open(const weir_decoder_type& type,
                                               const Options& options) {
  std::vector<weir_option> pairs;
  for (const auto& [key, value] : options) pairs.push_back({key.c_str(), value.c_str()});
  weir_error error;
  weir_decoder* handle = nullptr;
  const int result =
      type.open(pairs.data(), static_cast<uint32_t>(pairs.size()), nullptr, &handle, &error);
  if (result < 0 || !handle)
    return take_error(&error, result < 0 ? result : -WEIR_INTERNAL, "the decoder cannot be opened");
  return std::unique_ptr<Decoder>(new Decoder(type, handle));
}

Decoder::~Decoder() {
  type_.close(handle_);
}

Status Decoder::configure(const std::vector<weir_tensor_info>& inputs, weir_sink* sink) {
  weir_error error;
  const int result = type_.configure(handle_, inputs.data(), static_cast<uint32_t>(inputs.size()),
                                     "", sink, &error);
  if (result < 0) return take_error(&error, result, "the decoder refuses these tensors");
  return ok();
}

Result<bool> Decoder::decode(const weir_frame& frame, weir_sink* sink) {
  weir_error error;
  const int result = type_.decode(handle_, &frame, sink, &error);
  if (result < 0) return take_error(&error, result, "the decoder failed on a frame");
  return result == 0;
}

void Decoder::reset() noexcept {
  if (type_.reset) type_.reset(handle_);
}

}  // namespace weir::infer
